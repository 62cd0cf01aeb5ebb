"""Detections of all windows, pooled cause by cause."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, gammainc, gammaincc, log_ndtr, ndtr, ndtri_exp

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.detection import Detection, SpectralLines
from drillid.discrepancy.detectors.detector import Detector
from drillid.discrepancy.predictive_gain import NO_PREDICTIVE_GAIN, PredictiveGain
from drillid.discrepancy.rules import CLEAR_DETECTION, IMAGES_RATE, LARGEST_COUNTEREVIDENCE, LINE_KEPT, SCATTER_RATE

_STRONGEST, _LEAKAGE = 20, 6
"""Number of strongest lines that show images of the sweep, and half lines by which they are apart at least."""


@dataclass(frozen=True)
class PooledDetection:
    """Evidence of all detections of one cause over a set of windows."""

    cause: str
    p_value: float
    """Probability of detections at least as strong where the cause is absent: of their sum, or of the strongest."""
    log_evidence: float
    """Upper bound on the log Bayes factor of the cause, from the p-value."""
    size: float
    size_error: float
    windows: int
    closure: float = 1.0
    """p-value of the misfit that the cause leaves where it is the true one."""
    separation: float = 0.0
    """Standard deviations, over all windows, between the records predicted by this and by the other course of the same
    parameter."""

    @property
    def least_shown(self) -> float:
        """Least share of the cause's size that the detections may show."""
        return _detector(self.cause).least_shown

    @property
    def tells_size(self) -> bool:
        """Whether they speak for the cause and tell its size, whatever law it follows."""
        return self.log_evidence > 0 and bool(np.isfinite(self.size_error)) and self.least_shown == 1

    def evidence_for(self, size: float, size_error: float = 0.0) -> float:
        """Log-likelihood ratio of the detections for the size found in the linear responses, against size zero: at the
        likeliest size by both, less what the responses lose there.

        In favour it is bounded by the evidence of the p-value, against by LARGEST_COUNTEREVIDENCE. Where the law of the
        cause is not known, the share of its size that the detections show is the likeliest.

        Parameters
        ----------
        size_error : of the size found in the linear responses
        """
        if not (np.isfinite(self.size_error) and self.size_error > 0):
            return self.log_evidence
        low, high = sorted((self.least_shown * size, size))
        shown = float(np.clip(self.size, low, high))
        apart = (self.size - shown) ** 2 / (self.size_error**2 + size_error**2)
        ratio = ((self.size / self.size_error) ** 2 - apart) / 2
        return float(np.clip(ratio, -LARGEST_COUNTEREVIDENCE, max(self.log_evidence, 0.0)))


def pool(detections: Sequence[Detection]) -> list[PooledDetection]:
    """Pooled detections, one for each cause, smallest p-value first.

    A cause may be present in all windows or in few, so both the sum of scores (Stouffer 1949), weighted by the inverse
    error of each window's size, and the largest (Šidák 1967) are tested, and the smaller p-value is doubled. In the sum
    sizes of opposite sign cancel. Where a cause has shapes, such as the moment of a jump or the line of a tone, both
    each window's own shape and a common one are tested, and the smallest p-value is tripled (Bonferroni).
    """
    pooled = []
    for cause in sorted({detection.cause for detection in detections}):
        own = [detection for detection in detections if detection.cause == cause and np.isfinite(detection.score)]
        if own:
            pooled.append(_pooled(cause, own))
    return sorted(pooled, key=lambda detection: detection.p_value)


