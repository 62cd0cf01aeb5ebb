"""Causes along the string, at its lower end and in time, as the second world knows them."""

import numpy as np

from benchmarks.blind.hidden import Hidden, altered
from benchmarks.blind.other_world.effect import Context, Effect, Range
from benchmarks.blind.other_world.pieces import changed, cut, shortened
from benchmarks.blind.other_world.rig import FALLS, Blades, Contact, Friction, Piece, Window, coupling
from benchmarks.blind.other_world.rigs import log_uniform, lower_end

_STEPS = 8
"""Pieces of either end of a zone."""
_CONTACTS = 10
_MOMENTS = 601
"""Of a window, between two of which a jump takes place: within a second of a window of ten minutes."""
_RIPPLE_LENGTH, _RIPPLES = 600.0, 12
"""m, of a ripple of the pipe's wall, and pieces of each."""
_SWING_SPEED = 6.5
"""rad/s, mean speed of strings that stick and slip."""


def _pipe_changed(window: Window, begin: float, end: float, **factors: float) -> Window:
    """Parameters of the pipe between two depths (m) times factors."""

    def change(piece: Piece) -> Piece:
        return altered(piece, **{name: getattr(piece, name) * factor for name, factor in factors.items()})

    return altered(window, string=changed(window.string, begin, end, change))


def _pipe_end(window: Window, context: Context) -> float:
    """Depth at which the collars begin (m), also of a string whose pipe is not as long as the context says."""
    below = context.rig.collar_length + (coupling(1.0).length if _has_spring(window) else 0.0)
    return window.length - below


def _has_spring(window: Window) -> bool:
    """Whether the lowest piece is the spring of a motor."""
    return window.string[-1].length == coupling(1.0).length


_SECTION_MOMENTS = (1.3, 6.0)
"""Range of the polar moment of an extra section per pipe's."""
_LOWER_SHARES = (0.15, 0.85)
"""Range of the share of the first window's pipe that the lower size takes."""


def section_moment(shape: float) -> float:
    """Polar moment of an extra section per pipe's: heavy-weight pipe or collars of any size."""
    least, most = _SECTION_MOMENTS
    return float(least * (most / least) ** shape)


def lower_share(shape: float) -> float:
    """Share of the first window's pipe that the lower size takes."""
    least, most = _LOWER_SHARES
    return least + (most - least) * shape


def same_string(hidden: Hidden, pipe_length: float) -> tuple[Hidden, ...]:
    """The extra section that is a string of two sizes, and the reverse; none for other causes.

    Parameters
    ----------
    pipe_length : m, in the first window
    """
    if hidden.name == "tapered_string":
        shape = np.interp(np.log(1 + hidden.size), np.log(_SECTION_MOMENTS), (0.0, 1.0))
        return (Hidden("extra_section", lower_share(hidden.shape) * pipe_length, float(shape)),)
    if hidden.name == "extra_section":
        shape = np.interp(hidden.size / pipe_length, _LOWER_SHARES, (0.0, 1.0))
        return (Hidden("tapered_string", section_moment(hidden.shape) - 1, float(shape)),)
    return ()


def _extra_section(window: Window, size: float, context: Context) -> Window:
    end = _pipe_end(window, context)
    return _pipe_changed(window, end - size, end, moment=section_moment(context.shape))


def _tapered_string(window: Window, size: float, context: Context) -> Window:
    """The lower pipe goes down with the bit: what is added while drilling is upper pipe."""
    lower = context.first.pipe_length * lower_share(context.shape)
    end = _pipe_end(window, context)
    return _pipe_changed(window, end - lower, end, moment=1 + size)


def zone(context: Context) -> tuple[float, float, float]:
    """Middle and width of a zone of damping between the middles of its ends, and the ends' length, m.

    It stays in the hole while the string moves on.
    """
    generator, pipe = context.generator(), context.first.pipe_length
    width = log_uniform(generator, 0.01, 0.3) * pipe
    end = float(generator.uniform(0.1, 1.0)) * width
    reach = (width + end) / 2
    middle = reach + (pipe - 2 * reach) * (0.01 + 0.98 * context.shape)
    return middle, width, end


