"""The predictive gain of an extended model: difference of log scores on data that it was not fitted to."""

from dataclasses import dataclass

import numpy as np

from drillid.statistics import ONE_SIDED


@dataclass(frozen=True)
class PredictiveGain:
    """Difference of the log scores of held-out data, per window, with its 90 % interval.

    The question is one-sided, whether there is a gain: so its lower end holds in 95 % of sets. A log-likelihood ratio
    has twice its mean as variance, so that its root is normal with an error that does not depend on it
    (Barndorff-Nielsen 1986, Biometrika 73, 307–322): the interval is symmetric in the root where there is a gain.
    """

    value: float
    error: float
    """Standard error."""
    windows: int
    """Windows that were held out; 0 where every other frequency of one window was."""

    @property
    def low(self) -> float:
        """Lower end."""
        plain, root = self.value - ONE_SIDED * self.error, 1 - self._reach
        return plain if self.value <= 0 else max(plain, self.value * root * abs(root))

    @property
    def high(self) -> float:
        """Upper end."""
        plain, root = self.value + ONE_SIDED * self.error, 1 + min(self._reach, 1.0)
        return max(plain, self.value * root**2)

    @property
    def _reach(self) -> float:
        """Of the interval, in the root of a gain, per that root."""
        return ONE_SIDED * self.error / (2 * self.value) if self.value > 0 else np.inf

    def joined(self, other: "PredictiveGain") -> "PredictiveGain":
        """With the gain of the same cause on other data of the same windows."""
        return PredictiveGain(self.value + other.value, float(np.hypot(self.error, other.error)), self.windows)


NO_PREDICTIVE_GAIN = PredictiveGain(0.0, 0.0, 0)
