"""What is hidden in a case: causes, pairs of causes, and sizes from undetectable to obvious."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.generator.cases import EFFECTS, Case, Hidden, plain_case
from benchmarks.blind.ideal.ideal import Ideal

NULLS = 0.5
"""Share of cases with nothing hidden."""
PAIRS = 0.1
"""Share of the others with two causes."""
REMOVED = 0.25
"""Share of the others whose cause is taken out of the engine's catalogue."""
ZONES = 0.05
"""Share of the others that are turned to a zone of local damping, the one cause with a place, to be located."""
_DETECTABILITY = (1.0, 30.0)
"""√λ of the ideal test, drawn evenly in its logarithm."""
_REMOVED_DETECTABILITY = (10.0, 30.0)
_ROUNDS = 6
_CLOSE = 0.05


def draw(seed: int, windows: int | None = None) -> Case:
    """A case with all that is hidden in it; the same seed gives the same case, and successive ones take turns."""
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
    """The cause whose turn it is with a seed."""
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
    """Size at which √λ is as wanted, by secants in logarithms, within the range of sizes."""
    size, power = float(np.sqrt(low * high)), 1.0
    found: list[tuple[float, float]] = []
    sign = np.sign(hidden.size)
    for _ in range(_ROUNDS):
        reached = np.sqrt(max(ideal.noncentrality((Hidden(hidden.name, sign * size, hidden.shape),)), 1e-12))
        found.append((np.log(size), np.log(reached)))
        if abs(found[-1][1] - np.log(wanted)) < _CLOSE:
            break
        if len(found) > 1 and abs(found[-1][0] - found[-2][0]) > 1e-6:
            power = (found[-1][1] - found[-2][1]) / (found[-1][0] - found[-2][0])
        power = min(max(power, 0.4), 3.0)
        size = float(np.clip(size * (wanted / reached) ** (1 / power), low, high))
        if found[-1][0] == np.log(size):
            break
    return size


def _partner(generator: np.random.Generator, name: str) -> str:
    """A cause of another file of effects, so that both can be at work."""
    own = EFFECTS[name].apply.__module__
    return str(generator.choice([other for other, effect in EFFECTS.items() if effect.apply.__module__ != own]))
