"""An examination with what was learnt where its verdict is unknown."""

from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.coordinates import SHARED, Extension
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.unknown import RELATIVE
from drillid.discrepancy.learning.elements import TERMS
from drillid.discrepancy.learning.offer import LearntExtension, learnt_extension
from drillid.discrepancy.learning.process import COMPARED, KERNELS, curves, is_process
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import LEARNT, UNKNOWN, Verdict
from drillid.statistics import TWO_SIDED

_MOST_SHOWN = 6
"""Most parameters of an extension that are given in words."""


def with_learnt(examination: Examination, seed: int = 0) -> Examination:
    """The examination with its model extended by what was learnt, where that is offered.

    The verdict stays unknown, with the extension's gain on windows that it has not seen.

    Parameters
    ----------
    seed : of the draws that give the p-value of what remains
    """
    is_told = any(verdict.verdict == UNKNOWN and verdict.family in unknown.CHANNELS for verdict in examination.verdicts)
    if examination.extensions or not is_told:
        return examination
    learnt = learnt_extension(examination.model, examination.base)
    if learnt is None or not learnt.offered:
        return examination
    generator = np.random.default_rng(seed)
    after = screen(examination.model, learnt.fit, learnt.extensions, list(CATALOGUE.values()), generator)
    extended = replace(
        examination,
        extended=learnt.fit,
        extensions=learnt.extensions,
        after=after,
        fingerprint=learnt.fingerprint,
    )
    verdicts = tuple(
        _with_gain(extended, verdict, learnt) if verdict.verdict == UNKNOWN else verdict
        for verdict in examination.verdicts
    )
    return replace(extended, verdicts=verdicts)


def _with_gain(examination: Examination, verdict: Verdict, learnt: LearntExtension) -> Verdict:
    places = [extension.shape for extension in learnt.extensions if extension.cause.is_place]
    depth = float(np.mean(examination.model.evidence.operating_points.bit_depth))
    return replace(
        verdict,
        location_m=places[0] * depth if places else float("nan"),
        predictive_gain=learnt.gain.value,
        predictive_gain_low=learnt.gain.low,
        predictive_gain_high=learnt.gain.high,
        held_out_windows=learnt.gain.windows,
        evidence=f"{verdict.evidence}{LEARNT}{learnt_words(examination)}",
    )


def learnt_words(examination: Examination) -> str:
    """The terms of a learnt extension with their sizes and 95 % intervals; empty without one."""
    fit = examination.extended
    count = len(examination.extensions)
    sizes = slice(SHARED, SHARED + count)
    covariance: Floats = np.asarray(np.linalg.inv(fit.information)[sizes, sizes], dtype=float)
    return words(examination.extensions, fit.point.sizes, covariance)


def words(extensions: tuple[Extension, ...], sizes: Floats, covariance: Floats) -> str:
    """Terms with sizes and 95 % intervals; many of one kind by their number, a process by its largest value."""
    if extensions and is_process(extensions[0].cause):
        return _process_words(extensions, sizes, covariance)
    parts, errors = [], np.sqrt(np.diag(covariance))
    for extension, size, error in zip(extensions, sizes.tolist(), errors.tolist(), strict=True):
        cause = extension.cause
        if cause.name in TERMS:
            place = f" at {extension.shape:.0%} of the string" if cause.is_place else ""
            parts.append(
                f"{cause.meaning}{place}, {cause.size.name} {size:.3g} ± {TWO_SIDED * error:.2g} {cause.size.unit}"
            )
    if len(parts) > _MOST_SHOWN:
        return f"{extensions[0].cause.meaning}, {len(parts)} parameters"
    return "; ".join(parts)


def _process_words(extensions: tuple[Extension, ...], sizes: Floats, covariance: Floats) -> str:
    cause, kernel = extensions[0].cause, extensions[0].shape
    known = curves(kernel, COMPARED)
    value = sizes @ known
    largest = int(np.argmax(np.abs(value)))
    # the error along the value's own direction, which is that of its size
    along = (known[:, largest] * value[largest].conj()).real / np.abs(value[largest])
    size, error = float(np.abs(value[largest])), TWO_SIDED * float(np.sqrt(along @ covariance @ along))
    unit = "" if cause.port in RELATIVE else " of the pipe's characteristic admittance"
    memory = f"a Gaussian process over frequency that remembers {1 / KERNELS[int(kernel)][0]:.2g} s"
    at = COMPARED[largest].imag / (2 * np.pi)
    return f"{cause.meaning}, {memory}, largest at {at:.2g} Hz: {size:.3g} ± {error:.2g}{unit}"
