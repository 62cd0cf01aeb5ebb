"""Detections of play in the gear of the top drive, by the torque at the gear.

The speed may be measured on either side of the gear. Above it, at the motor, the torque at the gear follows from the
record and dwells at zero while the teeth are apart. Below it, at the quill, the record gives the torque that a rigid
gear would pass on and so how the motor turns against the quill once the teeth part. What the gear withholds meanwhile,
and returns when they meet, is sought in the speed, which responds to it as to the sweep.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.fft import irfft, rfft
from scipy.ndimage import uniform_filter1d
from scipy.special import ndtr

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.motion import Motion, dwelling, inner, low_pass
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value, score, whitened
from drillid.discrepancy.detectors.tone import swings_in_limit_cycle
from drillid.physics.limits import withheld_by_play

_BETWEEN_FLANKS = 0.15
"""Torque, as a share of its standard deviation, below which a gear may be between its flanks."""
_ABOVE_GEAR = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Shares of the top drive's inertia that may lie above the play, as the motor and its gear do."""
_LOW_PASS = (0.6, 0.9)
"""Roll-off of the low pass on the torque of a rigid gear, as shares of the model's highest frequency."""
_PLAYS = (0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64)
"""rad, tried where the speed is measured below the gear."""
_ABOVE_PLAY = (0.3, 0.45, 0.6, 0.75, 0.9)
"""Shares of the inertia above the gear that are tried with each of them."""
_FEW_PLAYS, _FEW_ABOVE_PLAY, _MEANS = (0.01, 0.04, 0.16), (0.45, 0.75), (0.5, 1.5, 2.5)
"""Plays, shares and mean torques, in standard deviations of the torque, tried where no command gives the mean."""
_DRAWS, _STEP, _SMOOTH_HZ = 2, 0.05, 0.5
"""Disturbances that give the linear part, their size as a share of the torque's standard deviation, and the band, Hz,
over which it is averaged."""


class BacklashDetector(Detector):
    """Play of the gear, where the torque at it changes sign.

    The share of the inertia above the play is unknown, and without a logged command the mean torque: several are tried,
    with a correction for the search. The size of the play is not determined: above the gear the rotation of the string
    meanwhile is not recorded, and below it several pairs of play and share explain the record nearly equally well.
    """

    # the torque of a rigid gear follows from the acceleration, which steps of the speed spoil
    excluded_by = ("quantisation",)

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """The clearer of the scores by what is withheld and by the time at zero torque, corrected for the choice.

        None where there is neither, or the rig is in a limit cycle, as turning points of its torque look like play.
        """
        if swings_in_limit_cycle(inspection):
            return None
        scores = [each for each in (_withheld_score(name, inspection), _dwelling_score(inspection)) if each]
        if len(scores) < 2:
            return scores[0] if scores else None
        best = max(scores, key=lambda each: each.normal)
        normal = normal_of_p_value(min(2 * float(ndtr(-best.normal)), 1.0))
        return replace(best, normal=normal, log_ratio=max(normal, 0.0) ** 2 / 2)


