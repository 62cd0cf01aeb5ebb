"""Search over elements of a learnt extension: screened, fitted by maximum likelihood, kept by held-out evidence.

Where held-out evidence prefers no rational element, a Gaussian process over frequency is learnt if it prefers that.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.held_out_gain import held_out_gain
from drillid.discrepancy.inference.projection import project
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.elements import ELEMENTS, PORTS_ALONG, TERMS, Element
from drillid.discrepancy.learning.process import PROCESS_AT
from drillid.discrepancy.learning.process_search import fitted_process, is_passive
from drillid.discrepancy.products.immittance import missing_immittance
from drillid.physics.dual_numbers import Dual

PLACES = tuple((np.arange(21) / 20).tolist())
"""Places along the string that are screened, or from which a resonance is fitted where the misfit is strong."""
_STEP, _FINEST = 0.08, 0.004
"""First and last step of the search over places."""
_WORTH = 0.1
"""Nats by which another place must be better to be taken."""
_STRONG = 5.0
"""Standard deviations by which a strong misfit exceeds that of a correct model."""
_FITTED = 4
"""Screened candidates of an element that are fitted."""
_COMPARED = 4
"""Elements whose held-out evidence is computed."""
_MOST_ELEMENTS = 3
_NEAR = 0.5
"""Share of the largest evidence of any channel from which factors and processes are tried at it."""
_DECISIVE = 5.0
"""Nats below the largest evidence down to which they are tried as well (Kass and Raftery 1995, Journal of the American
Statistical Association 90, 773–795)."""
_POLES = 6
"""Largest number of support points of the rational function whose poles start fits."""
_LEAST_GAIN = 2.0
"""Nats of training data that a further parameter must gain for its element to be compared."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """The model with one more element, at its optimum."""

    element: Element
    place: float
    extensions: tuple[Extension, ...]
    """All extensions, those before it included."""
    fit: SetFit


def placed(element: Element, place: float) -> tuple[Extension, ...]:
    """The element's terms as extensions."""
    if element.name == "profile":
        return tuple(Extension(TERMS[name], float(number)) for number, name in enumerate(element.terms))
    return tuple(
        Extension(TERMS[name], place if element.has_place and number == 0 else 0.0)
        for number, name in enumerate(element.terms)
    )


def elements_for(channels: dict[str, float]) -> list[Element]:
    """Elements that may explain a misfit, given the evidence for an unknown disturbance in each channel.

    Those along the string always may: the base model's own parameters absorb most of what hangs in the string, and what
    they leave looks like another port's.
    """
    along = set(PORTS_ALONG)
    return [element for element in ELEMENTS if (near(channels) | along).intersection(element.ports)]


def near(channels: dict[str, float]) -> set[str]:
    """Channels whose evidence is near the largest."""
    most = max(channels.values())
    return {name for name, evidence in channels.items() if evidence >= min(_NEAR * most, most - _DECISIVE)}


def channel_evidence(model: SetModel, fit: SetFit, present: tuple[Extension, ...] = ()) -> dict[str, float]:
    """Log Bayes factor of an unknown disturbance in each channel."""
    found = {}
    for channel in unknown.CHANNELS:
        projection = project(model, fit, present, unknown.directions(model, fit, present, channel))
        found[channel] = float(unknown.log_evidence(channel, projection.score[None], projection.information)[0])
    return found


def learn(model: SetModel, base: SetFit) -> tuple[tuple[Candidate, ...], tuple[Candidate, ...]]:
    """Add elements one by one as long as something unknown shows and each predicts windows it was not fitted to better.

    Parameters
    ----------
    base : fit of the model without extensions

    Returns
    -------
    chosen : the models with one element, two and so on; that with a process alone where it predicts better
    firsts : the models with every single element, and with the process where it is chosen
    """
    chosen, firsts = _rational(model, base)
    process = _process(model, base)
    if process is None:
        return chosen, firsts
    before = (chosen[-1].fit.point, chosen[-1].extensions) if chosen else (base.point, ())
    if held_out_gain(model, before, (process.fit.point, process.extensions)).low > 0:
        return (process,), (*firsts, process)
    return chosen, firsts


