"""Motion along the string, and detections of friction that weakens with speed.

Speed and torque at the top drive are propagated down the string by its transfer matrix (equation 5 of the paper),
which needs no boundary condition at the bit. The effect at the top of the torque that friction would then add follows
by reciprocity: the transfer mobility from a depth to the top equals that from the top to the depth.
"""

from dataclasses import replace

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import stdtr

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value
from drillid.discrepancy.detectors.tone import strongest_line, swings_in_limit_cycle
from drillid.physics.bottom_end import bit_load
from drillid.physics.line import chain_entries, input_admittance, speed_ratio
from drillid.physics.top_drive import drive

_LOW_PASS = (1.5, 3.0)
"""Hz, roll-off of the low pass on motion along the string: above it, errors of the record grow on their way down."""
_TOP_LOW_PASS = (3.0, 6.0)
"""Hz, roll-off for the torque at the top."""
_PLACES = (0.2, 0.4, 0.6, 0.8)
"""Shares of the pipe's length at which wall friction is computed."""
_REFERENCE_SPEED = 10.0
"""rad/s, at which sizes of weakening friction are stated; its slope is proportional to 1/speed²."""

_BLOCK_S = 20.0
_ENDS_S = 20.0
"""s at either end where the computed motion would need data from outside the window."""
_LEAST_BLOCKS = 4
_STANDING = 0.15
"""Speed, as a share of the mean, below which the bit counts as standing."""
_TURNS_BACK = 1.0
"""Swing of the bit per mean speed from which it would turn back; the rock, which only resists, holds it instead."""
_LEAST_SHARE = 0.005
"""Share of the time about zero below which there are too few data."""


class Motion:
    """Speed and torque along the string, computed from the top."""

    def __init__(self, residual: ResidualRecord) -> None:
        self.residual = residual
        self.low_pass = low_pass(residual.frequency, _LOW_PASS)
        s, top_drive = residual.s, residual.system.top_drive
        speed, command = rfft(_centred(residual.speed)), rfft(_centred(residual.command))
        self.drive_torque: Complex = np.ravel(drive(top_drive, s)) * command
        self.inertial_torque: Complex = np.ravel(top_drive.inertia * s) * speed
        self.speed: Complex = speed * self.low_pass
        self.torque: Complex = (self.drive_torque - self.inertial_torque) * self.low_pass

    def top_torque(self, above: float) -> Floats:
        """Torque (samples,) including its mean, N m, at a section of the top drive with a share `above` of its inertia
        above it; 1 gives the torque into the string.

        Low-passed at 6 Hz; the logged command gives its mean.
        """
        mean = float(self.residual.command.mean())
        torque = (self.drive_torque - above * self.inertial_torque) * low_pass(self.residual.frequency, _TOP_LOW_PASS)
        return np.asarray(irfft(torque, self.residual.samples) + mean, dtype=float)

    def below(self, share: float) -> tuple[Floats, Complex]:
        """Speed about its mean (samples,), rad/s, at a share of the pipe's length, 1 standing for the bit, and the
        transfer mobility (line,) from a torque there to the speed at the top, rad/(N m s).
        """
        residual, s = self.residual, self.residual.s
        pipe, *lower = residual.system.string
        above = replace(pipe, length=pipe.length * share)
        remaining = () if share == 1 else (replace(pipe, length=pipe.length * (1 - share)), *lower)
        crossed = (above, *lower) if share == 1 else (above,)
        load = bit_load(residual.system.bit, s)
        for section in reversed(remaining):
            load = input_admittance(section, load, s)
        ratio: Complex = np.ones_like(s)
        for section in reversed(crossed):
            ratio = ratio * np.ravel(speed_ratio(section, load, s))
            load = input_admittance(section, load, s)
        speed, torque = self.speed, self.torque
        kept = self.low_pass > 0
        for section in crossed:
            cosh, series, shunt, _ = (
                np.where(kept, np.ravel(entry), 0) for entry in chain_entries(section, s * kept + (~kept))
            )
            speed, torque = cosh * speed - series * torque, cosh * torque - shunt * speed
        transfer: Complex = np.asarray(residual.top_mobility * ratio, dtype=complex)
        return np.asarray(irfft(speed, residual.samples), dtype=float), transfer


