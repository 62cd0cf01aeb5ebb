"""Signs of several windows at the shape that all share: the moment of a jump, the line of a tone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import gammaincc, ndtr, ndtri_exp
from scipy.stats import binom

from drillid.discrepancy.evidence import STANDS_OUT, Lines, Sign


def at_one_shape(own: Sequence[Sign]) -> tuple[list[Sign], float] | None:
    """Signs at the shape at which the weighted sum of scores is largest, and the chance of that by Bonferroni.

    None where they have no shapes in common.
    """
    shapes = {len(sign.by_shape) for sign in own}
    if len(shapes) > 1 or shapes == {0}:
        return None
    size, error = np.moveaxis(np.array([sign.by_shape for sign in own]), -1, 0)
    told = np.isfinite(size) & (error > 0)
    weight = np.where(told, 1 / np.where(told, error, 1.0), 0.0)
    normal = np.where(told, size, 0.0) * weight
    total = np.abs(np.sum(weight * normal, axis=0)) / np.maximum(np.sqrt(np.sum(weight**2, axis=0)), 1e-300)
    best = int(np.argmax(total))
    return [_at(sign, best) for sign in own], min(1.0, total.size * 2 * float(ndtr(-total[best])))


def _at(sign: Sign, shape: int) -> Sign:
    """A sign at a shape; itself where its record bears none there, or told its size by following the change whole."""
    size, error = sign.by_shape[shape]
    if not (np.isfinite(size) and error > 0 and np.isnan(sign.misfit)):
        return sign
    return replace(sign, score=abs(size / error), size=size, size_error=error, log_ratio=0.5 * (size / error) ** 2)


def at_one_line(own: Sequence[Sign]) -> tuple[list[Sign], float] | None:
    """Signs at the line that stands out most over all windows, and the chance of that by Bonferroni.

    In noise a line stands out in a binomial number of windows, and what is beyond STANDS_OUT there is exponential. None
    where windows have no lines, or are of different lengths, so that their lines have other frequencies.
    """
    lines = [sign.lines for sign in own if sign.lines is not None]
    if len(lines) < len(own) or len({one.spacing for one in lines}) > 1:
        return None
    total = np.zeros(max(int(one.place.max(initial=0)) for one in lines) + 1)
    for one in lines:
        total[one.place] += one.log_ratio - STANDS_OUT
    best, number = int(np.argmax(total)), np.arange(1, len(own) + 1)
    chance = float(np.sum(binom.pmf(number, len(own), np.exp(-STANDS_OUT)) * gammaincc(number, total[best])))
    found = [_at_line(sign, one, best) for sign, one in zip(own, lines, strict=True)]
    plain = [
        bool(np.isfinite(sign.size_error) and abs(one.strongest - best) <= 1)
        for sign, one in zip(own, lines, strict=True)
    ]
    if 2 * sum(plain) >= len(plain):
        # most windows show the tone by themselves and tell its size best; few of many would be those with most noise
        found = [
            replace(at, size=sign.size, size_error=sign.size_error) if shows else at
            for at, sign, shows in zip(found, own, plain, strict=True)
        ]
    return found, min(1.0, max(one.tried for one in lines) * chance)


def _at_line(sign: Sign, lines: Lines, place: int) -> Sign:
    """A sign at a line; without a size where nothing stands out."""
    found = np.flatnonzero(lines.place == place)
    if not found.size:
        return replace(sign, score=0.0, size=0.0, size_error=np.inf, log_ratio=0.0)
    ratio, size, error = (float(values[found[0]]) for values in (lines.log_ratio, lines.size, lines.size_error))
    return replace(sign, score=-float(ndtri_exp(-ratio)), size=size, size_error=error, log_ratio=ratio)
