"""Implicit step of all nodes with dry friction, compiled.

Dry friction is set-valued: a sticking node remains exactly at rest as long as the torque on it is below the
static level; a slipping node is opposed by the level at its speed. The slip direction of each node is
determined iteratively within the step, and every iteration solves one symmetric tridiagonal system.
"""

import numpy as np

from drillid.arrays import Floats
from drillid.simulation.parts import (
    BLADE,
    EARLIER_CUT,
    FOLLOWING,
    FURTHEST,
    LawTable,
    NodeFriction,
    Rock,
    Scratch,
    SpatialGrid,
    State,
    compiled,
)


@compiled
def factorise(grid: SpatialGrid, held: np.ndarray, half_step: float, factors: tuple[Floats, Floats]) -> None:
    """LDLᵀ of inertia + half_step · damping without prescribed nodes: multipliers (n,), inverse pivots (n + 1,)."""
    multiplier, inverse = factors
    count = grid.coupling.size
    carried = 0.0
    for i in range(count + 1):
        diagonal = grid.inertia[i] + half_step * grid.viscous[i]
        if i < count:
            diagonal += half_step * grid.coupling[i]
        if i > 0:
            diagonal += half_step * grid.coupling[i - 1]
        inverse[i] = 1.0 if held[i] else 1.0 / (diagonal - carried)
        carried = 0.0
        if i < count:
            link = half_step * grid.coupling[i]
            free = not (held[i] or held[i + 1])
            multiplier[i] = link * inverse[i] if free else 0.0
            carried = multiplier[i] * link


@compiled
def substitute(multiplier: Floats, inverse: Floats, mean: Floats) -> None:
    """Solve in place with the factors of `factorise`."""
    count = multiplier.size
    for i in range(count):
        mean[i + 1] += multiplier[i] * mean[i]
    for i in range(count + 1):
        mean[i] *= inverse[i]
    for i in range(count - 1, -1, -1):
        mean[i] += multiplier[i] * mean[i + 1]


@compiled
def reaction(grid: SpatialGrid, push: Floats, mean: Floats, half_step: float, node: int) -> float:
    """Friction torque (N m) on a node, from its balance of momentum."""
    required = (grid.inertia[node] + half_step * grid.viscous[node]) * mean[node]
    if node > 0:
        required += half_step * grid.coupling[node - 1] * (mean[node] - mean[node - 1])
    if node < grid.coupling.size:
        required += half_step * grid.coupling[node] * (mean[node] - mean[node + 1])
    return float((push[node] - required) / half_step)


@compiled
def weakened(static: float, dynamic: float, speed: float, threshold: float, exponent: float) -> float:
    """Friction level at a speed."""
    if static == dynamic:
        return dynamic
    ratio = abs(speed) / threshold
    if exponent != 1.0:
        ratio = ratio**exponent
    return float(dynamic + (static - dynamic) * np.exp(-ratio))


@compiled
def acting_speed(law: LawTable, state: State) -> float:
    """Speed that the bit's law acts on, half a step after the state's speeds, rad/s."""
    if law.followed < 1.0:
        following = state.memory[FOLLOWING]
        return float(following + law.followed_half * (state.speed[-1] - following))
    return float(1.5 * state.speed[-1] - 0.5 * state.before[-1])


@compiled
def _step_behind(angle: Floats, target: float, newest: int, start: int) -> int:
    """Step during which the bit passed an angle, searched from the previous result."""
    j = start
    while j > 0 and angle[j] > target:
        j -= 1
    while j + 1 < newest and angle[j + 1] <= target:
        j += 1
    return j


@compiled
def chip_torque(rock: Rock, weight: float, state: State, newest: int, step: float) -> float:
    """Torque (N m) of the blades' depth of cut, half a step after the newest step; advances the bit by one step."""
    angle, depth, memory = state.angle, state.depth, state.memory
    now = depth[newest]
    depth[newest + 1] = now
    here = angle[newest] + step / 2 * state.speed[-1]
    # after turning backward the bit first passes rock that is already cut
    if weight <= 0 or here < memory[FURTHEST]:
        return 0.0
    memory[FURTHEST] = here
    target = here - 2 * np.pi / rock.blades
    j = _step_behind(angle, target, newest, int(memory[BLADE]))
    memory[BLADE] = j
    behind = target * memory[EARLIER_CUT]
    if target >= angle[0]:
        behind = depth[j] + (target - angle[j]) / (angle[j + 1] - angle[j]) * (depth[j + 1] - depth[j])
    greatest = rock.depth_per_weight * weight / rock.blades
    depth[newest + 1] = max(min(now + step * rock.rate, behind + greatest), now)
    cut = (now + depth[newest + 1]) / 2 - behind
    return float(rock.torque_per_depth * rock.blades * min(max(cut, 0.0), greatest))


