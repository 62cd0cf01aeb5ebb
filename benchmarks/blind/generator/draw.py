"""Random hidden causes of a case: single ones and pairs, of sizes from undetectable to obvious."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.generator.cases import EFFECTS, Case, Hidden, plain_case
from benchmarks.blind.ideal.ideal import Ideal

NULLS = 0.5
"""Share of cases without a hidden cause."""
PAIRS = 0.1
"""Share of the others with two causes."""
REMOVED = 0.25
"""Share of the others whose cause is removed from the engine's catalogue."""
ZONES = 0.05
"""Share of the others that get a zone of local damping instead, the one cause with a place, to test its location."""
_DETECTABILITY = (1.0, 30.0)
"""Range of √λ of the ideal test, log-uniform."""
_REMOVED_DETECTABILITY = (10.0, 30.0)
_ROUNDS = 6
_CLOSE = 0.05


def draw(seed: int, windows: int | None = None) -> Case:
    """A case with its hidden causes; the same seed gives the same case, and successive seeds cycle through causes."""
    case, generator = plain_case(seed, windows)
    if generator.random() < NULLS:
        return case
    kind = generator.random()
    names = ["local_damping_zone" if kind >= 1 - ZONES else in_turn(seed)]
    if kind < PAIRS:
        names.append(_partner(generator, names[0]))
    removed = PAIRS <= kind < PAIRS + REMOVED
    span = _REMOVED_DETECTABILITY if removed else _DETECTABILITY
    hidden: tuple[Hidden, ...] = ()
    for name in sorted(names):
        hidden = (*hidden, sized(case, name, generator, span))
    return replace(case, hidden=hidden, removed=removed)


def in_turn(seed: int) -> str:
    """The cause of a seed, in cyclic order."""
    return list(EFFECTS)[seed % len(EFFECTS)]


def obvious(seed: int, name: str, windows: int, detectability: float = 20.0) -> Case:
    """A case with one cause that the ideal test cannot miss."""
    case, generator = plain_case(seed, windows)
    hidden = sized(case, name, generator, (detectability, detectability))
    return replace(case, hidden=(hidden,))


def sized(case: Case, name: str, generator: np.random.Generator, span: tuple[float, float]) -> Hidden:
    """A cause of a drawn detectability, or of a drawn size where the ideal test cannot be computed."""
    effect = EFFECTS[name]
    hidden = Hidden(name, 0.0, float(generator.random()))
    low, high = effect.range(case.world(0, hidden=()), case.context(hidden))
    share, sign = generator.random(), 1.0
    if effect.signed and generator.random() < 0.5:
        sign = -1.0
    ideal = Ideal(case)
    sized_to = Hidden(name, sign * float(low * (high / low) ** share), hidden.shape)
    if low == high or np.isnan(ideal.noncentrality((sized_to,))):
        return sized_to
    wanted = span[0] * (span[1] / span[0]) ** share
    return Hidden(name, sign * _size_for(ideal, sized_to, wanted, low, high), hidden.shape)


def _size_for(ideal: Ideal, hidden: Hidden, wanted: float, low: float, high: float) -> float:
    """Size at which √λ has a wanted value, by the secant method in logarithms, within the range of sizes."""
    size, power = float(np.sqrt(low * high)), 1.0
    tried: list[tuple[float, float]] = []
    sign = np.sign(hidden.size)
    for _ in range(_ROUNDS):
        reached = np.sqrt(max(ideal.noncentrality((Hidden(hidden.name, sign * size, hidden.shape),)), 1e-12))
        tried.append((np.log(size), np.log(reached)))
        if abs(tried[-1][1] - np.log(wanted)) < _CLOSE:
            break
        if len(tried) > 1 and abs(tried[-1][0] - tried[-2][0]) > 1e-6:
            power = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
        power = min(max(power, 0.4), 3.0)
        size = float(np.clip(size * (wanted / reached) ** (1 / power), low, high))
        if tried[-1][0] == np.log(size):
            break
    return size


def _partner(generator: np.random.Generator, name: str) -> str:
    """A cause from another file of effects, so that both can act together."""
    own = EFFECTS[name].apply.__module__
    return str(generator.choice([other for other, effect in EFFECTS.items() if effect.apply.__module__ != own]))