def _pooled(cause: str, own: Sequence[Detection]) -> PooledDetection:
    own, p_value = _at_better_shape(own)
    own = _telling_sizes(own)
    weight = np.array(
        [1 / max(detection.size_error, 1e-300) ** 2 if detection.size_error > 0 else 0.0 for detection in own]
    )
    weight = np.where(np.isfinite(weight), weight, 0.0)
    size = np.array([detection.size for detection in own])
    known = weight.sum() > 0
    size = np.where(weight > 0, size, 0.0) if known else size
    mean = float(np.sum(weight * size) / weight.sum()) if known else float(np.median(size))
    # the windows' sizes may scatter by more than their stated errors
    spread = float(np.sum(weight * (size - mean) ** 2) / max(int(np.count_nonzero(weight)) - 1, 1)) if known else 1.0
    detector = _detector(cause)
    error = float(np.hypot(np.sqrt(max(spread, 1.0) / weight.sum()), detector.accuracy * mean)) if known else np.nan
    p_value = 1.0 if known and abs(mean) < detector.least else p_value
    return PooledDetection(
        cause, p_value, evidence_of_p_value(p_value), mean, error, len(own), _closure(own), _separation(own)
    )


def _detector(cause: str) -> Detector:
    """The detector of a cause, which tells how far its sizes hold; any for a symptom, which has no size of a cause."""
    own = CATALOGUE[cause].detector if cause in CATALOGUE else None
    return own or Detector()


def _telling_sizes(own: Sequence[Detection]) -> Sequence[Detection]:
    """The detections; where a cause acts only beyond its size, and does so clearly in some windows, the others tell
    neither size nor gain.
    """
    is_clear = [detection.score >= CLEAR_DETECTION for detection in own]
    if not _detector(own[0].cause).acts_beyond or not any(is_clear):
        return own
    return [
        one if clear else replace(one, size=np.nan, size_error=np.inf, log_ratio=0.0)
        for one, clear in zip(own, is_clear, strict=True)
    ]


def _at_better_shape(own: Sequence[Detection]) -> tuple[Sequence[Detection], float]:
    """Detections of one cause at each window's own shape or at a common one, whichever is more significant; and their
    p-value.
    """
    score = np.array([detection.score for detection in own])
    strongest = float(-np.expm1(score.size * log_ndtr(score.max())))
    smaller = min(_p_value_of_sum(own), strongest)
    common = at_common_line(own) or at_common_shape(own) if len(own) > 1 else None
    if common is None:
        return own, min(1.0, 2 * smaller)
    at_common, shared = common
    return (at_common if shared < smaller else own), min(1.0, 3 * min(smaller, shared))


def _closure(own: Sequence[Detection]) -> float:
    """Combined p-value of the misfits of all windows in which it was tested (Fisher 1932); 1 where it was in none."""
    misfit = np.array([detection.misfit for detection in own])
    logs = log_ndtr(-misfit[np.isfinite(misfit)])
    return float(chdtrc(2 * logs.size, -2 * logs.sum())) if logs.size else 1.0


def _separation(own: Sequence[Detection]) -> float:
    """Standard deviations between the two courses of a parameter over all windows; 0 where none has two."""
    return float(np.sqrt(np.nansum([detection.separation**2 for detection in own])))


def _p_value_of_sum(own: Sequence[Detection]) -> float:
    """p-value of the weighted sum of scores; two-sided where the cause's size may have either sign."""
    score, size, error = (
        np.array([getattr(detection, name) for detection in own]) for name in ("score", "size", "size_error")
    )
    has_size = np.isfinite(error) & (error > 0) & np.isfinite(size)
    weight = 1 / error if has_size.all() else np.ones(score.size)
    norm = float(np.sqrt(np.sum(weight**2)))
    one_sided = own[0].cause not in CATALOGUE or CATALOGUE[own[0].cause].size.low >= 0
    if one_sided or not has_size.all():
        return float(ndtr(-np.sum(weight * score) / norm))
    # a two-sided score has half its p-value on the side of its size
    signed = -np.sign(size) * ndtri_exp(log_ndtr(-score) - np.log(2.0))
    return float(2 * ndtr(-abs(np.sum(weight * signed)) / norm))


