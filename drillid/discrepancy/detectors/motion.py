"""Motion along the string, and detections of friction that weakens with speed.

Speed and torque at the top drive are carried down the string by its transfer matrix (equation 5 of the paper), which
needs no knowledge of what happens at the bit. The torque that friction would then add is moved back to the
speed at the top by reciprocity: a torque at a depth moves the top as a torque at the top moves that depth.
"""

from dataclasses import replace

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import ndtr, stdtr

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value
from drillid.discrepancy.detectors.tone import swings_in_limit_cycle
from drillid.physics.bottom_end import bit_load
from drillid.physics.line import chain_entries, input_admittance, speed_ratio
from drillid.physics.top_drive import drive

_LOW_PASS = (1.5, 3.0)
"""Hz, between which motion along the string is let go: above, errors of the record grow on their way down."""
_TOP_LOW_PASS = (3.0, 6.0)
"""Hz, the same for the torque at the top."""
_PLACES = (0.2, 0.4, 0.6, 0.8)
"""Shares of the pipe's length at which wall friction is computed."""
_REFERENCE_SPEED = 10.0
"""rad/s, at which sizes of weakening friction are stated; its slope goes with the square of one over the speed."""

_BLOCK_S = 20.0
_ENDS_S = 20.0
"""s at either end where the computed motion lacks data from outside of the window."""
_LEAST_BLOCKS = 4
_STANDING = 0.15
"""Share of the mean speed within which the bit counts as standing."""
_BETWEEN_FLANKS = 0.15
"""Share of the torque's standard deviation within which a gear may be between its flanks."""
_ABOVE_GEAR = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Shares of the top drive's inertia that may turn above the play, as the motor and its gear do."""
_LEAST_SHARE = 0.005
"""Share of the time about zero below which nothing can be told."""


class Motion:
    """Speed and torque along the string, computed from the top."""

    def __init__(self, residual: ResidualRecord) -> None:
        self.residual = residual
        self.low_pass = _passed(residual.frequency, _LOW_PASS)
        s, top_drive = residual.s, residual.system.top_drive
        speed, command = rfft(_steady(residual.speed)), rfft(_steady(residual.command))
        self.driven: Complex = np.ravel(drive(top_drive, s)) * command
        self.turned: Complex = np.ravel(top_drive.inertia * s) * speed
        self.speed: Complex = speed * self.low_pass
        self.torque: Complex = (self.driven - self.turned) * self.low_pass

    def top_torque(self, above: float) -> Floats:
        """Torque with its mean, N m, in a top drive of which a share of the inertia turns above; into the string at 1.

        Up to 6 Hz; the logged command gives its mean.
        """
        mean = float(self.residual.command.mean())
        torque = (self.driven - above * self.turned) * _passed(self.residual.frequency, _TOP_LOW_PASS)
        return np.asarray(irfft(torque, self.residual.samples) + mean, dtype=float)

    def below(self, share: float) -> tuple[Floats, Complex]:
        """Speed about its mean (rad/s) at a share of the pipe's length, 1 standing for the bit, and what a torque
        there does to the speed at the top, rad/(N m s), shape (line,).
        """
        residual, s = self.residual, self.residual.s
        pipe, *lower = residual.system.string
        above = replace(pipe, length=pipe.length * share)
        rest = () if share == 1 else (replace(pipe, length=pipe.length * (1 - share)), *lower)
        passed = (above, *lower) if share == 1 else (above,)
        load = bit_load(residual.system.bit, s)
        for section in reversed(rest):
            load = input_admittance(section, load, s)
        ratio: Complex = np.ones_like(s)
        for section in reversed(passed):
            ratio = ratio * np.ravel(speed_ratio(section, load, s))
            load = input_admittance(section, load, s)
        speed, torque = self.speed, self.torque
        kept = self.low_pass > 0
        for section in passed:
            cosh, series, shunt, _ = (
                np.where(kept, np.ravel(one), 0) for one in chain_entries(section, s * kept + (~kept))
            )
            speed, torque = cosh * speed - series * torque, cosh * torque - shunt * speed
        moved: Complex = np.asarray(residual.moved * ratio, dtype=complex)
        return np.asarray(irfft(speed, residual.samples), dtype=float), moved


