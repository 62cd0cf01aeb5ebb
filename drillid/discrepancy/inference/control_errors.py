"""Errors of the control's response: those of each window, and those common to all."""

import numpy as np
import pandas as pd

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.smooth import smooth_functions
from drillid.fits.datasheet import COMMAND_BANDS

_FLOOR = 3e-3
"""Relative error that all windows have in common in each of COMMAND_BANDS bands, from the sampling of the control and
from interpolated rows."""
_LINES, _CLEAR, _ZERO = 31, 0.02, 10.0
"""Lines over which the noise of the control's response is smoothed, since a weight must not depend on its own
denominator; largest relative variance at which they are used; and the ratio to the smoothed variance from which a line
counts as lying at a zero of the mobility. The mean of a ratio falls short by exp(-1/v) of it where the denominator's
relative variance is v: at most by 0.7 %."""
_LEAST = 1e-12
"""Relative variance used in place of zero, as in a computed response."""
_SMOOTH, _ROUGH = 24, 2.0
"""Number of smooth functions over the band that represent any control's response, and variance about them, relative to
that of the noise, above which it counts: a median over _LINES errs by a third."""


def control_errors(evidence: Evidence, stated: Complex, used: Booleans) -> tuple[Floats, Floats]:
    """Variances (W, F) of the control's response, of errors of each window and of those common to all.

    The former is infinite where a line is not used.

    Parameters
    ----------
    evidence : with a logged command
    stated : (F,) response of the control by the data sheet
    used : (W, F) lines of the mobilities that are used
    """
    assert evidence.control is not None
    size = np.abs(stated) ** 2
    relative = np.where(used, evidence.control_variance / size, np.nan)
    noise = _smooth(relative)
    # a line at a zero of the mobility carries no information, whatever its neighbours do
    good = (relative <= noise * _ZERO) & (noise < _CLEAR)
    lines = np.maximum(np.count_nonzero(used, axis=1) / COMMAND_BANDS, 1.0)[:, None]
    common = lines * _FLOOR**2 + _folded(evidence.frequency, np.where(good, evidence.control / stated, np.nan), noise)
    if evidence.control_rounding is not None:
        common = common + _smooth(np.where(used, evidence.control_rounding / size, np.nan))
    return np.where(good, noise * size, np.inf), np.where(good, common * size, 0.0)


def _folded(frequency: Floats, ratio: Complex, noise: Floats) -> Floats:
    """Relative variance (F,) of the windows' mean response about a smooth curve, beyond that of their noise.

    The response of a control is smooth. Readings at an interval longer than that of the rows alias other parts of the
    sweep into a line, alike in all windows, and the more so the longer the interval is.
    """
    windows = np.count_nonzero(np.isfinite(ratio), axis=0)
    seen = windows > 0
    if np.count_nonzero(seen) < _LINES:
        return np.zeros(frequency.size)
    mean = np.nansum(ratio[:, seen], axis=0) / windows[seen]
    of_noise = np.nanmean(np.where(np.isfinite(ratio), noise, np.nan)[:, seen], axis=0) / windows[seen]
    of_noise = np.maximum(of_noise, _LEAST)
    basis = smooth_functions(frequency, _SMOOTH)[:, seen] / np.sqrt(of_noise)
    coefficients = np.linalg.lstsq(basis.T, mean / np.sqrt(of_noise))[0]
    power = np.abs(mean - (coefficients @ basis) * np.sqrt(of_noise)) ** 2
    # the square of a complex normal variable is exponential
    rough, found = _smooth(power[None])[0] / np.log(2.0), np.zeros(frequency.size)
    found[seen] = np.where(rough > _ROUGH * of_noise, rough - of_noise, 0.0)
    return found


def _smooth(relative: Floats) -> Floats:
    """Running median of relative variances (W, F) over lines."""
    lines = pd.DataFrame(relative.T)
    return lines.rolling(_LINES, center=True, min_periods=1).median().to_numpy().T