def _process(model: SetModel, base: SetFit) -> Candidate | None:
    """The model with a Gaussian process at the port of largest evidence; None without evidence, or if not passive."""
    channels = channel_evidence(model, base)
    ports = [port for port in near(channels) if port in unknown.PORTS]
    if not ports or max(channels.values()) <= 0:
        return None
    found = fitted_process(model, base, ports)
    if found is None:
        return None
    port, extensions, fit = found
    element = Element(f"{PROCESS_AT} {port}", tuple(each.cause.name for each in extensions), False, (port,), ())
    return Candidate(element, 0.0, extensions, fit) if is_passive(model, fit, extensions) else None


def _rational(model: SetModel, base: SetFit) -> tuple[tuple[Candidate, ...], tuple[Candidate, ...]]:
    """As `learn`, with rational elements alone."""
    chosen: list[Candidate] = []
    firsts: tuple[Candidate, ...] = ()
    while len(chosen) < _MOST_ELEMENTS:
        before = chosen[-1].fit if chosen else base
        present = chosen[-1].extensions if chosen else ()
        channels = channel_evidence(model, before, present)
        if max(channels.values()) <= 0:
            break
        tried = [element for element in elements_for(channels) if _may_follow(element, chosen)]
        fitted = [best_of(model, before, present, element) for element in tried]
        firsts = firsts or tuple(fitted)
        promising = [each for each in fitted if before.cost - each.fit.cost > _LEAST_GAIN * each.element.order]
        promising.sort(key=lambda each: each.fit.cost + _LEAST_GAIN * each.element.order)
        judged = [
            (held_out_gain(model, (before.point, present), (each.fit.point, each.extensions)), each)
            for each in promising[:_COMPARED]
        ]
        judged = [pair for pair in judged if pair[0].low > 0]
        if not judged:
            break
        chosen.append(max(judged, key=lambda pair: pair[0].value)[1])
    return tuple(chosen), firsts


def _may_follow(element: Element, chosen: Sequence[Candidate]) -> bool:
    """A profile cuts the string before anything is attached to it; a transfer has one factor."""
    names = [each.element.name for each in chosen]
    same_port = any(set(element.ports) == set(each.element.ports) for each in chosen) and not element.has_place
    return not (same_port or (element.name == "profile" and names))


def best_of(model: SetModel, before: SetFit, present: tuple[Extension, ...], element: Element) -> Candidate:
    """The best fit of one more element.

    Fits start from the model before it and from the data sheets: the model before it has absorbed the element's effect
    in parameters of its own, from which a fit may not find its way back.
    """
    expected = model.expected()
    best: Candidate | None = None
    for origin, place, sizes in _starts(model, before, present, element):
        extensions = (*present, *placed(element, place))
        start = Point(origin.shared, origin.local, np.append(before.point.sizes, sizes))
        # a start whose cost falls too slowly to reach the best one is abandoned
        fit = fit_set(model, start, extensions, np.inf if best is None else best.fit.cost)
        if best is None or fit.cost < best.fit.cost:
            best = Candidate(element, place, extensions, fit)
    assert best is not None
    again = fit_set(model, Point(expected.shared, expected.local, best.fit.point.sizes), best.extensions, best.fit.cost)
    best = replace(best, fit=min(best.fit, again, key=lambda each: each.cost))
    return _refined(model, present, best) if element.has_place else best


def _starts(
    model: SetModel, before: SetFit, present: tuple[Extension, ...], element: Element
) -> list[tuple[Point, float, Floats]]:
    """Points, places and sizes from which fits begin.

    A resonance has an optimum wherever its frequency meets another feature of the responses. The first one, where the
    misfit is strong, starts from places and frequencies everywhere: a linearisation without it could not choose among
    them, and the optimum over places is narrow, between others that are far worse.
    """
    expected = model.expected()
    found = [
        (origin, place, sizes)
        for place, sizes in _screened(model, before, present, element)
        for origin in (before.point, expected)
    ]
    # half the squared residual of a complex value has mean and variance one
    count = np.count_nonzero(model.measured.weight)
    is_strong = not present and before.cost > count + _STRONG * np.sqrt(count)
    if is_strong and element.name == "mounted inertia":
        typical = np.array([TERMS[name].size.typical for name in element.terms])
        found += [(expected, place, np.array(start) * typical) for place in PLACES for start in element.starts]
    return found


