"""Steps of the mean torque at the bit: taken out of a record before its signs are read.

The bit comes into another rock, or its damping changes, and the torque that it takes on the mean changes at once. The
string answers with a transient far above the noise at low frequencies. No cause is named after it, as rock is no
fault of the model; left in, it would count as noise and hide what changes with it.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from drillid.discrepancy.signs_record import Remainder

Floats = NDArray[np.float64]

_LEAST = 5.5
"""Standard deviations from which a step is taken out: noise reaches them once in a thousand windows."""
_MOST = 4
"""Steps of a window; what steps more often is no change of rock."""


def without_steps(remainder: Remainder) -> Remainder:
    """The remainder less the answers of the speed to steps of the torque at the bit."""
    for _ in range(_MOST):
        answer = _largest_step(remainder)
        if answer is None:
            break
        remainder = Remainder(remainder.record, remainder.taken + answer)
    return remainder


def _largest_step(remainder: Remainder) -> Floats | None:
    """Speed (samples,) by the step that stands out most, rad/s; None where none does.

    All times are tried at once by a matched filter (Turin 1960, IRE Transactions on Information Theory 6, 311–329).
    """
    rate, s = remainder.record.rate, remainder.s
    answer = -remainder.moved_from_bit * rate / s
    weighted = np.where(remainder.inside, np.conj(answer) / np.maximum(remainder.noise, np.finfo(float).tiny), 0.0)
    matched = irfft(weighted * rfft(remainder.left * remainder.taper), remainder.samples) * remainder.samples
    deviation = float(np.sqrt(2 * np.sum((weighted * answer).real)))
    place = int(np.argmax(np.abs(matched)))
    if not abs(matched[place]) > _LEAST * deviation:
        return None
    step = irfft(answer * np.exp(-s * place / rate), remainder.samples)
    seen = remainder.whitened(step)
    return np.asarray(step * (seen @ remainder.error) / (seen @ seen), dtype=float)
