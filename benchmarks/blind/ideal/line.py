"""Admittance of a string of uniform pieces at its top, and its derivatives, compiled.

The admittance is that of `benchmarks.blind.other_world.theory.string_response` and of `drillid.physics.responses`; here
strings of either world are rows of numbers, and a single pass from bit to top and back gives all derivatives.
"""

from pathlib import Path

import numpy as np

from drillid.arrays import Complex, Floats, Integers
from drillid.compiled import compiler
from drillid.physics.kernel import OPTIONS, falling, inverse, root, through_section

_ROOT = Path(__file__).parents[3]
compiled = compiler("benchmarks/blind/ideal", "drillid/physics", root=_ROOT, **OPTIONS)
"""Compile a function of the ideal test, which may call those of the library's physics."""

PIECE = (
    "length",
    "moment",
    "density",
    "shear_modulus",
    "wall_damping",
    "steel_damping",
    "root_drag",
    "loss_factor",
    "inertia_below",
    "damping_below",
)
"""Of a piece's row, in the units of `benchmarks.blind.other_world.rig.Piece`."""
MOUNTED = ("mounted_inertia", "mounted_frequency", "mounted_loss")
"""Of an inertia on springs and dampers along a piece, kg m² per m and polar moment, as in
`drillid.physics.attachments.MountedInertia`."""
COLUMNS = (*PIECE, *MOUNTED)
_LENGTH, _MOMENT, _DENSITY, _SHEAR, _WALL, _STEEL, _ROOT_DRAG, _LOSS, _INERTIA, _DAMPING, *_MOUNTED = range(
    len(COLUMNS)
)
_MOUNTED_INERTIA, _MOUNTED_FREQUENCY, _MOUNTED_LOSS = _MOUNTED
DERIVED = (_LENGTH, _MOMENT, _WALL, _STEEL, _INERTIA, _DAMPING)
"""Columns to which there are derivatives."""
_REFERENCE = 2 * np.pi
"""rad/s, at which a loss factor leaves the shear modulus as it is."""


@compiled
def _stiffness(loss: float, power_law: bool, frequency: float) -> complex:
    """Shear modulus with a loss factor, relative to that without: Kjartansson's law, or Makris's to first order."""
    if loss == 0.0:
        return complex(1.0, 0.0)
    if not power_law:
        return complex(1.0 + 2 / np.pi * loss * np.log(frequency / _REFERENCE), loss)
    exponent = 2 / np.pi * np.arctan(loss)
    size = np.sqrt(1 + loss * loss) * (frequency / _REFERENCE) ** exponent
    return complex(size * np.cos(exponent * np.pi / 2), size * np.sin(exponent * np.pi / 2))


@compiled
def _shunt(piece: Floats, turning: float) -> complex:
    """Admittance per length and polar moment at an angular frequency, of steel, drag and what is mounted."""
    rubbing = piece[_ROOT_DRAG] * np.sqrt(0.5 * turning) if piece[_ROOT_DRAG] != 0.0 else 0.0
    shunt = complex(piece[_WALL] + rubbing, piece[_DENSITY] * turning + rubbing)
    if piece[_MOUNTED_INERTIA] != 0.0:
        own = 2 * np.pi * piece[_MOUNTED_FREQUENCY]
        mount = complex(own * own, own * piece[_MOUNTED_LOSS] * turning)
        shunt += complex(0.0, piece[_MOUNTED_INERTIA] * turning) * mount * inverse(mount - turning * turning)
    return shunt


@compiled
def top_load(string: Floats, power_law: bool, below: Complex, frequency: Floats) -> Complex:
    """Torque per speed at the top of a string, (F,) N m s/rad.

    Parameters
    ----------
    string : (pieces, COLUMNS) from top to bottom
    power_law : whether steel with losses follows Kjartansson's law, else Makris's
    below : (F,) torque per speed at the lower end beside that of the lumps, N m s/rad
    frequency : (F,) rad/s, positive
    """
    load = below.copy()
    for place in range(string.shape[0] - 1, -1, -1):
        piece = string[place]
        moment, length, shear = piece[_MOMENT], piece[_LENGTH], piece[_SHEAR]
        steel, loss = piece[_STEEL], piece[_LOSS]
        inertia, damping = piece[_INERTIA], piece[_DAMPING]
        for j in range(frequency.size):
            turning = frequency[j]
            shunt = _shunt(piece, turning)
            stiff = shear / turning * _stiffness(loss, power_law, turning)
            series = complex(steel + stiff.imag, -stiff.real)
            gamma = root(shunt * inverse(series))
            own = moment * series * gamma
            at = load[j] + complex(damping, inertia * turning)
            load[j] = through_section(own, at, falling(2.0 * length * gamma))[0]
    return load


@compiled
def top_load_slopes(
    string: Floats, power_law: bool, below: Complex, frequency: Floats, changes: Floats, places: Integers
) -> tuple[Complex, Complex]:
    """The same, and its derivatives to some parameters on which the pieces depend, (P, F).

    Parameters
    ----------
    changes : (P, C) derivatives of numbers of the string to the parameters
    places : (C, 2) piece and column, one of DERIVED, of each of those numbers; in the order of the pieces
    """
    pieces, count = string.shape[0], frequency.size
    load = below.copy()
    by_load = np.empty((pieces, count), np.complex128)
    by_parts = np.empty((pieces, 4, count), np.complex128)
    for place in range(pieces - 1, -1, -1):
        piece = string[place]
        moment, length, shear = piece[_MOMENT], piece[_LENGTH], piece[_SHEAR]
        steel, loss = piece[_STEEL], piece[_LOSS]
        inertia, damping = piece[_INERTIA], piece[_DAMPING]
        for j in range(count):
            turning = frequency[j]
            shunt = _shunt(piece, turning)
            stiff = shear / turning * _stiffness(loss, power_law, turning)
            series = complex(steel + stiff.imag, -stiff.real)
            per_series = inverse(series)
            gamma = root(shunt * per_series)
            own = moment * series * gamma
            at = load[j] + complex(damping, inertia * turning)
            load[j], to_load, to_own, to_phase = through_section(own, at, falling(2.0 * length * gamma))
            half = 0.5 * inverse(gamma) * per_series
            by_load[place, j] = to_load
            by_parts[place, 0, j] = to_phase * gamma
            by_parts[place, 1, j] = to_own * series * gamma
            by_parts[place, 2, j] = to_own * moment * series * half + to_phase * length * half
            by_parts[place, 3, j] = 0.5 * gamma * (to_own * moment - to_phase * length * per_series)
    slopes = np.zeros((changes.shape[0], count), np.complex128)
    through = np.ones(count, np.complex128)
    reached = 0
    for number in range(places.shape[0]):
        place, column = places[number]
        while reached < place:
            through *= by_load[reached]
            reached += 1
        for parameter in range(changes.shape[0]):
            rate = changes[parameter, number]
            if rate == 0.0:
                continue
            if column == _INERTIA:
                for j in range(count):
                    slopes[parameter, j] += through[j] * by_load[place, j] * complex(0.0, rate * frequency[j])
            elif column == _DAMPING:
                for j in range(count):
                    slopes[parameter, j] += rate * through[j] * by_load[place, j]
            else:
                part = 0 if column == _LENGTH else 1 if column == _MOMENT else 2 if column == _WALL else 3
                for j in range(count):
                    slopes[parameter, j] += rate * through[j] * by_parts[place, part, j]
    return load, slopes