def _refined(model: SetModel, present: tuple[Extension, ...], best: Candidate) -> Candidate:
    """The candidate at the place that fits best, by steps that are halved."""
    step = _STEP
    while step >= _FINEST:
        tried = []
        for place in (best.place - step, best.place + step):
            if 0.0 <= place <= 1.0:
                extensions = (*present, *placed(best.element, place))
                fit = fit_set(model, best.fit.point, extensions, best.fit.cost)
                tried.append(replace(best, place=place, extensions=extensions, fit=fit))
        closest = min(tried, key=lambda each: each.fit.cost)
        # the cost of a fit that is resumed falls a little by itself, at any place
        if closest.fit.cost < best.fit.cost - _WORTH:
            best = closest
        else:
            step /= 2
    return best


def _screened(
    model: SetModel, before: SetFit, present: tuple[Extension, ...], element: Element
) -> list[tuple[float, Floats]]:
    """Places and sizes from which fits begin: those whose first size explains most to first order."""
    typical = np.array([TERMS[name].size.typical for name in element.terms])
    starts = [np.array(start) * typical for start in element.starts]
    if element.name == "mounted inertia":
        starts += [np.array([typical[0], own, typical[2]]) for own in _rational_frequencies(model, before, present)]
    places = PLACES if element.has_place else (0.0,)
    tried = [(place, start) for place in places for start in starts]
    if len(tried) <= _FITTED:
        return tried
    projection = project(model, before, present, _directions(model, before, present, element, tried))
    information = np.diag(projection.information)
    estimate = projection.score / information
    explained = 0.5 * np.where(estimate > 0, estimate * projection.score, 0.0)
    limits = TERMS[element.terms[0]].size
    chosen = {}
    for index in np.argsort(-explained)[:_FITTED]:
        place, start = tried[index]
        first = float(np.clip(estimate[index], 0.1 * limits.typical, limits.high))
        # starts that differ in the first size alone count as one
        chosen[place, first, *start[1:].tolist()] = place, np.array([first, *start[1:]])
    return list(chosen.values())


def _directions(
    model: SetModel,
    before: SetFit,
    present: tuple[Extension, ...],
    element: Element,
    tried: Sequence[tuple[float, Floats]],
) -> Complex:
    """Directions (W, tried, rows) of an element from some places and sizes.

    To first order whatever hangs in the string acts by its admittance: its direction is that of a damper of 1 N m s/rad
    at the same place, times the admittance of its unit at every line.
    """
    if element.admittance is None:
        first = {place: _direction(model, before, present, element, place, sizes) for place, sizes in tried}
        return np.stack([first[place] for place, _ in tried], axis=1)
    damper = next(each for each in ELEMENTS if each.name == "damper")
    size = np.array([TERMS[damper.terms[0]].size.typical])
    at = {place: _direction(model, before, present, damper, place, size) for place, _ in tried}
    rows = np.zeros(model.measured.count, dtype=complex)
    found = []
    for place, sizes in tried:
        rows[: model.s.size] = element.admittance(model.s, sizes)
        found.append(at[place] * rows)
    return np.stack(found, axis=1)


def _direction(
    model: SetModel, before: SetFit, present: tuple[Extension, ...], element: Element, place: float, sizes: Floats
) -> Complex:
    """Derivative (W, rows) of the whitened responses to an element's first size at zero, its others as given."""
    further = placed(element, place)
    own: list[Any] = [Dual(np.zeros((1, 1)), np.ones(1)), *sizes[1:].tolist()]
    window_model = model.extended(model.window_model_at(before.point, present), own, further)
    return model.slopes(window_model)


def _rational_frequencies(model: SetModel, fit: SetFit, present: tuple[Extension, ...]) -> list[float]:
    """Frequencies (Hz) of the poles, within the band, of what the model lacks at the string's ports, by AAA."""
    from scipy.interpolate import AAA

    frequency = model.evidence.frequency
    s = 2j * np.pi * frequency
    found: list[float] = []
    for port in ("top", "bit"):
        curve = missing_immittance(model, fit, port, present).values
        with warnings.catch_warnings():
            # few terms are wanted, whether or not they reach the tolerance
            warnings.simplefilter("ignore", RuntimeWarning)
            rational = AAA(np.concatenate([s, s.conj()]), np.concatenate([curve, curve.conj()]), max_terms=_POLES)
        own = np.abs(rational.poles().imag) / (2 * np.pi)
        found += [float(each) for each in own if frequency[0] < each < frequency[-1]]
    return sorted({round(each, 2) for each in found})
