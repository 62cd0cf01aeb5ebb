"""Random rigs of the second world: strings as they are run, operating points, and documents that may be wrong."""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.hidden import altered
from benchmarks.blind.other_world.pieces import changed
from benchmarks.blind.other_world.rig import (
    DENSITY,
    LAWS,
    RECORDINGS,
    SHEAR_MODULUS,
    Contact,
    Control,
    Drive,
    Friction,
    Piece,
    Recording,
    Rock,
    Window,
    coupling,
)
from drillid.arrays import Floats

PIPES = ((0.0889, 0.0702), (0.1016, 0.0848), (0.1143, 0.0972), (0.127, 0.1086), (0.1397, 0.1214), (0.1492, 0.1297))
"""Outer and inner diameter of drill pipes, m (API RP 7G)."""
_REFERENCE = float(np.pi / 32 * (0.1397**4 - 0.1214**4))
SWEEP = 500.0
"""N m, amplitude of each sweep for 5½" pipe; other pipes in proportion to their polar moment."""
STAND = 28.0
"""m of pipe."""
WINDOW_COUNTS = (1, 2, 3, 6, 10, 16, 24)
_COUNT_PROBABILITIES = (0.25, 0.22, 0.18, 0.15, 0.10, 0.06, 0.04)
_INTERVALS = (2.0, 20.0)
"""Least and largest interval of a control, in steps of 2.5 ms."""
INTERVAL_SPREAD = float(np.log10(_INTERVALS[1] / _INTERVALS[0]) / np.sqrt(12))
"""Its standard deviation in decades."""
_MOST_DECADES = 2.0
"""Decades that a test may take it to be off."""
CLOCK_ERROR = 0.002
"""s, standard uncertainty between the clocks of speed and torque."""
_JOINT_LENGTH, _PIPE_LENGTH = 0.45, 9.5
"""m, of a tool joint, and from one to the next."""
WRONG_SHEETS = 0.05
"""Share of data sheets with a value that is wrong outright."""
_WRONG_FACTORS = (0.7, 0.8, 1.25, 1.4)
WRONG_BY = float(np.sqrt(np.mean(np.log(_WRONG_FACTORS) ** 2)))
"""By how much, as the root of the mean square of its logarithm."""
LOCAL_SPREAD = np.array([0.15, 0.10, 0.15])
"""Relative standard deviation of a window's κ, δ and damping at the bit from the set's."""
_MEMORY = 0.7
_FARTHEST = 15.0
"""Largest heavy-tailed error; four in ten thousand would lie farther out. A length that is stated to 3 % is off by 45 %
at most, and no mass is negative."""
_LARGEST_PHASE = 0.5
"""rad, largest phase lag by delay and hold at the crossover of proportional gain and top-drive inertia."""


@dataclass(frozen=True)
class Segment:
    """One window of drilling."""

    hole_depth: float
    """m."""
    pipe_length: float
    """m."""
    wall_damping: float
    steel_damping: float
    bit_damping: float
    speed: float
    """rad/s."""
    noise: float
    """N m rms."""


@dataclass(frozen=True)
class Rig:
    """A rig and its string; pieces without length are templates."""

    pipe: Piece
    """With its tool joints as a mean; waves are slower by what the documents do not know."""
    shoe: float
    """m, depth of the casing's shoe."""
    cased: float
    """κ in the casing relative to the open hole's."""
    heavy: tuple[float, float]
    """m, and moment relative to the pipe's, of heavier pipe above the collars; short."""
    collars: tuple[Piece, ...]
    """With stabilisers."""
    bit_inertia: float
    """kg m²."""
    motor: tuple[float, float]
    """Compliance (rad/(N m)) of a mud motor and share of the lumped inertia above it; no compliance without one."""
    drive: Drive
    control: Control
    rock: Rock
    contacts: tuple[Contact, ...]
    recording: Recording
    sweep: float
    """N m."""
    weight_on_bit: float
    """N."""
    speed_wander: float
    length_relative: float
    """Standard uncertainty of the pipe's travel time, as the documents state it."""

    @property
    def collar_length(self) -> float:
        """M."""
        return sum(piece.length for piece in self.collars)

    @property
    def delay(self) -> float:
        """Delay of the drive with the mean of the command's hold, s."""
        return self.drive.delay + self.control.interval / 2


