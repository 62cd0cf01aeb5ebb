"""Random hidden causes of a case: single ones and pairs, of sizes from undetectable to obvious."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.ideal import Ideal
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.vocabulary import CAUSES
from benchmarks.blind.world import WORLDS, AnyCase, World, world_of

NULLS = 0.5
"""Share of cases without a hidden cause."""
PAIRS = 0.1
"""Share of the others with two causes."""
REMOVED = 0.25
"""Share of the others whose cause is removed from the engine's catalogue."""
NAMELESS = 0.4
"""Share of these that hide an effect of no catalogue instead, in a world that has some."""
ZONES = 0.05
"""Share of the others that get a zone of local damping instead, the one cause with a place, to test its location."""
STRATIFIED = 200_000
"""First seed from which on each cause's turns follow PLAN, so that a block holds as many of each kind as it says."""
PLAN = (*["none"] * 10, "pair", "removed", "removed", "removed or zone", *["large", "any"] * 3)
"""Kinds of successive turns of a cause: the shares above, and large or any sizes of single causes."""
_DETECTABILITY = (1.0, 30.0)
"""Range of √λ of the ideal test, log-uniform."""
_LARGE_DETECTABILITY = (10.0, 30.0)
"""The same of those that are drawn large, and of those that are removed from the catalogue."""
_RIGS = 20
"""Number of rigs that are tried for one on which a cause can be that large."""
_ROUNDS = 6
_CLOSE = 0.05


def draw(seed: int, windows: int | None = None, world: World = WORLDS["own"]) -> AnyCase:
    """A case with its hidden causes; the same seed gives the same case, and successive seeds cycle through causes."""
    case, generator = world.plain_case(seed, windows)
    kind = planned(seed, world) if seed >= STRATIFIED else _drawn_kind(generator)
    if kind == "none":
        return case
    names = ["local_damping_zone" if kind == "zone" else in_turn(seed, world)]
    if kind == "pair":
        names.append(_partner(generator, names[0], world))
    removed = kind == "removed"
    if removed and world.nameless and generator.random() < NAMELESS:
        names = [str(generator.choice(world.nameless))]
    if kind == "large":
        return _large(case, generator, names[0], world, windows)
    span = _LARGE_DETECTABILITY if removed else _DETECTABILITY
    hidden: tuple[Hidden, ...] = ()
    for name in sorted(names):
        hidden = (*hidden, sized(case, name, generator, span))
    return replace(case, hidden=hidden, removed=removed)


def planned(seed: int, world: World = WORLDS["own"]) -> str:
    """The kind of a seed's case by PLAN; the causes begin it at different places, so that kinds are mixed."""
    turn, place = divmod(seed, len(world.named))
    cycle, step = divmod(turn + 7 * place, len(PLAN))
    return ("removed", "zone")[cycle % 2] if PLAN[step] == "removed or zone" else PLAN[step]


def planned_cases(large: int, world: World = WORLDS["own"]) -> int:
    """Number of successive seeds that hold so many large cases of each cause."""
    return -(-large // PLAN.count("large")) * len(PLAN) * len(world.named)


def _drawn_kind(generator: np.random.Generator) -> str:
    """The kind of a case before STRATIFIED."""
    if generator.random() < NULLS:
        return "none"
    kind = generator.random()
    if kind < PAIRS:
        return "pair"
    if kind < PAIRS + REMOVED:
        return "removed"
    return "zone" if kind >= 1 - ZONES else "any"


def _large(case: AnyCase, generator: np.random.Generator, name: str, world: World, windows: int | None) -> AnyCase:
    """A case with a cause of large detectability, on the first of some rigs on which it can be that large."""
    best, reached = case, -1.0
    for attempt in range(_RIGS):
        # far from the seeds of all other cases
        rig = case if attempt == 0 else world.plain_case(case.seed + attempt * 10**9, windows)[0]
        rig = replace(rig, seed=case.seed)
        most = _most(rig, name)
        if most > reached:
            best, reached = rig, most
        if np.isnan(most) or most >= _LARGE_DETECTABILITY[0]:
            best = rig
            break
    return replace(best, hidden=(sized(best, name, generator, _LARGE_DETECTABILITY),))


def _most(case: AnyCase, name: str) -> float:
    """√λ of a cause at its largest size; NaN without an ideal test."""
    ideal = ideal_of(case)
    size = ideal.responses.size_range(Hidden(name, 0.0, 0.5))[1]
    return float(np.sqrt(ideal.noncentrality((Hidden(name, size, 0.5),))))


def in_turn(seed: int, world: World = WORLDS["own"]) -> str:
    """The cause of a seed, in cyclic order."""
    return world.named[seed % len(world.named)]


def obvious(seed: int, name: str, windows: int, detectability: float = 20.0, world: World = WORLDS["own"]) -> AnyCase:
    """A case with one cause that the ideal test cannot miss."""
    case, generator = world.plain_case(seed, windows)
    hidden = sized(case, name, generator, (detectability, detectability))
    return replace(case, hidden=(hidden,), removed=name not in CAUSES)


def sized(case: AnyCase, name: str, generator: np.random.Generator, span: tuple[float, float]) -> Hidden:
    """A cause of a drawn detectability, or of a drawn size where the ideal test cannot be computed."""
    effect = world_of(case).effects[name]
    hidden = Hidden(name, 0.0, float(generator.random()))
    ideal = ideal_of(case)
    low, high = ideal.responses.size_range(hidden)
    share, sign = generator.random(), 1.0
    if effect.signed and generator.random() < 0.5:
        sign = -1.0
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


def _partner(generator: np.random.Generator, name: str, world: World) -> str:
    """A cause from another file of effects, so that both can act together."""
    own = world.effects[name].apply.__module__
    others = [each for each in world.named if world.effects[each].apply.__module__ != own]
    return str(generator.choice(others))
