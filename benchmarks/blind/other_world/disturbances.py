"""Random torques of the rock, and set points and weights that wander."""

import numpy as np
from scipy.signal import lfilter

from benchmarks.blind.other_world.rig import Rock
from drillid.arrays import Floats

_LEVEL_MEMORY = 100.0
"""s, correlation time of the noise's level."""
_WANDER_MEMORY = 150.0
"""s, of weight and set point."""
_BURST_S, _BURST_FACTOR = 4.0, 2.5
"""Mean length of an episode of stronger noise, and its level."""
_LINE_WIDTH = 0.03
"""Hz, half width of a narrow band."""


def first_order(generator: np.random.Generator, samples: int, step: float, memory: float) -> Floats:
    """Stationary Gaussian noise of unit variance with an exponential correlation, (samples,).

    Parameters
    ----------
    step, memory : s, interval of the samples and correlation time
    """
    kept = float(np.exp(-step / memory))
    draws = generator.standard_normal(samples)
    draws[1:] *= np.sqrt(1 - kept**2)
    return np.asarray(lfilter([1.0], [1.0, -kept], draws), dtype=float)


def rock_torque(generator: np.random.Generator, rock: Rock, steps: int, step: float) -> Floats:
    """Torque of the rock on the bit, (steps,) N m; the mean power of its noise is that of the rock."""
    memory = 1 / (2 * np.pi * rock.bandwidth)
    noise = first_order(generator, steps, step, memory)
    slow = rock.swing * first_order(generator, steps, step, _LEVEL_MEMORY)
    level = np.exp(slow - rock.swing**2)
    if np.isfinite(rock.tail):
        # a level that varies as fast as the noise makes its distribution Student's t
        block = max(1, round(2 * memory / step))
        chi = generator.chisquare(rock.tail, -(-steps // block)) / (rock.tail - 2)
        level = level * np.repeat(1 / np.sqrt(chi), block)[:steps]
    if rock.bursts > 0:
        level = level * _bursts(generator, rock.bursts, steps, step)
    total = rock.noise * noise * level
    for frequency, size in rock.lines:
        total = total + size * _narrow(generator, frequency, steps, step)
    return rock.mean * (1 + rock.wander * first_order(generator, steps, step, _WANDER_MEMORY)) + total


def set_speed(generator: np.random.Generator, speed: float, wander: float, samples: int, step: float) -> Floats:
    """Set point that wanders, (samples,) rad/s."""
    return speed * (1 + wander * first_order(generator, samples, step, _WANDER_MEMORY))


def wander_density(frequency: Floats) -> Floats:
    """One-sided power density of weights and set points that wander, relative to their variance, 1/Hz."""
    return np.asarray(4 * _WANDER_MEMORY / (1 + (2 * np.pi * frequency * _WANDER_MEMORY) ** 2), dtype=float)


def burst_power(rate: float) -> float:
    """Mean power of a level with bursts at a rate in 1/s, relative to that between them."""
    return 1 + (_BURST_FACTOR**2 - 1) * _burst_share(rate)


def _burst_share(rate: float) -> float:
    return rate * _BURST_S / (1 + rate * _BURST_S)


def _bursts(generator: np.random.Generator, rate: float, steps: int, step: float) -> Floats:
    """Level of noise with episodes, of unit mean power, (steps,)."""
    level, now, strong = np.ones(steps), 0.0, bool(generator.random() < _burst_share(rate))
    while now < steps * step:
        lasts = float(generator.exponential(_BURST_S if strong else 1 / rate))
        if strong:
            level[round(now / step) : round((now + lasts) / step)] = _BURST_FACTOR
        now, strong = now + lasts, not strong
    return level / np.sqrt(burst_power(rate))


def _narrow(generator: np.random.Generator, frequency: float, steps: int, step: float) -> Floats:
    """Noise of unit power in a narrow band about a frequency in Hz."""
    memory = 1 / (2 * np.pi * _LINE_WIDTH)
    phase = 2 * np.pi * frequency * step * np.arange(steps)
    sine, cosine = (first_order(generator, steps, step, memory) for _ in range(2))
    return np.asarray(sine * np.sin(phase) + cosine * np.cos(phase), dtype=float)


def rock_density(rock: Rock, frequency: Floats) -> Floats:
    """One-sided power density of the rock's noise in the mean over time, (N m)²/Hz."""
    ratio = frequency / rock.bandwidth
    density = rock.noise**2 * 2 / (np.pi * rock.bandwidth) / (1 + ratio**2)
    for centre, size in rock.lines:
        away = (frequency - centre) / _LINE_WIDTH
        density = density + size**2 / (np.pi * _LINE_WIDTH) / (1 + away**2)
    return np.asarray(density, dtype=float)
