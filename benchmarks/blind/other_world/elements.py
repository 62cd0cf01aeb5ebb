"""Finite elements of a string in torsion, its modes with their damping, and exact propagators of the modes.

Two-node elements whose mass is half lumped, half consistent, with little dispersion (Hughes 1987, The Finite Element
Method, section 7.3); the error of a response is of second order in the element's length. Damping is kept as full
matrices between modes; drag of a boundary layer and losses of the steel are relaxations with states of their own. The
damped system in modal coordinates is diagonalised by its complex modes, each of which is advanced by its exponential,
so that a step is exact for torques that are constant within it.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import eigh

from benchmarks.blind.other_world.relaxation import NONE, Relaxations, relaxing_drag, relaxing_hysteresis
from benchmarks.blind.other_world.rig import Piece
from drillid.arrays import Complex, Floats

ELEMENT = 25.0
"""m, greatest length of an element."""
HIGHEST = 20.0
"""Hz; modes above it are left out."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Nodes from top drive to bit, and the matrices between them, each (nodes, nodes)."""

    place: Floats
    """(nodes,) m from the top."""
    inertia: Floats
    stiffness: Floats
    viscous: Floats
    """Damping of wall and lumps."""
    steel: Floats
    """Damping within the steel."""
    structural: Floats
    """Stiffness times loss factor."""
    root: Floats
    """Coefficients of the drag that grows as √frequency."""


def mesh(string: tuple[Piece, ...], top_inertia: float, element: float = ELEMENT) -> Mesh:
    """Elements of a string with a lump of inertia (kg m²) at its top, none longer than `element` (m)."""
    counts = [int(np.ceil(piece.length / element)) for piece in string]
    nodes = sum(counts) + 1
    matrices = {name: np.zeros((nodes, nodes)) for name in list(Mesh.__annotations__)[1:]}
    place = np.zeros(nodes)
    first = 0
    averaged = np.array([[5.0, 1.0], [1.0, 5.0]]) / 12
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    for piece, count in zip(string, counts, strict=True):
        width = piece.length / count
        area, stiff = piece.moment * width * averaged, piece.moment / width * spring
        terms = {
            "inertia": piece.density * area,
            "viscous": piece.wall_damping * area,
            "root": piece.root_drag * area,
            "stiffness": piece.shear_modulus * stiff,
            "steel": piece.steel_damping * stiff,
            "structural": piece.loss_factor * piece.shear_modulus * stiff,
        }
        for number in range(first, first + count):
            span = slice(number, number + 2)
            for name, term in terms.items():
                matrices[name][span, span] += term
            place[number + 1] = place[number] + width
        first += count
        matrices["inertia"][first, first] += piece.inertia_below
        matrices["viscous"][first, first] += piece.damping_below
    matrices["inertia"][0, 0] += top_inertia
    return Mesh(place, **matrices)


@dataclass(frozen=True, eq=False)
class Modes:
    """A string in the coordinates of its undamped modes.

    The state (S,) has the speeds of N modes and what each relaxation of the drag remembers of them, then the E elastic
    coordinates times frequency and what each relaxation of the steel remembers of these.
    """

    mesh: Mesh
    shapes: Floats
    """(nodes, N), of unit modal inertia."""
    frequency: Floats
    """(N,) rad/s; 0 of the rotation of the whole, which comes first."""
    drag: Relaxations
    steel: Relaxations
    system: Floats
    """(S, S), derivative of the state."""
    response: Floats
    """(S, N), derivative of the state per modal torque."""

    @property
    def elastic(self) -> Floats:
        """Frequencies of the elastic modes, (E,) rad/s."""
        return self.frequency[1:]

    @property
    def steady_drag(self) -> Floats:
        """Torque on each node (nodes,) per speed of steady rotation, N m s/rad."""
        return np.asarray((self.mesh.viscous + self.drag.constant * self.mesh.root).sum(axis=1), dtype=float)

    def ports(self, places: Floats) -> Floats:
        """Shapes at places along the string (m), by linear interpolation within elements, (places, N)."""
        return np.stack([np.interp(places, self.mesh.place, shape) for shape in self.shapes.T], axis=1)

    def steady(self, speed: Floats, torque: Floats) -> Floats:
        """State of given speeds at the nodes (nodes,), for long, under given torques on them (nodes,)."""
        loss = self.shapes.T @ self.mesh.structural @ self.shapes
        stiffness = np.diag(self.frequency**2) + self.steel.constant * loss
        twist = self.shapes[:, 1:] @ np.linalg.solve(stiffness[1:, 1:], (self.shapes.T @ torque)[1:])
        remembered = np.append(1.0, 1 / self.drag.rates)[:, None] * speed
        return self.state(remembered, np.vstack([twist, np.zeros((self.steel.rates.size, twist.size))]))

    def state(self, speeds: Floats, twists: Floats) -> Floats:
        """State from nodal fields (1 + relaxations, nodes): speed and what is remembered of it, and twist likewise."""
        modal = speeds @ self.mesh.inertia @ self.shapes
        elastic = (twists @ self.mesh.stiffness @ self.shapes)[:, 1:] / self.elastic
        return np.concatenate([modal.ravel(), elastic.ravel()])

    def fields(self, state: Floats) -> tuple[Floats, Floats]:
        """The nodal fields of a state."""
        count = self.frequency.size
        speeds, elastic = np.split(state, [count * (1 + self.drag.rates.size)])
        twists = elastic.reshape(-1, count - 1) / self.elastic
        return speeds.reshape(-1, count) @ self.shapes.T, twists @ self.shapes[:, 1:].T


