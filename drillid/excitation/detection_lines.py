"""Distortion of even and odd order, and aliasing, from the response to a periodic excitation."""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.errors import EstimationError

_EXCITED = 1e-4
"""Power relative to the strongest line above which a line counts as excited: far below the weakest of a sweep, and
above the last digit of a record."""


@dataclass(frozen=True, eq=False)
class Distortion:
    """Levels of speed per band, (bands,): root mean square of the lines of one kind, rad/s per line; NaN without any.

    A level of distortion includes the noise, so it is significant only above the noise level.
    """

    edges: Floats
    """(bands + 1,) Hz."""
    response: Floats
    """Level of the excited lines."""
    even: Floats
    """Level of even lines that are not excited: distortion of even order."""
    odd: Floats
    """Level of odd lines that are not excited: distortion of odd order."""
    noise: Floats
    """Level of the noise on all lines, from the spread between periods."""


def distortion(speed: Floats, sweep: Floats, rate: float, period: float, edges: Floats) -> Distortion:
    """Levels of even and odd distortion from whole periods of speed and of an excitation that omits lines.

    Parameters
    ----------
    speed, sweep : (samples,) rad/s and N m, synchronous and without transient
    rate : Hz
    period : s
    edges : (bands + 1,) Hz

    Raises
    ------
    EstimationError
        If fewer than two periods are given.
    """
    samples = round(period * rate)
    periods = speed.size // samples
    if periods < 2:
        raise EstimationError("distortion", f"{periods} whole periods are too few", "Record two periods or more")
    # the mean speed is no distortion
    lines = np.fft.rfft(speed[: periods * samples].reshape(periods, samples))[:, 1:] * (np.sqrt(2) / samples)
    power = np.abs(np.fft.rfft(sweep[:samples])[1:]) ** 2
    number = np.arange(1, power.size + 1)
    excited = power > _EXCITED * power.max()
    mean = np.abs(lines.mean(axis=0)) ** 2
    spread = np.sum(np.abs(lines - lines.mean(axis=0)) ** 2, axis=0) / (periods - 1)
    kinds = (excited, ~excited & (number % 2 == 0), ~excited & (number % 2 == 1), np.full(number.size, True))
    values = (mean, mean, mean, spread / periods)
    frequency = number / period
    return Distortion(
        edges, *(_levels(frequency, value, kind, edges) for kind, value in zip(kinds, values, strict=True))
    )


def _levels(frequency: Floats, power: Floats, kind: Booleans, edges: Floats) -> Floats:
    total = np.histogram(frequency[kind], edges, weights=power[kind])[0]
    count = np.histogram(frequency[kind], edges)[0]
    levels = np.full(count.size, np.nan)
    np.sqrt(np.divide(total, count, where=count > 0, out=levels), where=count > 0, out=levels)
    return levels


def sweep_orders(
    speed: Floats, phase: Floats, orders: tuple[int, ...], rate: float, sections: int = 8
) -> tuple[Floats, Floats, Floats]:
    """Components of the speed at multiples of a sweep's frequency: distortion and its aliases.

    Each section of the sweep is fitted by least squares with sines and cosines of n φ(t), whose coefficients are
    linear over the section, and a straight line. Where n times the frequency exceeds half the sample rate, the
    component is an alias.

    Parameters
    ----------
    speed : (samples,) rad/s, one sweep
    phase : (samples,) φ, rad
    orders : multiples n, fundamental included
    rate : Hz

    Returns
    -------
    frequency : (sections,) Hz, mean frequency of the sweep
    amplitude : (orders, sections) rad/s, in the middle of the section
    error : (orders, sections) rad/s, standard error of each from the residuals of the fit, assumed white
    """
    pieces = np.array_split(np.arange(speed.size), sections)
    frequency = np.array(
        [(phase[piece[-1]] - phase[piece[0]]) / (2 * np.pi * (piece.size - 1)) * rate for piece in pieces]
    )
    amplitude, error = np.empty((2, len(orders), sections))
    for number, piece in enumerate(pieces):
        position = np.linspace(-1, 1, piece.size)
        turns = np.outer(phase[piece], orders)
        waves = np.stack([np.cos(turns), np.sin(turns)], axis=-1).reshape(piece.size, -1)
        columns = np.column_stack([waves, waves * position[:, None], np.ones(piece.size), position])
        coefficients, _, rank, _ = np.linalg.lstsq(columns, speed[piece], rcond=None)
        if rank < columns.shape[1]:
            raise EstimationError("sweep orders", "two orders cannot be distinguished", "Use fewer orders or sections")
        residual = speed[piece] - columns @ coefficients
        variance = np.sum(residual**2) / (piece.size - rank) * np.diag(np.linalg.inv(columns.T @ columns))
        size = 2 * len(orders)
        amplitude[:, number] = np.hypot(*coefficients[:size].reshape(-1, 2).T)
        error[:, number] = np.sqrt(variance[:size].reshape(-1, 2).mean(axis=1))
    return frequency, amplitude, error