def _passed(frequency: Floats, band: tuple[float, float]) -> Floats:
    """Low pass that falls from 1 to 0 over a band, (line,)."""
    low, high = band
    return np.asarray(np.sin(np.pi / 2 * np.clip((high - frequency) / (high - low), 0.0, 1.0)) ** 2, dtype=float)


def _steady(series: Floats) -> Floats:
    return np.asarray(series - series.mean(), dtype=float)


class WeakeningBitDetector(Detector):
    """Friction at the bit that weakens with speed."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed by the curvature of the friction at the bit."""
        bent = _bent(inspection.once(Motion), 1.0)
        return Candidate(name, _curvature(inspection.residual) * bent[None], one_sided=True)


class WeakeningWallDetector(Detector):
    """Friction along the wall that weakens with speed."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed by the curvature of the friction at a few places along the pipe."""
        motion, pipe = inspection.once(Motion), inspection.residual.system.string[0]
        per_length = float(np.ravel(pipe.polar_moment * pipe.length)[0]) / len(_PLACES)
        bent = np.sum([_bent(motion, share) for share in _PLACES], axis=0)
        return Candidate(name, _curvature(inspection.residual) * per_length * bent[None], one_sided=True)


class StandingBitDetector(Detector):
    """A bit that dwells at standstill."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """None where the bit hardly gets there; the size is its swing per mean speed."""
        residual = inspection.residual
        mean = float(residual.speed.mean())
        speed = _inner(residual, mean + inspection.once(Motion).below(1.0)[0])
        normal = _dwelling(residual, speed, _STANDING * abs(mean))
        if normal is None:
            return None
        swing = float(np.ptp(np.quantile(speed, [0.025, 0.975]))) / (2 * abs(mean))
        return Score(normal, swing, 0.1 * swing, max(normal, 0.0) ** 2 / 2)


class BacklashDetector(Detector):
    """A torque at the gear that dwells at zero.

    How much of the top drive turns above the play is not known: shares are tried, and the p-value counts them. Nor is
    the play: how far the string turns meanwhile is not recorded.
    """

    needs_command = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """None where the torque hardly gets to zero, or the rig swings in a limit cycle.

        The torque of such a rig has turning points that look like play.
        """
        if swings_in_limit_cycle(inspection):
            return None
        residual, motion = inspection.residual, inspection.once(Motion)
        torques = [_inner(residual, motion.top_torque(above)) for above in _ABOVE_GEAR]
        tried = [_dwelling(residual, torque, _BETWEEN_FLANKS * float(torque.std())) for torque in torques]
        normals = [normal for normal in tried if normal is not None]
        if not normals:
            return None
        normal = normal_of_p_value(min(len(normals) * float(ndtr(-max(normals))), 1.0))
        return Score(normal, np.nan, np.inf, max(normal, 0.0) ** 2 / 2)


def _curvature(residual: ResidualRecord) -> float:
    """Second derivative of a torque that falls by size (10/Ω)² per speed: 200 size/Ω³."""
    return float(2 * _REFERENCE_SPEED**2 / float(residual.speed.mean()) ** 3)


def _bent(motion: Motion, share: float) -> Floats:
    """Speed at the top (rad/s) by a torque against rotation of half the square of the local speed's variation."""
    speed, moved = motion.below(share)
    return motion.residual.filtered(-moved, _steady(speed**2 / 2))


def _inner(residual: ResidualRecord, series: Floats) -> Floats:
    ends = round(_ENDS_S * residual.record.rate)
    return series[ends:-ends]


def _dwelling(residual: ResidualRecord, series: Floats, width: float) -> float | None:
    """Standard normal value of the time about zero.

    What is foretold is extrapolated from the shares of two pairs of bands beside zero, as a parabola would.
    """
    off = np.abs(series) / width
    about, beside, beyond = off < 1, (off >= 1) & (off < 3), (off >= 3) & (off < 5)
    count = int(series.size / residual.record.rate / _BLOCK_S)
    if count < _LEAST_BLOCKS or about.mean() < _LEAST_SHARE:
        return None
    # the bands lie at 2 and 4 widths and are twice as wide together
    excess = about - (4 * beside - beyond) / 6
    blocks = np.array([block.mean() for block in np.array_split(excess, count)])
    deviation = float(blocks.std(ddof=1)) / np.sqrt(count)
    if deviation == 0:
        return None
    return normal_of_p_value(float(stdtr(count - 1, -blocks.mean() / deviation)))