def evidence_of_p_value(p_value: float) -> float:
    """Upper bound on the log Bayes factor against the null hypothesis from its p-value, 1/(−e p ln p) (Sellke, Bayarri
    and Berger 2001, American Statistician 55, 62–71); 0 for p-values of 1/e or more.
    """
    if p_value >= np.exp(-1.0):
        return 0.0
    log = np.log(max(p_value, 1e-300))
    return float(-1.0 - log - np.log(-log))


def detection_gain(detections: Sequence[Detection]) -> PredictiveGain:
    """Mean log score of a window with the size estimated from the other windows, less that without the cause.

    The log-likelihood of a window is approximated by a parabola about its best size. Where no other window gives a
    size, it is the window's own log-likelihood ratio less one, for the size fitted to it (Akaike 1974).
    """
    if not detections:
        return NO_PREDICTIVE_GAIN
    detections = _telling_sizes(_at_better_shape(detections)[0])
    ratio = np.maximum([detection.log_ratio for detection in detections], 0.0)
    size, error = (
        np.array([detection.size for detection in detections]),
        np.array([detection.size_error for detection in detections]),
    )
    has_size = np.isfinite(size) & np.isfinite(error) & (error > 0)
    weight = np.where(has_size, 1 / np.where(has_size, error, 1.0) ** 2, 0.0)
    size = np.where(has_size, size, 0.0)
    mean = float(np.sum(weight * size)) / max(float(np.sum(weight)), 1e-300)
    # where sizes scatter significantly more than their errors, the errors are enlarged (Birge ratio)
    freedom, scatter = max(int(has_size.sum()) - 1, 1), float(np.sum(weight * (size - mean) ** 2))
    birge = scatter / freedom if chdtrc(freedom, scatter) < SCATTER_RATE else 1.0
    rest = np.sum(weight) - weight
    predicted = rest > 1e-9 * weight
    rest = np.where(predicted, rest, np.inf)
    others = (np.sum(weight * size) - weight * size) / rest
    # the error of the others' mean size widens the prediction
    relative_variance = weight / rest
    loss = 0.5 * weight * (others - size) ** 2 / (birge * (1 + relative_variance)) + 0.5 * np.log1p(relative_variance)
    loss = np.where(predicted, loss, 1.0)
    ratio = np.where(predicted, ratio / birge, ratio)
    gains = ratio - loss
    # a log-likelihood ratio has twice its mean as variance, plus the error of the others' mean size
    share = np.divide(others, size, out=np.zeros_like(size), where=size != 0)
    variance = np.where(predicted, 2 * ratio * share**2 + relative_variance, 2 * np.maximum(ratio, 0.5))
    error_of_mean = float(np.sqrt(variance.sum())) / ratio.size
    value = float(gains.mean())
    held_out = ratio.size if ratio.size > 1 else 0
    return PredictiveGain(value, error_of_mean, held_out)


def at_common_shape(own: Sequence[Detection]) -> tuple[list[Detection], float] | None:
    """Detections at the shape with the largest weighted sum of scores, and its Bonferroni-corrected p-value.

    None where windows differ in their shapes, or have none.
    """
    shapes = {len(detection.by_shape) for detection in own}
    if len(shapes) > 1 or shapes == {0}:
        return None
    size, error = np.moveaxis(np.array([detection.by_shape for detection in own]), -1, 0)
    has_size = np.isfinite(size) & (error > 0)
    weight = np.where(has_size, 1 / np.where(has_size, error, 1.0), 0.0)
    normal = np.where(has_size, size, 0.0) * weight
    total = np.abs(np.sum(weight * normal, axis=0)) / np.maximum(np.sqrt(np.sum(weight**2, axis=0)), 1e-300)
    best = int(np.argmax(total))
    return [_at_shape(detection, best) for detection in own], min(1.0, total.size * 2 * float(ndtr(-total[best])))


def _at_shape(detection: Detection, shape: int) -> Detection:
    """A detection at a shape; unchanged where there is no estimate at it, or the whole course was fitted."""
    size, error = detection.by_shape[shape]
    if not (np.isfinite(size) and error > 0 and np.isnan(detection.misfit)):
        return detection
    return replace(detection, score=abs(size / error), size=size, size_error=error, log_ratio=0.5 * (size / error) ** 2)


