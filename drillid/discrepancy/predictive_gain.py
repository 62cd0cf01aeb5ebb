"""The predictive gain of an extended model: its log score on held-out data less that of the base model."""

from dataclasses import dataclass

import numpy as np

from drillid.statistics import ONE_SIDED


@dataclass(frozen=True)
class PredictiveGain:
    """Difference of the log scores of held-out data, per window, with its 90 % interval.

    The test is one-sided, whether there is a gain: the lower end has a confidence of 95 %. The variance of a
    log-likelihood ratio is twice its mean, so that its square root is normal with constant variance
    (Barndorff-Nielsen 1986, Biometrika 73, 307–322): the interval of a positive gain is symmetric in the root.
    """

    value: float
    error: float
    """Standard error."""
    windows: int
    """Number of held-out windows; 0 where every other frequency of a single window was held out."""

    @property
    def low(self) -> float:
        """Lower end."""
        plain, root = self.value - ONE_SIDED * self.error, 1 - self._half_width
        return plain if self.value <= 0 else max(plain, self.value * root * abs(root))

    @property
    def high(self) -> float:
        """Upper end."""
        plain, root = self.value + ONE_SIDED * self.error, 1 + min(self._half_width, 1.0)
        return max(plain, self.value * root**2)

    @property
    def _half_width(self) -> float:
        """Half-width of the interval in the root of the gain, relative to that root."""
        return ONE_SIDED * self.error / (2 * self.value) if self.value > 0 else np.inf

    def joined(self, other: "PredictiveGain") -> "PredictiveGain":
        """Sum with the gain of the same cause on other data of the same windows."""
        return PredictiveGain(self.value + other.value, float(np.hypot(self.error, other.error)), self.windows)


NO_PREDICTIVE_GAIN = PredictiveGain(0.0, 0.0, 0)
