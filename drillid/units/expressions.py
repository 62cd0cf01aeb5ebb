"""Products of units in text: 'kN.m', 'ft-lbf', '1000 lbf', 'm³/h', 'N m/(rad/s)'. Nothing else is evaluated."""

from __future__ import annotations

import functools
import itertools
import re
import unicodedata
from collections.abc import Iterator

from drillid.units.names import NUMBER, Unit, named

_REWRITTEN = tuple(
    (re.compile(pattern, re.IGNORECASE), text)
    for pattern, text in (
        (r"^\(([^()]*)\)$|^\[([^\[\]]*)\]$", r"\1\2"),
        (r"\br\.\s*p\.\s*m\b\.?", "rpm"),
        (r"\b([lgbr])/pm\b", r"\1pm"),
        (r"\bmetric[ _*-]*tons?\b|\bm\.t\b\.?", "t"),
        (r"\bshort[ _*-]*tons?\b", "tonUS"),
        (r"\blong[ _*-]*tons?\b", "tonUK"),
        (r"\b(pounds?|lbs?|tonne|ton|t)[- ]?(force|f)\b", r"\1f"),
        (r"\b(?:pounds?|lbs)f\b", "lbf"),
        (r"\b(gal|ton|tonf|ft)(?:lons?|s)?[ .]?[\[(]?(US|UK)\b[\])]?", r"\1\2"),
        (r"\b(US|UK)[ .]?(gal|ton|tonf)(?:lons?|s)?\b", r"\2\1"),
        (r"\bU\.S\.", "US"),
        (r"\bimp(?:erial)?[ .]*gal(?:lons?)?\b", "galUK"),
        (r"\bsq\.? ?([a-z]+)", r"\1^2"),
        (r"\bcu\.? ?([a-z]+)", r"\1^3"),
        (r"\bkgm(?=\^?2)", "kg*m"),
        (r"\bkgm(?=\^?3)", "kg/m"),
        (r"\b(lbf?|slug)ft(?=\^?2)", r"\1*ft"),
        (r"\*?\bper\b\*?", "/"),
        (r"^x ?(?=10)", ""),
        (r"\bx ?(?=10)| x ", "*"),
        (r"\.(?=/|\)|$)", ""),
    )
)
"""Spellings that follow no rule."""
_LONGEST = 60
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_SIGNS = {"·": "*", "⋅": "*", "∙": "*", "•": "*", "×": "*", "_": "*", "−": "-", "–": "-", "‐": "-", "‑": "-"}
_SIGNS |= {"µ": "μ", "º": "°", "″": '"', "”": '"', "′": "'", "’": "'"}
_TOKEN = re.compile(
    r"""\s*(?:(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d{1,2})?)
    |(?P<name>[^\W\d_]+|[%°"'\#])
    |(?P<power>(?:\^|\*\*)\s*(?:-?\d+|\(\s*-?\d+\s*\)))
    |(?P<sign>[*/().-]))""",
    re.VERBOSE,
)
_BARE_POWER = re.compile(r"-?\d(?!\d|\.\d)")


@functools.cache
def meanings_of(text: str) -> tuple[Unit, ...]:
    """What a unit may mean: one thing, unless its letters are in a case that fits several.

    Raises
    ------
    ValueError
        If the text is too long, is no product of units, or holds an unknown or unclear name.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"the unit '{text[:_LONGEST]}…' is longer than {_LONGEST} characters")
    parser = _Parser(text)
    meanings = parser.product()
    if parser.tokens or not all(1e-15 < unit.factor < 1e15 for unit in meanings):
        raise parser.fault()
    return meanings


def _plain(text: str) -> str:
    """The unit in the signs that the parser knows."""
    plain = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", lambda match: "^" + match[0].translate(_SUPERSCRIPTS), text)
    plain = unicodedata.normalize("NFKC", "".join(_SIGNS.get(sign, sign) for sign in plain)).strip()
    plain = "".join(_SIGNS.get(sign, sign) for sign in plain)
    for pattern, replacement in _REWRITTEN:
        plain = pattern.sub(replacement, plain)
    return plain.strip()


class _Parser:
    """Products of names with small powers, from left to right."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = list(self._tokens(_plain(text)))
        if not self.tokens:
            raise self.fault()

    def _tokens(self, plain: str) -> Iterator[tuple[str, str]]:
        position = 0
        while position < len(plain):
            match = _TOKEN.match(plain, position)
            if match is None:
                raise self.fault()
            kind = str(match.lastgroup)
            yield kind, match[kind]
            position = match.end()
            power = _BARE_POWER.match(plain, position) if kind == "name" else None
            if power is not None:
                yield "power", power[0]
                position = power.end()

    def fault(self) -> ValueError:
        """Why the text is no unit."""
        return ValueError(f"'{self.text}' is not a unit, which is a product of names such as 'kN m' or 'm3/h'")

    def product(self) -> tuple[Unit, ...]:
        """Factors up to the end or the closing parenthesis."""
        found = self._next_factor("/")
        while self.tokens and self.tokens[0] != ("sign", ")"):
            pairs = itertools.product(found, self._next_factor("/*.-"))
            found = tuple(one * other for one, other in pairs)
        return found

    def _next_factor(self, signs: str) -> tuple[Unit, ...]:
        sign = next((sign for sign in signs if self._taken(sign)), "*")
        return tuple(unit.to(-1 if sign == "/" else 1) for unit in self.factor())

    def _taken(self, sign: str) -> bool:
        there = bool(self.tokens) and self.tokens[0] == ("sign", sign)
        if there:
            self.tokens.pop(0)
        return there

    def factor(self) -> tuple[Unit, ...]:
        """A number, a name or a product in parentheses, with its power."""
        if self._taken("("):
            found = self.product()
            if not self._taken(")"):
                raise self.fault()
        elif self.tokens and self.tokens[0][0] in ("number", "name"):
            kind, text = self.tokens.pop(0)
            found = named(text, self.text) if kind == "name" else (Unit(float(text), NUMBER),)
            if not all(1e-12 < unit.factor < 1e12 for unit in found):
                raise self.fault()
        else:
            raise self.fault()
        if self.tokens and self.tokens[0][0] == "power":
            power = int(re.sub(r"[^\d-]", "", self.tokens.pop(0)[1]))
            if abs(power) > 9 or any(not 1e-30 < unit.factor ** abs(power) < 1e30 for unit in found):
                raise self.fault()
            found = tuple(unit.to(power) for unit in found)
        return found
