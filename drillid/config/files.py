"""The text and YAML files that users write, with faults named by line and remedy."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from drillid.errors import SettingsError

_WORKBOOKS = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
"""What the files of Excel begin with, as other archives do."""
_LARGEST_BYTES = 1_000_000
_LARGEST_NODES = 20_000
"""Keys and values of a file once its aliases are written out."""
_DEEPEST = 40
_BYTE_ORDER_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_TAGS_OF_KEYS = {"tag:yaml.org,2002:str", "tag:yaml.org,2002:merge"}
_QUOTE = "Put the text in quotation marks"
_REMEDIES = (
    (r"tab character|character '\\t'", "Indent with spaces; YAML takes no tabs"),
    (r"could not find expected ':'", "Write 'key: value', with a colon and a space"),
    (r"',' or '}'", "Separate 'key: value' pairs by commas, with a space after each colon, and close the brace"),
    (r"',' or ']'", "Separate the items by commas and close the bracket"),
    (r"unexpected end of stream", "Close the quotation marks"),
    (r"unknown escape", "Use single quotation marks, in which a backslash stands for itself, or forward slashes"),
    (r"cannot start any token", _QUOTE),
    (r"expected key|block end|'-' indicator", "Begin the keys and items of one level in the same column"),
    (r"undefined alias", f"Define its anchor before, or, where a text begins with '*': {_QUOTE.lower()}"),
    (r"constructor for the tag", f"Leave the tag out, or, where a text begins with '!': {_QUOTE.lower()}"),
    (r"single document", "Keep one description in a file, without lines '---'"),
    (r"node content", "Write the missing value, or remove a superfluous comma"),
    (r"", "Correct this line"),
)
"""What to do, by YAML's own words on a fault; the first that fits."""


def read_text(path: str | Path, largest_bytes: int = _LARGEST_BYTES) -> str:
    """Text of a file in UTF-8, or in UTF-16 with its mark.

    Parameters
    ----------
    largest_bytes : beyond which it cannot be what was meant

    Raises
    ------
    SettingsError
        If the file cannot be read, is too large or in another encoding.
    """
    try:
        content = Path(path).read_bytes()
    except IsADirectoryError as error:
        raise SettingsError(str(path), "is a folder, not a file", "Name the file in it") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SettingsError(str(path), f"cannot be read ({reason})", "Write the file, or correct its path") from error
    if content.startswith(_WORKBOOKS):
        raise SettingsError(str(path), "is a workbook or an archive, not text", "Save it as text, a sheet with tabs")
    if len(content) > largest_bytes:
        what = f"has {len(content)} bytes, more than {largest_bytes}"
        raise SettingsError(str(path), what, "Check that it is the file that was meant")
    encoding = _BYTE_ORDER_MARKS.get(content[:2], "utf-8-sig")
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        raise _other_encoding(path, content, error.start) from error


def _other_encoding(path: str | Path, content: bytes, position: int) -> SettingsError:
    line = content.count(b"\n", 0, position) + 1
    begin, end = content.rfind(b"\n", 0, position) + 1, content.find(b"\n", position)
    text = content[begin : end if end >= 0 else None].decode("latin-1").strip()
    what = f"is not in UTF-8: byte 0x{content[position]:02X}"
    if text.isprintable():
        what += f"; in Latin-1 the line reads '{text[:60]}'"
    remedy = f"Save it as UTF-8 in the editor, or convert it: iconv -f LATIN1 -t UTF-8 {Path(path).name} > new"
    return SettingsError(f"{path}, line {line}", what, remedy)


def read_yaml(path: str | Path) -> Any:
    """Content of a YAML file.

    Raises
    ------
    SettingsError
        As `read_text` and `parse_yaml`.
    """
    return parse_yaml(read_text(path), path)