def low_pass(frequency: Floats, band: tuple[float, float]) -> Floats:
    """Low pass that rolls off from 1 to 0 over a band, (line,)."""
    low, high = band
    return np.asarray(np.sin(np.pi / 2 * np.clip((high - frequency) / (high - low), 0.0, 1.0)) ** 2, dtype=float)


def _centred(series: Floats) -> Floats:
    return np.asarray(series - series.mean(), dtype=float)


class WeakeningBitDetector(Detector):
    """Friction at the bit that weakens with speed."""

    # of one slope, an exponential, a Gaussian and a rational law are curved differently
    least_shown = 0.1

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed due to the curvature of the friction at the bit."""
        response = _response_to_squared_speed(inspection.cached(Motion), 1.0)
        return Candidate(name, _curvature(inspection.residual) * response[None], one_sided=True)


class WeakeningWallDetector(Detector):
    """Friction along the wall that weakens with speed."""

    # where the bit stands, the swing of its limit cycle is larger than a curvature can describe
    excluded_by = ("stuck_slip_regimes",)

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed due to the curvature of the friction at a few places along the pipe."""
        motion, pipe = inspection.cached(Motion), inspection.residual.system.string[0]
        per_length = float(np.ravel(pipe.polar_moment * pipe.length)[0]) / len(_PLACES)
        response = np.sum([_response_to_squared_speed(motion, share) for share in _PLACES], axis=0)
        return Candidate(name, _curvature(inspection.residual) * per_length * response[None], one_sided=True)


class StandingBitDetector(Detector):
    """A bit that dwells at standstill, or swings so far in a limit cycle that it would turn backward otherwise."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score of the time at standstill or of the limit cycle's line, None where there is hardly any of either; the
        size is the swing per mean speed.
        """
        residual = inspection.residual
        mean = float(residual.speed.mean())
        speed = inner(residual, mean + inspection.cached(Motion).below(1.0)[0])
        if not speed.size:
            return None
        swing = float(np.ptp(np.quantile(speed, [0.025, 0.975]))) / (2 * abs(mean))
        standing = dwelling(residual, speed, _STANDING * abs(mean))
        normals = [] if standing is None else [standing]
        line = inspection.cached(strongest_line)
        if line is not None and swing > _TURNS_BACK and swings_in_limit_cycle(inspection):
            normals.append(line.score.normal)
        if not normals:
            return None
        return Score(max(normals), swing, 0.1 * swing, max(*normals, 0.0) ** 2 / 2)


def _curvature(residual: ResidualRecord) -> float:
    """Second derivative, per unit of size, of a torque with slope −size (10/Ω)²: 200/Ω³."""
    return float(2 * _REFERENCE_SPEED**2 / float(residual.speed.mean()) ** 3)


def _response_to_squared_speed(motion: Motion, share: float) -> Floats:
    """Speed at the top (samples,), rad/s, due to a resisting torque of half the squared variation of local speed."""
    speed, transfer = motion.below(share)
    return motion.residual.filtered(-transfer, _centred(speed**2 / 2))


def inner(residual: ResidualRecord, series: Floats) -> Floats:
    """A series (samples,) without its ends, where motion computed from the top needs data from outside the window;
    empty where the window is too short.
    """
    ends = round(_ENDS_S * residual.record.rate)
    return series[ends:-ends]


def dwelling(residual: ResidualRecord, series: Floats, width: float) -> float | None:
    """Standard normal value of the time spent about zero, in excess of that expected; None where there are few data.

    The expected time is extrapolated from two pairs of bands beside zero, as by a parabola.
    """
    off = np.abs(series) / width
    near_zero, beside, beyond = off < 1, (off >= 1) & (off < 3), (off >= 3) & (off < 5)
    count = int(series.size / residual.record.rate / _BLOCK_S)
    if count < _LEAST_BLOCKS or near_zero.mean() < _LEAST_SHARE:
        return None
    # the bands lie at 2 and 4 widths and are twice as wide together
    excess = near_zero - (4 * beside - beyond) / 6
    blocks = np.array([block.mean() for block in np.array_split(excess, count)])
    deviation = float(blocks.std(ddof=1)) / np.sqrt(count)
    if deviation == 0:
        return None
    return normal_of_p_value(float(stdtr(count - 1, -blocks.mean() / deviation)))
