"""Estimates with the confidence intervals of the command line, which computes the same ones in Rust."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

# The quantile of the standard normal distribution for a two-sided confidence of 95 %.
Z_95 = 1.959963984540054

RESAMPLES = 1000

Statistics = Callable[[Sequence[np.ndarray]], np.ndarray]
"""What is computed of groups of samples. Each group is an array, of which the last axis has the values."""


@dataclass(frozen=True)
class Estimate:
    """A value, and the interval in which the truth lies with 95 % confidence.

    Attributes:
        value: The value; NaN without data.
        low: The lower end.
        high: The upper end.
    """

    value: float
    low: float
    high: float

    def __format__(self, spec: str) -> str:
        spec = spec or ".4g"
        return f"{self.value:{spec}} ({self.low:{spec}} to {self.high:{spec}})"

    def __str__(self) -> str:
        return format(self)


UNKNOWN = Estimate(math.nan, -math.inf, math.inf)


def share(successes: int, trials: int) -> Estimate:
    """The share of successes, with Wilson's score interval (1927)."""
    if trials == 0:
        return Estimate(math.nan, 0.0, 1.0)
    p, z2 = successes / trials, Z_95 * Z_95
    centre = p + z2 / (2.0 * trials)
    spread = Z_95 * math.sqrt(p * (1.0 - p) / trials + z2 / (4.0 * trials * trials))
    scale = 1.0 + z2 / trials
    return Estimate(p, max((centre - spread) / scale, 0.0), min((centre + spread) / scale, 1.0))


def mean(values: Sequence[float] | np.ndarray) -> Estimate:
    """The mean, with Student's interval: an infinite one for a single value."""
    numbers = np.asarray(values, float)
    if not numbers.size:
        return UNKNOWN
    value = float(numbers.mean())
    if numbers.size == 1:
        return Estimate(value, -math.inf, math.inf)
    margin = _student_quantile_95(numbers.size - 1) * float(numbers.std(ddof=1)) / math.sqrt(numbers.size)
    return Estimate(value, value - margin, value + margin)


def bootstrap(groups: Sequence[Sequence[float] | np.ndarray], statistics: Statistics) -> list[Estimate]:
    """Statistics of values in groups, each with the interval between the 2.5 % and 97.5 % quantiles of 1000 samples.

    The values of each group are drawn with replacement (stratified bootstrap, Efron 1979). The random numbers are always the same; they are
    not those of the command line. If no group has two values, the intervals are infinite.

    Args:
        statistics: Returns an array of the statistics; from groups with an axis before that of the values it returns one before its own.
    """
    arrays = [np.asarray(group, float) for group in groups]
    values = np.atleast_1d(statistics(arrays))
    if all(len(group) < 2 for group in arrays):
        return [Estimate(float(value), -math.inf, math.inf) for value in values]
    random = np.random.default_rng(0)
    drawn = [group[random.integers(len(group), size=(RESAMPLES, len(group)))] for group in arrays]
    low, high = np.quantile(statistics(drawn), (0.025, 0.975), axis=0, method="inverted_cdf")
    return [Estimate(float(value), float(least), float(most)) for value, least, most in zip(values, low, high)]


def mean_of_samples(groups: Sequence[np.ndarray]) -> np.ndarray:
    """The mean of a single group, for :func:`bootstrap`."""
    means: np.ndarray = np.mean(groups[0], axis=-1, keepdims=True)
    return means


def _student_quantile_95(degrees: float) -> float:
    """Student's two-sided quantile for 95 %: exact for 1 and 2 degrees of freedom, else by Fisher's expansion (Abramowitz and Stegun, 26.7.5)."""
    if degrees < 1.5:
        return 12.706204736
    if degrees < 2.5:
        return 4.30265273
    z = Z_95
    return (
        z
        + (z**3 + z) / (4.0 * degrees)
        + (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / (96.0 * degrees**2)
        + (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / (384.0 * degrees**3)
        + (79.0 * z**9 + 776.0 * z**7 + 1482.0 * z**5 - 1920.0 * z**3 - 945.0 * z) / (92160.0 * degrees**4)
    )