@dataclass(frozen=True)
class Sheet:
    """What the documents say, each with its standard uncertainty; the fields that the library's data sheets have."""

    proportional: float
    integral: float
    controller_relative: float
    collar_length: float
    collar_polar_moment: float
    collar_relative: float
    delay: float
    delay_error: float
    inertia_td: float
    inertia_td_error: float
    polar_moment: float
    polar_moment_error: float
    length_relative: float
    clock_error: float
    wrong: str = ""
    """The value that is wrong outright."""


def log_uniform(generator: np.random.Generator, low: float, high: float) -> float:
    """A draw between two limits, uniform in the logarithm."""
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def heavy_tailed(generator: np.random.Generator, size: int | None = None) -> Floats:
    """Student's t of three degrees of freedom, scaled to have two thirds within one, and clipped at _FARTHEST."""
    return np.asarray(np.clip(generator.standard_t(3.0, size) / 1.2, -_FARTHEST, _FARTHEST), dtype=float)


def draw_rig(generator: np.random.Generator) -> Rig:
    """A rig whose torques scale with its pipe."""
    outer, inner = PIPES[generator.integers(len(PIPES))]
    length_relative = float(generator.uniform(0.01, 0.03))
    pipe = _with_joints(generator, float(np.pi / 32 * (outer**4 - inner**4)), length_relative)
    relative = pipe.moment / _REFERENCE
    own = pipe.admittance
    pipe = altered(
        pipe,
        length=log_uniform(generator, 1000.0, 5000.0),
        wall_damping=log_uniform(generator, 50.0, 400.0),
        steel_damping=log_uniform(generator, 1.5e8, 7e8),
    )
    interval = 0.0025 * round(log_uniform(generator, *_INTERVALS))
    inertia = log_uniform(generator, 500.0, 3500.0) * float(np.sqrt(relative))
    delay = float(generator.uniform(0.015, 0.05))
    gain = min(own * float(generator.uniform(1.5, 6.0)), _LARGEST_PHASE * inertia / (delay + interval / 2))
    torque = float(generator.uniform(3000.0, 8000.0)) * relative
    windup = float(generator.choice([0.0, 0.2, 1.0])) * gain / 1000.0
    return Rig(
        pipe=pipe,
        shoe=pipe.length * float(generator.uniform(0.3, 0.95)),
        cased=float(generator.uniform(0.7, 1.0)),
        heavy=(float(generator.uniform(0.0, 20.0)), float(generator.uniform(1.2, 1.8))),
        collars=_collars(generator, pipe, outer),
        bit_inertia=relative * float(generator.uniform(10.0, 60.0)),
        motor=(
            log_uniform(generator, 5e-7, 3e-6) / relative if generator.random() < 0.3 else 0.0,
            float(generator.uniform(0.1, 0.9)),
        ),
        drive=Drive(inertia, delay),
        control=Control(gain, gain * float(generator.uniform(0.2, 0.8)), interval, windup_gain=windup),
        rock=_rock(generator, 0.75 * torque),
        contacts=_wall(generator, 0.25 * torque),
        recording=_recording(generator, interval),
        sweep=SWEEP * relative,
        weight_on_bit=float(generator.uniform(5e4, 2e5)),
        speed_wander=log_uniform(generator, 1e-4, 5e-3),
        length_relative=length_relative,
    )


def _with_joints(generator: np.random.Generator, moment: float, relative: float) -> Piece:
    """Pipe with tool joints, whose mean the documents know to within their uncertainty of the travel time."""
    share, ratio = _JOINT_LENGTH / _PIPE_LENGTH, float(generator.uniform(2.5, 4.5))
    heavier, softer = 1 + share * (ratio - 1), 1 - share * (1 - 1 / ratio)
    slow = 1 + relative * float(heavy_tailed(generator))
    # the documents give the moment as waves see it, and length with the joints' delay
    return Piece(
        1.0, moment * float(np.sqrt(heavier / softer)), density=DENSITY * slow, shear_modulus=SHEAR_MODULUS / slow
    )


def _collars(generator: np.random.Generator, pipe: Piece, outer: float) -> tuple[Piece, ...]:
    """Collars of two sizes with two to four stabilisers."""
    length, size = float(generator.uniform(60.0, 220.0)), outer * float(generator.uniform(1.1, 1.5))
    step, share = float(generator.uniform(0.0, 0.05)), float(generator.uniform(0.3, 0.7))
    string: tuple[Piece, ...] = tuple(
        Piece(length * part, _tube(size * (1 + sign * step)), pipe.wall_damping, pipe.steel_damping)
        for part, sign in ((share, -1), (1 - share, 1))
    )
    for _ in range(int(generator.integers(2, 5))):
        begin = float(generator.uniform(0.05, 0.9)) * length
        wider = _tube(size * float(generator.uniform(1.05, 1.3)))
        rubbing = pipe.wall_damping * float(generator.uniform(1.0, 10.0))
        string = changed(
            string, begin, begin + 1.8, lambda piece, m=wider, k=rubbing: altered(piece, moment=m, wall_damping=k)
        )
    return string