def _local_damping_zone(window: Window, size: float, context: Context) -> Window:
    middle, width, end = zone(context)
    begin, string = middle - (width + end) / 2, window.string
    rise = np.sin(np.pi / 2 * (np.arange(_STEPS) + 0.5) / _STEPS) ** 2
    edges = [begin + end * number / _STEPS for number in range(_STEPS + 1)]
    spans = [*zip(edges, edges[1:], rise, strict=False)]
    spans += [(edges[-1], middle + (width - end) / 2, 1.0)] if width > end else []
    spans += [(2 * middle - below, 2 * middle - above, level) for above, below, level in reversed(spans[:_STEPS])]
    for above, below, level in spans:
        # the same damping per length, whatever the pipe
        string = changed(
            string,
            above,
            below,
            lambda piece, level=level: altered(
                piece, wall_damping=piece.wall_damping + float(level) * size / width / piece.moment
            ),
        )
    return altered(window, string=string)


def _everywhere(window: Window, **parameters: float) -> Window:
    return altered(window, string=tuple(altered(piece, **parameters) for piece in window.string))


def _coulomb_contact(window: Window, size: float, context: Context) -> Window:
    """Friction of all contacts that falls with speed; its slope takes `size` (10 rad/s/Ω)² from κ in the mean."""
    fall = FALLS[int(context.generator().integers(len(FALLS)))]
    law = "lugre" if context.shape > 0.5 else "karnopp"
    torque = sum(contact.friction.coulomb for contact in window.contacts)
    length = sum(piece.length for piece in window.string)
    contacts = []
    for place in range(_CONTACTS):
        below = cut(window.string, place * length / _CONTACTS)[1]
        around = below if place == _CONTACTS - 1 else cut(below, length / _CONTACTS)[0]
        slope = size * (10.0 / window.speed) ** 2 * sum(piece.moment * piece.length for piece in around)
        rubbing = Friction.with_steepness(law, fall, torque / _CONTACTS, slope, window.speed)
        contacts.append(Contact((place + 0.5) / _CONTACTS, rubbing))
    return altered(window, contacts=tuple(contacts))


def _kappa_range(window: Window, context: Context) -> Range:
    scaled = context.segment.wall_damping * (window.speed / 10.0) ** 2
    return 0.02 * scaled, 0.9 * scaled


def _wave_speed(window: Window, size: float, context: Context) -> Window:
    """Slower waves in the pipe with the same characteristic admittance."""
    return _pipe_changed(window, 0.0, _pipe_end(window, context), density=1 + size, shear_modulus=1 / (1 + size))


def _distributed_bha(window: Window, size: float, context: Context) -> Window:
    pipe, collars = cut(window.string, _pipe_end(window, context))
    further = altered(collars[0], length=size, inertia_below=0.0, damping_below=0.0)
    return altered(window, string=(*shortened(pipe, size), further, *collars))


def _motor_compliance(window: Window, size: float, context: Context) -> Window:
    """A motor anywhere within the lumped inertia."""
    string = window.string
    inertia, damping = sum(piece.inertia_below for piece in string), string[-1].damping_below
    if _has_spring(window):
        string = string[:-1]
    share = float(context.generator().uniform(0.05, 0.95))
    return altered(window, string=lower_end(string, inertia, damping, (size, share)))


def _regenerative_cutting(window: Window, size: float, context: Context) -> Window:
    count = 3 + min(int(6 * context.shape), 5)
    return altered(
        window, blades=Blades(count, size), rock=altered(window.rock, mean=max(window.rock.mean - size, 0.0))
    )


def _bearable(window: Window, share: float) -> float:
    """Damping at the bit that negative damping there may take without a limit cycle, N m s/rad."""
    return window.string[-1].damping_below + share * window.string[0].admittance


def _regenerative_range(window: Window, context: Context) -> Range:
    bearable = _bearable(window, 0.3) * window.speed
    return 0.02 * bearable, 0.8 * bearable