@compiled
def set_levels(friction: NodeFriction, rock: Rock, weight: float, state: State, levels: tuple[Floats, Floats]) -> None:
    """Static and sliding level (N m) of every contact, at speeds extrapolated by half a step."""
    static, sliding = levels
    last = friction.nodes.size - 1
    for k in range(friction.nodes.size):
        i = friction.nodes[k]
        speed = 1.5 * state.speed[i] - 0.5 * state.before[i]
        strengthening = 1 + friction.rest[k] * state.rested[i]
        static[k] = strengthening * friction.static[k]
        level = weakened(friction.static[k], friction.dynamic[k], speed, friction.threshold, friction.exponent)
        sliding[k] = strengthening * level
        if k == last and rock.cuts:
            load = max(weight, 0.0)
            static[k] += load * rock.static
            sliding[k] += load * weakened(rock.static, rock.dynamic, speed, rock.threshold, rock.exponent)


@compiled
def settle(
    grid: SpatialGrid,
    nodes: np.ndarray,
    scratch: Scratch,
    chips: float,
    state: State,
    half_step: float,
    top_mean: float,
) -> None:
    """Mean of old and new speeds with slip and stick determined for this step, from push and levels of the scratch.

    A node comes to rest and breaks away at most once in a step, so that the iteration ends. `chips` is the torque of
    the blades on the turning bit; `top_mean` is the mean speed of a top drive whose speed is prescribed.
    """
    push, mean = scratch.push, scratch.mean
    static, sliding = scratch.levels
    stopped, released = scratch.turned
    stopped[:] = released[:] = False
    bit = push.size - 1
    while True:
        _load(grid, nodes, sliding, chips, push, state, half_step, top_mean, mean)
        substitute(scratch.factors[0], scratch.factors[1], mean)
        changed = False
        for k in range(nodes.size):
            i = nodes[k]
            cutting = chips if i == bit else 0.0
            if state.slip[i] != 0:
                backward = (2 * mean[i] - state.speed[i]) * state.slip[i] < 0
                if backward and not stopped[k]:
                    state.slip[i], state.held[i] = 0, True
                    stopped[k] = changed = True
            elif not released[k]:
                torque = reaction(grid, push, mean, half_step, i)
                if torque > static[k] + cutting or torque < -static[k]:
                    state.slip[i], state.held[i] = (1 if torque > 0 else -1), False
                    released[k] = changed = True
        if not changed:
            return
        factorise(grid, state.held, half_step, scratch.factors)


@compiled
def _load(
    grid: SpatialGrid,
    nodes: np.ndarray,
    sliding: Floats,
    chips: float,
    push: Floats,
    state: State,
    half_step: float,
    top_mean: float,
    mean: Floats,
) -> None:
    """Right-hand side into `mean`: push less friction of slipping nodes, plus terms of nodes of prescribed speed."""
    bit = push.size - 1
    for i in range(bit + 1):
        mean[i] = push[i]
    for k in range(nodes.size):
        i = nodes[k]
        if state.slip[i] != 0:
            mean[i] -= half_step * (state.slip[i] * sliding[k])
            if i == bit and state.slip[i] > 0:
                mean[i] -= half_step * chips
        else:
            prescribed = state.speed[i] / 2
            if i > 0:
                mean[i - 1] += half_step * grid.coupling[i - 1] * prescribed
            if i < bit:
                mean[i + 1] += half_step * grid.coupling[i] * prescribed
    if state.held[0] and (nodes.size == 0 or nodes[0] != 0):
        mean[0] = top_mean
        mean[1] += half_step * grid.coupling[0] * top_mean
    for k in range(nodes.size):
        if state.slip[nodes[k]] == 0:
            mean[nodes[k]] = state.speed[nodes[k]] / 2