def _tube(outer: float) -> float:
    """Polar moment of a collar, m⁴."""
    return float(np.pi / 32 * outer**4 * (1 - 0.45**4))


def _rock(generator: np.random.Generator, torque: float) -> Rock:
    """Rock without its level of noise, which differs from window to window."""
    lines = []
    if generator.random() < 0.4:
        lines.append((float(generator.uniform(0.8, 2.2)), float(generator.uniform(0.05, 0.3))))
    if generator.random() < 0.3:
        lines.append((float(generator.uniform(4.0, 15.0)), float(generator.uniform(0.05, 0.5))))
    return Rock(
        mean=torque,
        noise=1.0,
        bandwidth=log_uniform(generator, 0.6, 5.0),
        swing=float(generator.uniform(0.0, 0.3)),
        tail=float(generator.choice([np.inf, 8.0, 5.0])),
        bursts=float(generator.choice([0.0, 0.01, 0.03])),
        lines=tuple(lines),
        wander=float(generator.uniform(0.0, 0.06)),
    )


def _wall(generator: np.random.Generator, torque: float) -> tuple[Contact, ...]:
    """Contacts whose friction is that of sliding at any speed."""
    law, count = LAWS[generator.integers(len(LAWS))], int(generator.integers(3, 9))
    share = generator.dirichlet(np.full(count, 2.0))
    places = np.sort(generator.uniform(0.05, 0.95, count))
    return tuple(
        Contact(float(at), Friction(law, torque * float(part))) for at, part in zip(places, share, strict=True)
    )


def _recording(generator: np.random.Generator, interval: float) -> Recording:
    return Recording(
        kind=RECORDINGS[generator.integers(len(RECORDINGS))],
        phase=float(generator.uniform(0.0, interval)),
        noise=log_uniform(generator, 5e-4, 5e-3),
        offset=CLOCK_ERROR * float(heavy_tailed(generator)),
        resolution=float(generator.choice([0.0, 1e-4])),
    )