def _rock_falls(window: Window, steepness: float, speed: float, context: Context) -> Window:
    """Rock whose friction falls by a steepness (N m s/rad) at a speed; its law is drawn."""
    fall = FALLS[int(context.generator().integers(len(FALLS)))]
    law = "lugre" if context.shape > 0.5 else "karnopp"
    rubbing = Friction.with_steepness(law, fall, 0.3 * window.rock.mean, steepness, speed)
    rest = max(window.rock.mean - rubbing.level(window.speed), 0.0)
    return altered(window, bit_friction=rubbing, rock=altered(window.rock, mean=rest))


def _stribeck_cutting(window: Window, size: float, context: Context) -> Window:
    return _rock_falls(window, size * (10.0 / window.speed) ** 2, window.speed, context)


def _stribeck_range(window: Window, context: Context) -> Range:
    scaled = _bearable(window, 0.2) * (window.speed / 10.0) ** 2
    return 0.02 * scaled, 0.7 * scaled


def _stuck_slip_regimes(window: Window, size: float, context: Context) -> Window:
    """Slow rotation on rock whose torque falls by `size` times the pipe's characteristic admittance per speed."""
    slow = altered(window, speed=min(window.speed, _SWING_SPEED))
    return _rock_falls(
        slow, size * window.string[0].admittance + window.string[-1].damping_below, slow.speed / 2, context
    )


def _parameter_drift(window: Window, size: float, context: Context) -> Window:
    return altered(window, damping_course=(0.0, size))


def _regime_change(window: Window, size: float, context: Context) -> Window:
    begin = round((0.3 + 0.4 * context.shape) * _MOMENTS)
    return altered(window, damping_course=tuple(size * (moment >= begin) for moment in range(_MOMENTS)))


def _rippled_pipe(window: Window, size: float, context: Context) -> Window:
    """Pipe whose wall ripples by a share about its mean."""
    string, piece = window.string, _RIPPLE_LENGTH / _RIPPLES
    for number in range(int(context.depth / piece)):
        factor = 1 + size * float(np.sin(2 * np.pi * ((number + 0.5) / _RIPPLES + context.shape)))
        string = changed(
            string,
            number * piece,
            (number + 1) * piece,
            lambda part, factor=factor: altered(part, moment=part.moment * factor),
        )
    return altered(window, string=string)


def _shock_sub(window: Window, size: float, context: Context) -> Window:
    """A soft joint within the pipe, of a compliance in rad/(N m)."""
    above, below = cut(window.string, context.depth * (0.2 + 0.6 * context.shape))
    return altered(window, string=(*above, coupling(1 / size), *below))


EFFECTS = (
    Effect("extra_section", _extra_section, (20.0, 600.0)),
    Effect("tapered_string", _tapered_string, (0.03, 1.5)),
    Effect("local_damping_zone", _local_damping_zone, (5.0, 1500.0)),
    Effect("mud_drag", lambda window, size, _: _everywhere(window, root_drag=size), (10.0, 1500.0)),
    Effect("hysteretic_damping", lambda window, size, _: _everywhere(window, loss_factor=size), (1e-3, 0.1)),
    Effect("coulomb_contact", _coulomb_contact, _kappa_range),
    Effect("wave_speed", _wave_speed, (0.01, 0.25), signed=True),
    Effect("distributed_bha", _distributed_bha, (5.0, 200.0)),
    Effect("motor_compliance", _motor_compliance, (3e-6, 2.5e-4)),
    Effect("regenerative_cutting", _regenerative_cutting, _regenerative_range),
    Effect("stribeck_cutting", _stribeck_cutting, _stribeck_range),
    Effect("stuck_slip_regimes", _stuck_slip_regimes, (0.5, 2.0), linear=False),
    Effect("length_growth", lambda window, size, _: altered(window, growth=size), (2.0, 150.0)),
    Effect("parameter_drift", _parameter_drift, (10.0, 1500.0)),
    Effect("regime_change", _regime_change, (10.0, 1500.0)),
    Effect("rippled_pipe", _rippled_pipe, (0.02, 0.6), in_catalogue=False),
    Effect("shock_sub", _shock_sub, (1e-6, 3e-4), in_catalogue=False),
)
