"""Detections of all windows, taken together cause by cause."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, gammaincc, log_ndtr, ndtr, ndtri_exp
from scipy.stats import binom

from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.detection import Detection, Lines
from drillid.discrepancy.predictive_gain import NO_PREDICTIVE_GAIN, PredictiveGain
from drillid.discrepancy.rules import AGAINST, LINE_KEPT, SCATTER_RATE


@dataclass(frozen=True)
class PooledDetection:
    """What the detections of one cause say over the set."""

    cause: str
    p_value: float
    """Of so strong detections where the cause is absent: of their sum, or of the strongest."""
    log_evidence: float
    """Log Bayes factor of the cause that this p-value stands for."""
    size: float
    size_error: float
    windows: int
    closure: float = 1.0
    """Chance of so much that the cause leaves unexplained where it is what is there."""
    apart: float = 0.0
    """Standard deviations between what it and the other way of the same change say of all windows that tell it."""

    def evidence_for(self, size: float) -> float:
        """Log-likelihood ratio of the detections for a size that the linear responses show, against none.

        No more in favour than the p-value stands for; against it by what the sizes disagree, within AGAINST.
        """
        if not (np.isfinite(self.size_error) and self.size_error > 0):
            return self.log_evidence
        ratio = (self.size**2 - (self.size - size) ** 2) / (2 * self.size_error**2)
        return float(np.clip(ratio, -AGAINST, max(self.log_evidence, 0.0)))


def pool(detections: Sequence[Detection]) -> list[PooledDetection]:
    """One entry a cause, most certain first.

    A cause may be present in all windows or in few, so both the sum of scores (Stouffer 1949), weighted by how well
    each window tells the size, and the largest (Šidák 1967) are looked at, and the smaller p-value is doubled. In the
    sum windows that show sizes of opposite sign speak against each other. Where a cause has shapes, such as the moment
    of a jump or the line of a tone, each window's own is looked at and the one that all share, and the smallest of the
    p-values counts thrice.
    """
    pooled = []
    for cause in sorted({detection.cause for detection in detections}):
        own = [detection for detection in detections if detection.cause == cause and np.isfinite(detection.score)]
        if own:
            pooled.append(_pooled(cause, own))
    return sorted(pooled, key=lambda one: one.p_value)


def _pooled(cause: str, own: Sequence[Detection]) -> PooledDetection:
    own, p_value = _seen(own)
    weight = np.array(
        [1 / max(detection.size_error, 1e-300) ** 2 if detection.size_error > 0 else 0.0 for detection in own]
    )
    weight = np.where(np.isfinite(weight), weight, 0.0)
    size = np.array([detection.size for detection in own])
    known = weight.sum() > 0
    size = np.where(weight > 0, size, 0.0) if known else size
    mean = float(np.sum(weight * size) / weight.sum()) if known else float(np.median(size))
    # the windows' sizes may differ by more than their errors say
    spread = float(np.sum(weight * (size - mean) ** 2) / max(len(own) - 1, 1)) if known else 1.0
    error = float(np.sqrt(max(spread, 1.0) / weight.sum())) if known else float("nan")
    return PooledDetection(
        cause, p_value, evidence_of_p_value(p_value), mean, error, len(own), _closure(own), _apart(own)
    )


def _seen(own: Sequence[Detection]) -> tuple[Sequence[Detection], float]:
    """Detections of one cause as they are or at the shape that all windows share, where those say more; and their
    p-value.
    """
    score = np.array([detection.score for detection in own])
    strongest = float(-np.expm1(score.size * log_ndtr(score.max())))
    each = min(_p_value_of_sum(own), strongest)
    found = at_one_line(own) or at_one_shape(own) if len(own) > 1 else None
    if found is None:
        return own, min(1.0, 2 * each)
    joined, shared = found
    return (joined if shared < each else own), min(1.0, 3 * min(each, shared))


def _closure(own: Sequence[Detection]) -> float:
    """Chance of misfits so large in all windows that were asked (Fisher 1932); 1 where none was."""
    misfit = np.array([detection.misfit for detection in own])
    logs = log_ndtr(-misfit[np.isfinite(misfit)])
    return float(chdtrc(2 * logs.size, -2 * logs.sum())) if logs.size else 1.0


def _apart(own: Sequence[Detection]) -> float:
    """Standard deviations between two ways of a change over all windows that tell it; 0 where none does."""
    return float(np.sqrt(np.nansum([detection.apart**2 for detection in own])))


def _p_value_of_sum(own: Sequence[Detection]) -> float:
    """Of so large a weighted sum of scores; of either sign where the cause's size may have either."""
    score, size, error = (
        np.array([getattr(detection, name) for detection in own]) for name in ("score", "size", "size_error")
    )
    told = np.isfinite(error) & (error > 0) & np.isfinite(size)
    weight = 1 / error if told.all() else np.ones(score.size)
    norm = float(np.sqrt(np.sum(weight**2)))
    one_sided = own[0].cause not in CATALOGUE or CATALOGUE[own[0].cause].size.low >= 0
    if one_sided or not told.all():
        return float(ndtr(-np.sum(weight * score) / norm))
    # a score of either sign has half its p-value on the side on which its size lies
    signed = -np.sign(size) * ndtri_exp(log_ndtr(-score) - np.log(2.0))
    return float(2 * ndtr(-abs(np.sum(weight * signed)) / norm))


def evidence_of_p_value(p_value: float) -> float:
    """Log Bayes factor that a p-value under the null can at most stand for, 1/(−e p ln p) (Sellke, Bayarri and Berger
    2001, American Statistician 55, 62–71); 0 from 1/e on.
    """
    if p_value >= np.exp(-1.0):
        return 0.0
    log = np.log(max(p_value, 1e-300))
    return float(-1.0 - log - np.log(-log))