def draw_segments(generator: np.random.Generator, rig: Rig, count: int | None = None) -> tuple[Segment, ...]:
    """Successive windows of drilling ahead, two a stand."""
    if count is None:
        count = int(generator.choice(WINDOW_COUNTS, p=_COUNT_PROBABILITIES))
    bit_damping = rig.pipe.admittance * float(generator.uniform(0.02, 0.4))
    base = np.array([rig.pipe.wall_damping, rig.pipe.steel_damping, bit_damping])
    deviation = heavy_tailed(generator, 3)
    speed = float(generator.uniform(7.0, 18.0))
    noise = log_uniform(generator, 80.0, 600.0) * rig.sweep / SWEEP
    segments = []
    for number in range(count):
        deviation = _MEMORY * deviation + np.sqrt(1 - _MEMORY**2) * heavy_tailed(generator, 3)
        wall, steel, damping = (float(value) for value in base * np.exp(np.clip(LOCAL_SPREAD * deviation, -1.0, 1.0)))
        length = rig.pipe.length + STAND * (number // 2)
        depth = length + rig.collar_length + STAND / 2 * (number % 2)
        rotation = speed * float(generator.uniform(0.8, 1.2))
        level = noise * float(np.exp(0.2 * generator.standard_normal()))
        segments.append(Segment(depth, length, wall, steel, damping, rotation, level))
    return tuple(segments)


def draw_sheet(generator: np.random.Generator, rig: Rig) -> Sheet:
    """Documents in error by heavy-tailed variables of their tolerances; one in twenty has a value that is wrong."""
    errors = heavy_tailed(generator, 6)
    delay_error = float(generator.uniform(0.003, 0.005))
    inertia = sum(piece.inertia for piece in rig.collars)
    moment = inertia / DENSITY / rig.collar_length * (1 + 0.05 * errors[4])
    control = rig.control
    sheet = Sheet(
        proportional=control.proportional * (1 + 0.02 * float(errors[0])),
        integral=control.integral * (1 + 0.02 * float(errors[1])),
        controller_relative=0.02,
        collar_length=rig.collar_length,
        collar_polar_moment=float(moment),
        collar_relative=0.1,
        delay=rig.delay + delay_error * float(errors[5]),
        delay_error=delay_error,
        inertia_td=rig.drive.inertia * (1 + 0.02 * float(errors[2])),
        inertia_td_error=0.02 * rig.drive.inertia,
        polar_moment=rig.pipe.moment * (1 + 0.05 * float(errors[3])),
        polar_moment_error=0.05 * rig.pipe.moment,
        length_relative=rig.length_relative,
        clock_error=CLOCK_ERROR,
    )
    if generator.random() >= WRONG_SHEETS:
        return sheet
    wrong = str(generator.choice(["inertia_td", "polar_moment", "collar_polar_moment", "delay"]))
    factor = float(generator.choice(_WRONG_FACTORS))
    return altered(sheet, wrong=wrong, **{wrong: getattr(sheet, wrong) * factor})


def base_window(rig: Rig, segment: Segment, nuisances: Floats | None = None) -> Window:
    """A window without hidden causes; `nuisances` of shape (12,) are offsets from the truth.

    They are those of the ideal test: κ (100 N s/m⁴), δ (logarithm), relative length and polar moment, delay (10 ms),
    relative inertia of the top drive, damping (50 N m s/rad) and inertia (50 kg m²) at the bit, relative gains P and I,
    clock (ms), interval of the control (decades). The delay is as the documents state it, with half an interval of the
    hold.
    """
    off = np.zeros(12) if nuisances is None else nuisances
    wall, steel = segment.wall_damping + 100.0 * off[0], segment.steel_damping * np.exp(off[1])
    pipe = altered(
        rig.pipe,
        length=segment.pipe_length * (1 + off[2]),
        moment=rig.pipe.moment * (1 + off[3]),
        wall_damping=wall,
        steel_damping=steel,
    )
    shoe = min(rig.shoe * (1 + off[2]), pipe.length)
    string = changed((pipe,), 0.0, shoe, lambda piece: altered(piece, wall_damping=rig.cased * wall))
    heavy, ratio = rig.heavy
    string = changed(
        string, pipe.length - heavy, pipe.length, lambda piece: altered(piece, moment=ratio * piece.moment)
    )
    rubbing = [piece.wall_damping / rig.collars[0].wall_damping for piece in rig.collars]
    collars = (
        altered(piece, wall_damping=share * wall, steel_damping=steel)
        for piece, share in zip(rig.collars, rubbing, strict=True)
    )
    bottom = lower_end(
        (*string, *collars), rig.bit_inertia + 50.0 * off[7], segment.bit_damping + 50.0 * off[6], rig.motor
    )
    control = altered(
        rig.control,
        proportional=rig.control.proportional * (1 + off[8]),
        integral=rig.control.integral * (1 + off[9]),
        interval=rig.control.interval * 10 ** float(np.clip(off[11], -_MOST_DECADES, _MOST_DECADES)),
    )
    of_hold = (control.interval - rig.control.interval) / 2
    drive = altered(
        rig.drive, inertia=rig.drive.inertia * (1 + off[5]), delay=rig.drive.delay + 0.01 * off[4] - of_hold
    )
    rock = altered(
        rig.rock, noise=segment.noise, lines=tuple((at, size * segment.noise) for at, size in rig.rock.lines)
    )
    recording = altered(rig.recording, offset=rig.recording.offset + 1e-3 * off[10])
    return Window(
        bottom, control, drive, rock, segment.speed, rig.sweep, recording, rig.contacts, speed_wander=rig.speed_wander
    )


def lower_end(
    string: tuple[Piece, ...], inertia: float, damping: float, motor: tuple[float, float]
) -> tuple[Piece, ...]:
    """The string with bit and mud motor.

    Parameters
    ----------
    inertia, damping : of the lump at the lower end, kg m² and N m s/rad
    motor : compliance in rad/(N m), and share of the inertia above it; a rigid joint at no compliance
    """
    compliance, share = motor
    *above, last = string
    if compliance == 0:
        return (*above, altered(last, inertia_below=inertia, damping_below=damping))
    housing = altered(last, inertia_below=share * inertia, damping_below=0.0)
    return (
        *above,
        housing,
        altered(coupling(1 / compliance), inertia_below=(1 - share) * inertia, damping_below=damping),
    )