class Gear:
    """What a gear with play would withhold from a quill whose speed is recorded."""

    def __init__(self, motion: Motion) -> None:
        self._motion, residual = motion, motion.residual
        self.residual = residual
        self.inertia = float(np.ravel(residual.system.top_drive.inertia)[0])
        low, high = _LOW_PASS
        self._low_pass = low_pass(residual.frequency, (low * residual.highest, high * residual.highest))

    def responses(self) -> Floats:
        """Speed (settings, samples) by which plays change the record, less its linear part, rad/s; zero where the
        torque does not change its sign.
        """
        if self.residual.record.has_command:
            mean = float(self.residual.command.mean())
            return np.concatenate([self._responses(_PLAYS, self._torque(share) + mean, share) for share in _ABOVE_PLAY])
        torques = {share: self._torque(share) for share in _FEW_ABOVE_PLAY}
        return np.concatenate(
            [
                self._responses(_FEW_PLAYS, torque + mean * float(torque.std()), share)
                for share, torque in torques.items()
                for mean in _MEANS
            ]
        )

    def _torque(self, share: float) -> Floats:
        """Torque (samples,) through a rigid gear about its mean, N m, with a share of the top drive's inertia above."""
        lines = (self._motion.drive_torque - share * self._motion.inertial_torque) * self._low_pass
        # the ends of a window do not meet, and the torque computed there may swing through zero
        return np.asarray(self.residual.taper * irfft(lines, self.residual.samples), dtype=float)

    def _responses(self, plays: Sequence[float], torque: Floats, share: float) -> Floats:
        """Speed (plays, samples) by which plays change the record where a rigid gear passes on a torque."""
        if torque.min() >= 0 or torque.max() <= 0:
            return np.zeros((len(plays), self.residual.samples))
        draws = np.random.default_rng(0).standard_normal((_DRAWS, torque.size))
        disturbances = _STEP * torque.std() * draws
        spectra, torque_lines = rfft(disturbances), rfft(torque - torque.mean())

        def response(half_play: float) -> Floats:
            withheld = self._withheld(torque, share, half_play)
            changes = [
                self._withheld(torque + each, share, half_play) - self._withheld(torque - each, share, half_play)
                for each in disturbances
            ]
            transfer = self._linear_part(np.stack(changes) / 2, spectra)
            lines = rfft(withheld - withheld.mean()) - transfer * torque_lines
            return np.asarray(irfft(lines * self.residual.top_mobility, self.residual.samples), dtype=float)

        return np.stack([response(play / 2) for play in plays])

    def _linear_part(self, changes: Floats, spectra: Complex) -> Complex:
        """Mean transfer function (line,) from the torque to what is withheld: its mean derivative.

        As for the limits of a drive, what is left is uncorrelated with Gaussian noise in the torque.

        Parameters
        ----------
        changes : (draws, samples) of what is withheld, by disturbances of the torque
        spectra : (draws, line) of these disturbances
        """
        product, power = np.sum(rfft(changes) * spectra.conj(), axis=0), np.sum(np.abs(spectra) ** 2, axis=0)
        width = max(3, round(_SMOOTH_HZ / self.residual.frequency[1]))
        real, imaginary, total = (uniform_filter1d(part, width) for part in (product.real, product.imag, power))
        return np.asarray((real + 1j * imaginary) / total, dtype=complex)

    def _withheld(self, torque: Floats, share: float, half_play: float) -> Floats:
        return withheld_by_play(torque, 1 / self.residual.record.rate, share * self.inertia, half_play)


def _withheld_score(name: str, inspection: Inspection) -> Score | None:
    """Score of the speed response to what plays would withhold; None where the torque does not change its sign."""
    residual, columns = inspection.residual, Gear(inspection.cached(Motion)).responses()
    if not columns.any():
        return None
    unknown = np.full(len(columns), np.nan)
    candidate = Candidate(name, columns, unknown, one_sided=True, brief=True)
    return score(whitened(candidate, residual), residual.error, residual)


def _dwelling_score(inspection: Inspection) -> Score | None:
    """Score of the time at zero torque, by the best of several shares; None where there is hardly any, or no command
    that shows where zero is.
    """
    if not inspection.residual.record.has_command:
        return None
    residual, motion = inspection.residual, inspection.cached(Motion)
    torques = [inner(residual, motion.top_torque(above)) for above in _ABOVE_GEAR]
    tried = [dwelling(residual, torque, _BETWEEN_FLANKS * float(torque.std())) for torque in torques if torque.size]
    normals = [normal for normal in tried if normal is not None]
    if not normals:
        return None
    normal = normal_of_p_value(min(len(normals) * float(ndtr(-max(normals))), 1.0))
    return Score(normal, np.nan, np.inf, max(normal, 0.0) ** 2 / 2)
