"""Errors over seconds: their exponents, and where one method overtakes another."""

import math
from typing import NamedTuple

# The part of a curve that an exponent is fitted to: the last factor of so many in seconds, as `caustica study` does with passes.
END = 8


def exponent(points):
    """`s` of `error ~ seconds^-s` through the end of a curve of (seconds, error), by least squares of the logarithms."""
    end = [(math.log(x), math.log(y)) for x, y in points if END * x >= points[-1][0]]
    mean_x, mean_y = (sum(column) / len(end) for column in zip(*end))
    return -sum((x - mean_x) * (y - mean_y) for x, y in end) / sum((x - mean_x) ** 2 for x, _ in end)


def at(points, seconds):
    """The error of a curve between its points, along a power law."""
    (x0, y0), (x1, y1) = next(pair for pair in zip(points, points[1:]) if pair[0][0] <= seconds <= pair[1][0])
    return y0 * (y1 / y0) ** (math.log(seconds / x0) / math.log(x1 / x0))


class Overtaking(NamedTuple):
    """When a rival's error falls below another's, and what both are then."""

    seconds: float
    error: float
    is_measured: bool


def shared_seconds(first, second):
    """The times of either curve at which both are known."""
    begin, end = max(first[0][0], second[0][0]), min(first[-1][0], second[-1][0])
    return sorted(x for x, _ in first + second if begin <= x <= end)


def lead(first, second, seconds):
    """By how much the second curve's error is larger, as a logarithm: negative where the second is ahead."""
    return math.log(at(second, seconds) / at(first, seconds))


def overtaking(first, second):
    """Where the second curve falls below the first for good: measured, or else by the exponents of their ends.

    `None` if it is ahead wherever both are known, or never will be.
    """
    times = shared_seconds(first, second)
    leads = [lead(first, second, seconds) for seconds in times]
    if leads[-1] > 0:
        return extrapolated(first, second, times[-1], leads[-1])
    if max(leads) <= 0:
        return None
    before = max(k for k, value in enumerate(leads) if value > 0)
    share = leads[before] / (leads[before] - leads[before + 1])
    seconds = times[before] * (times[before + 1] / times[before]) ** share
    return Overtaking(seconds, at(first, seconds), True)


def extrapolated(first, second, seconds, now):
    """From a lead `now`, by the difference of the exponents."""
    gain = exponent(second) - exponent(first)
    if gain <= 0:
        return None
    longer = math.exp(now / gain)
    return Overtaking(seconds * longer, at(first, seconds) * longer ** -exponent(first), False)


def is_ahead(first, second):
    """Whether the second curve's error is the smaller one at the last time at which both are known."""
    return lead(first, second, shared_seconds(first, second)[-1]) < 0