def modes(string: tuple[Piece, ...], top_inertia: float, element: float = ELEMENT, highest: float = HIGHEST) -> Modes:
    """Modes up to a frequency (Hz) and the damped system in their coordinates."""
    grid = mesh(string, top_inertia, element)
    squared, shapes = eigh(grid.stiffness, grid.inertia, subset_by_value=(-np.inf, (2 * np.pi * highest) ** 2))
    frequency = np.sqrt(np.maximum(squared, 0.0))
    frequency[0] = 0.0
    drag = relaxing_drag() if grid.root.any() else NONE
    steel = relaxing_hysteresis() if grid.structural.any() else NONE
    damping, root, structural = (
        shapes.T @ matrix @ shapes for matrix in (grid.viscous + grid.steel, grid.root, grid.structural)
    )
    loss, pull = structural[:, 1:] / frequency[1:], np.diag(frequency)[:, 1:]
    # each row of the derivative: by speeds, what the drag remembers, elastic coordinates, what the steel remembers
    torques = [damping + (drag.constant + drag.shares.sum()) * root, -np.kron(drag.shares * drag.rates, root)]
    torques += [pull + steel.constant * loss, np.kron(steel.shares, loss)]
    count, springs, kept, lost = frequency.size, frequency.size - 1, drag.rates.size, steel.rates.size
    places = np.cumsum([count, kept * count, springs, lost * springs])
    speeds, of_drag, elastic, of_steel = (slice(*ends) for ends in pairwise([0, *places]))
    system = np.zeros((places[-1], places[-1]))
    system[speeds] = -np.hstack(torques)
    system[of_drag, speeds] = np.tile(np.eye(count), (kept, 1))
    system[of_drag, of_drag] = -np.kron(np.diag(drag.rates), np.eye(count))
    system[elastic, speeds] = pull.T
    system[of_steel, speeds] = np.tile(pull.T, (lost, 1))
    system[of_steel, of_steel] = -np.kron(np.diag(steel.rates), np.eye(springs))
    return Modes(grid, shapes, frequency, drag, steel, system, np.eye(places[-1], count))


@dataclass(frozen=True, eq=False)
class Propagator:
    """One time step of a damped string in the coordinates of its complex modes, one of each conjugate pair."""

    poles: Complex
    """(Q,) 1/s."""
    advance: Complex
    """(Q,) factor of the state in one step."""
    drive: Complex
    """(Q, ports) change of the state by a torque that is constant during the step."""
    observe: Complex
    """(ports, Q) the ports' speeds are the real part of this times the state."""
    to_modal: Complex
    """(S, Q) the modal state is the real part of this times the state."""
    from_modal: Complex
    """(Q, S)."""

    @property
    def compliance(self) -> Floats:
        """(ports, ports) change of speed at the end of a step by a torque during it, rad/s per N m."""
        return np.asarray((self.observe @ self.drive).real, dtype=float)


def propagator(string: Modes, places: Floats, time_step: float) -> Propagator:
    """Exact step of a string with ports at places along it (m)."""
    values, vectors = np.linalg.eig(string.system)
    inverse = np.linalg.inv(vectors)
    kept = values.imag >= 0
    values, vectors, inverse = values[kept], vectors[:, kept], inverse[kept]
    # a pole off the real axis stands for itself and its conjugate
    doubled = vectors * np.where(values.imag > 0, 2.0, 1.0)
    shapes = string.ports(places)
    count = string.frequency.size
    advance = np.exp(values * time_step)
    slow = np.abs(values) * time_step < 1e-12
    held = np.where(slow, time_step, (advance - 1) / np.where(slow, 1.0, values))
    drive = held[:, None] * (inverse @ string.response @ shapes.T)
    return Propagator(values, advance, drive, shapes @ doubled[:count], doubled, inverse)