def detection_gain(detections: Sequence[Detection]) -> PredictiveGain:
    """Log score of each window with the size that the other windows show, and its error, less without the cause.

    About its best size the log-likelihood of a window is taken as a parabola. A window without another that tells the
    size has its own log-likelihood ratio less one, for the size fitted to it (Akaike 1974).
    """
    if not detections:
        return NO_PREDICTIVE_GAIN
    detections, _ = _seen(detections)
    ratio = np.maximum([detection.log_ratio for detection in detections], 0.0)
    size, error = (
        np.array([detection.size for detection in detections]),
        np.array([detection.size_error for detection in detections]),
    )
    told = np.isfinite(size) & np.isfinite(error) & (error > 0)
    weight = np.where(told, 1 / np.where(told, error, 1.0) ** 2, 0.0)
    size = np.where(told, size, 0.0)
    mean = float(np.sum(weight * size)) / max(float(np.sum(weight)), 1e-300)
    # windows whose sizes differ by more than their errors, and not by chance, have larger errors
    freedom, scatter = max(int(told.sum()) - 1, 1), float(np.sum(weight * (size - mean) ** 2))
    spread = scatter / freedom if chdtrc(freedom, scatter) < SCATTER_RATE else 1.0
    rest = np.sum(weight) - weight
    predicted = rest > 1e-9 * weight
    rest = np.where(predicted, rest, np.inf)
    others = (np.sum(weight * size) - weight * size) / rest
    # the others' size has an error of its own, which widens what they predict
    unsure = weight / rest
    missed = 0.5 * weight * (others - size) ** 2 / (spread * (1 + unsure)) + 0.5 * np.log1p(unsure)
    missed = np.where(predicted, missed, 1.0)
    ratio = np.where(predicted, ratio / spread, ratio)
    gains = ratio - missed
    # a log-likelihood ratio has twice its mean as variance, as the others' size tells it with an error of its own
    share = np.divide(others, size, out=np.zeros_like(size), where=size != 0)
    variance = np.where(predicted, 2 * ratio * share**2 + unsure, 2 * np.maximum(ratio, 0.5))
    error_of_mean = float(np.sqrt(variance.sum())) / ratio.size
    value = float(gains.mean())
    held_out = ratio.size if ratio.size > 1 else 0
    return PredictiveGain(value, error_of_mean, held_out)


def at_one_shape(own: Sequence[Detection]) -> tuple[list[Detection], float] | None:
    """Detections at the shape at which the weighted sum of scores is largest, and the p-value of that by Bonferroni.

    None where they have no shapes in common.
    """
    shapes = {len(detection.by_shape) for detection in own}
    if len(shapes) > 1 or shapes == {0}:
        return None
    size, error = np.moveaxis(np.array([detection.by_shape for detection in own]), -1, 0)
    told = np.isfinite(size) & (error > 0)
    weight = np.where(told, 1 / np.where(told, error, 1.0), 0.0)
    normal = np.where(told, size, 0.0) * weight
    total = np.abs(np.sum(weight * normal, axis=0)) / np.maximum(np.sqrt(np.sum(weight**2, axis=0)), 1e-300)
    best = int(np.argmax(total))
    return [_at(detection, best) for detection in own], min(1.0, total.size * 2 * float(ndtr(-total[best])))


def _at(detection: Detection, shape: int) -> Detection:
    """A detection at a shape; itself where its record bears none there, or the change was followed as a whole."""
    size, error = detection.by_shape[shape]
    if not (np.isfinite(size) and error > 0 and np.isnan(detection.misfit)):
        return detection
    return replace(detection, score=abs(size / error), size=size, size_error=error, log_ratio=0.5 * (size / error) ** 2)


def at_one_line(own: Sequence[Detection]) -> tuple[list[Detection], float] | None:
    """Detections at the line that stands out most over all windows, and the p-value of that by Bonferroni.

    In noise a line stands out in a binomial number of windows, and what is beyond LINE_KEPT there is exponential. None
    where windows have no lines, or are of different lengths, so that their lines have other frequencies.
    """
    lines = [detection.lines for detection in own if detection.lines is not None]
    if len(lines) < len(own) or len({one.spacing for one in lines}) > 1:
        return None
    total = np.zeros(max(int(one.place.max(initial=0)) for one in lines) + 1)
    for one in lines:
        total[one.place] += one.log_ratio - LINE_KEPT
    best, number = int(np.argmax(total)), np.arange(1, len(own) + 1)
    p_value = float(np.sum(binom.pmf(number, len(own), np.exp(-LINE_KEPT)) * gammaincc(number, total[best])))
    found = [_at_line(detection, one, best) for detection, one in zip(own, lines, strict=True)]
    plain = [
        bool(np.isfinite(detection.size_error) and abs(one.strongest - best) <= 1)
        for detection, one in zip(own, lines, strict=True)
    ]
    if 2 * sum(plain) >= len(plain):
        # most windows show the tone by themselves and tell its size best; few of many would be those with most noise
        found = [
            replace(at, size=detection.size, size_error=detection.size_error) if shows else at
            for at, detection, shows in zip(found, own, plain, strict=True)
        ]
    return found, min(1.0, max(one.tried for one in lines) * p_value)


def _at_line(detection: Detection, lines: Lines, place: int) -> Detection:
    """A detection at a line; without a size where nothing stands out."""
    found = np.flatnonzero(lines.place == place)
    if not found.size:
        return replace(detection, score=0.0, size=0.0, size_error=np.inf, log_ratio=0.0)
    ratio, size, error = (float(values[found[0]]) for values in (lines.log_ratio, lines.size, lines.size_error))
    return replace(detection, score=-float(ndtri_exp(-ratio)), size=size, size_error=error, log_ratio=ratio)