def at_common_line(own: Sequence[Detection]) -> tuple[list[Detection], float] | None:
    """Detections at the line that stands out most over all windows, and its Bonferroni-corrected p-value.

    In noise a line exceeds LINE_KEPT in a binomial number of windows, by an exponentially distributed amount. A tone
    stands out of the next strongest lines as well, as images of the response to the sweep do not. Lines of windows of
    another length have other frequencies: those of the commonest length count. None where windows have none.
    """
    lines = [detection.lines for detection in own if detection.lines is not None]
    if len(lines) < len(own):
        return None
    usual, _ = Counter(window.spacing for window in lines).most_common(1)[0]
    own = [detection for detection, window in zip(own, lines, strict=True) if window.spacing == usual]
    lines = [window for window in lines if window.spacing == usual]
    total = np.zeros(max(int(window.place.max(initial=0)) for window in lines) + 1)
    for window in lines:
        total[window.place] += window.log_ratio - LINE_KEPT
    best, tried = int(np.argmax(total)), max(window.tried for window in lines)
    p_value = max(tried * _p_value_of_line(total[best], len(own)), _p_value_among_images(total, tried, len(own)))
    common = [_at_line(detection, window, best) for detection, window in zip(own, lines, strict=True)]
    same_line = [
        bool(np.isfinite(detection.size_error) and abs(window.strongest - best) <= 1)
        for detection, window in zip(own, lines, strict=True)
    ]
    if 2 * sum(same_line) >= len(same_line):
        # most windows detect the tone by themselves, with a better size; a minority would be biased towards high noise
        common = [
            replace(at_line, size=detection.size, size_error=detection.size_error) if same else at_line
            for at_line, detection, same in zip(common, own, same_line, strict=True)
        ]
    return common, min(1.0, p_value)


def _p_value_of_line(total: float, windows: int) -> float:
    """Chance that a line of noise exceeds a total over windows."""
    from scipy.stats import binom

    number = np.arange(1, windows + 1)
    return float(np.sum(binom.pmf(number, windows, np.exp(-LINE_KEPT)) * gammaincc(number, total)))


def _p_value_among_images(total: Floats, tried: int, windows: int) -> float:
    """Chance that the strongest of many images of the sweep stands out so much; 0 where no images are seen.

    Images are seen where more lines stand out than noise has, and than a few tones would be. Above the weakest of the
    strongest their heights are taken as exponential (Pickands 1975, Annals of Statistics 3, 119–131), with the scale
    that their median gives.
    """
    from scipy.ndimage import maximum_filter1d

    apart = total[(total == maximum_filter1d(total, 2 * _LEAKAGE + 1)) & (total > 0)]
    strongest = np.sort(apart)[-_STRONGEST:]
    if strongest.size < _STRONGEST:
        return 0.0
    in_noise = tried * _p_value_of_line(strongest[0], windows)
    if gammainc(_STRONGEST, in_noise) > IMAGES_RATE:
        return 0.0
    excess = strongest - strongest[0]
    scale = max(float(np.median(excess)) / np.log(2), np.finfo(float).tiny)
    return float(-np.expm1(_STRONGEST * np.log1p(-np.exp(-excess[-1] / scale))))


def _at_line(detection: Detection, lines: SpectralLines, place: int) -> Detection:
    """A detection at a line; without a size where the line does not stand out."""
    entry = np.flatnonzero(lines.place == place)
    if not entry.size:
        return replace(detection, score=0.0, size=0.0, size_error=np.inf, log_ratio=0.0)
    ratio, size, error = (float(values[entry[0]]) for values in (lines.log_ratio, lines.size, lines.size_error))
    return replace(detection, score=-float(ndtri_exp(-ratio)), size=size, size_error=error, log_ratio=ratio)