def parse_yaml(text: str, where: str | Path) -> Any:
    """Content of a YAML text, by the core schema of YAML 1.2: only true and false are logical, dates are text.

    Raises
    ------
    SettingsError
        If the text is not valid YAML, holds a key twice or a tag, or grows beyond measure by its aliases; the message
        names line and column.
    """
    loader: Any = None
    try:
        _check_depth(text, where)
        loader = _loader()(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _Check(where, loader).size(node)
        return loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        raise _fault(error, text, where) from error
    except yaml.reader.ReaderError as error:
        what = (
            f"holds the control character #x{error.character:04x}" if isinstance(error.character, int) else str(error)
        )
        line = text.count("\n", 0, error.position) + 1
        raise SettingsError(f"{where}, line {line}", what, "Remove it") from error
    finally:
        if loader is not None:
            loader.dispose()


@functools.cache
def _loader() -> type[Any]:
    """A safe loader; the parser written in C is ten times faster."""

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012

    for tag, pattern, first in (
        ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
        ("int", "[-+]?(?:0|[1-9][0-9]*)", "-+0123456789"),
        (
            "float",
            r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
            "-+.0123456789",
        ),
        ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
        ("merge", "<<", "<"),
    ):
        Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"), list(first))
    return Loader


def _check_depth(text: str, where: str | Path) -> None:
    """Refuse what nests too deeply, before anything works on it recursively."""
    depth = 0
    for event in yaml.parse(text, _loader()):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > _DEEPEST:
                raise _too_much(where, event.start_mark, f"nests more than {_DEEPEST} levels deep")
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


class _Check:
    """Sizes of nodes with their aliases written out; on the way keys that are there twice or are no text, and values
    that are not what their tags say.
    """

    def __init__(self, where: str | Path, loader: Any) -> None:
        self.where, self.loader = where, loader
        self.sizes: dict[int, int] = {}
        self.open: set[int] = set()

    def size(self, node: yaml.Node) -> int:
        """Keys and values in a node.

        Raises
        ------
        SettingsError
            If there are too many, if the node holds itself, or a key twice, or a key that is no text, or a value that
            cannot be read.
        """
        if id(node) in self.open or len(self.open) > _DEEPEST:
            raise _too_much(self.where, node.start_mark, "holds an alias of itself")
        if id(node) not in self.sizes:
            self.open.add(id(node))
            self._check_keys(node)
            self._check_value(node)
            self.sizes[id(node)] = 1 + sum(map(self.size, _children(node)))
            self.open.remove(id(node))
        if self.sizes[id(node)] > _LARGEST_NODES:
            what = f"holds more than {_LARGEST_NODES} values with its aliases expanded"
            raise _too_much(self.where, node.start_mark, what)
        return self.sizes[id(node)]

    def _check_keys(self, node: yaml.Node) -> None:
        seen: dict[str, int] = {}
        for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            line = key.start_mark.line + 1
            if key.tag not in _TAGS_OF_KEYS:
                what = f"the key '{key.value}' is not text" if isinstance(key, yaml.ScalarNode) else "a key is not text"
                raise SettingsError(f"{self.where}, line {line}", what, _QUOTE)
            if key.value in seen:
                what = f"the key '{key.value}' is already given in line {seen[key.value]}"
                raise SettingsError(f"{self.where}, line {line}", what, "Keep one of the two")
            seen[key.value] = line

    def _check_value(self, node: yaml.Node) -> None:
        """Refuse a value that is not what its tag says, or has more digits than can be read."""
        if not isinstance(node, yaml.ScalarNode) or node.tag in _TAGS_OF_KEYS:
            return
        try:
            self.loader.construct_object(node)
        except (ValueError, KeyError, IndexError) as error:
            what = f"'{node.value[:40]}' cannot be read as {node.tag.rsplit(':', 1)[-1]}"
            remedy = "Correct it, and leave out tags such as !!int"
            raise SettingsError(f"{self.where}, line {node.start_mark.line + 1}", what, remedy) from error


def _children(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for pair in node.value:
            yield from pair
    elif isinstance(node, yaml.SequenceNode):
        yield from node.value


def _too_much(where: str | Path, mark: Any, what: str) -> SettingsError:
    remedy = "Check that it is the file that was meant, and write its content out, without aliases"
    return SettingsError(f"{where}, line {mark.line + 1}", what, remedy)


def _fault(error: yaml.MarkedYAMLError, text: str, where: str | Path) -> SettingsError:
    """YAML's own error with its place and a remedy that fits."""
    problem = f"{error.problem or error.context}"
    mark = error.problem_mark or error.context_mark
    place = str(where) if mark is None else f"{where}, line {mark.line + 1}, column {mark.column + 1}"
    if "nesting depth" in problem and mark is not None:
        return _too_much(where, mark, f"nests more than {_DEEPEST} levels deep")
    if "mapping values are not allowed" in problem and mark is not None:
        return SettingsError(place, "is not valid YAML (a key where none is allowed)", _remedy_of_key(text, mark.line))
    remedy = next(remedy for pattern, remedy in _REMEDIES if re.search(pattern, f"{problem} {error.context}"))
    if error.context_mark is not None and error.context and error.context_mark.line != getattr(mark, "line", None):
        problem += f", {error.context} from line {error.context_mark.line + 1}"
    return SettingsError(place, f"is not valid YAML ({problem})", remedy)


def _remedy_of_key(text: str, line: int) -> str:
    """What to do about a key in a line, counted from 0, where YAML expects none."""
    lines = text.splitlines()
    if len(re.findall(r":(?:\s|$)", lines[line])) > 1:
        return "Put the text with a colon in it in quotation marks"
    before = next((number for number in range(line - 1, -1, -1) if lines[number].split("#")[0].strip()), None)
    if before is not None and not re.search(r":(?:\s|$)", lines[before]):
        return f"Write a colon and a space after the key in line {before + 1}, '{lines[before].strip()[:40]}'"
    return "Begin the keys of one level in the same column; one that holds others has no value in its own line"
