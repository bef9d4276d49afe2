"""A model from its devices: mean and spread of each parameter, which are the next device's prior, and the devices that do not
belong to it.

A device's value is x_d ~ N(mean, spread^2 + sigma_d^2). The spread is Paule and Mandel's (J. Res. NBS 87, 1982): the one with which the
devices scatter as much as they should. Outliers would widen it, so median and median absolute deviation find these first."""

import dataclasses

import numpy as np
from scipy.stats import binom, norm, t

LEAST_DEVICES = 5     # for a median absolute deviation to mean anything
LEVEL = 1e-2          # probability that one of a fleet's devices is named although all belong, for each kind of finding
NORMAL_MAD = 1.4826   # standard deviations of a normal distribution in one median absolute deviation
LEAST_FIT_RATIO = 1.5 # of chi2/dof to the model's median: a smaller excess is noise of the motion, whatever its significance


@dataclasses.dataclass
class Spread:
    mean: float
    sigma: float    # of the mean
    spread: float   # between devices
    devices: int    # that it is made from


def paule_mandel(x, variance):
    """Mean, its variance and the spread's square."""
    def scatter(tau2):
        w = 1 / (variance + tau2)
        mean = np.sum(w * x) / np.sum(w)
        return np.sum(w * (x - mean) ** 2) - (len(x) - 1)

    high = 0.0
    if len(x) > 1 and scatter(0.0) > 0:
        low, high = 0.0, max(float(np.var(x)) * len(x), 1e-300)
        for _ in range(60):  # scatter falls with tau2: bisection
            middle = (low + high) / 2
            low, high = (middle, high) if scatter(middle) > 0 else (low, middle)
    w = 1 / (variance + high)
    return np.sum(w * x) / np.sum(w), 1 / np.sum(w), high


def distances(x, sigma):
    """Of each device from the others' middle, in sigmas, whatever a few of them do."""
    middle = np.median(x)
    scatter = NORMAL_MAD * np.median(np.abs(x - middle))
    tau2 = max(0.0, scatter**2 - np.median(sigma**2))
    return (x - middle) / np.sqrt(np.maximum(tau2 + sigma**2, 1e-300))


def limit_of(tests):
    """Sigmas beyond which one of so many normal numbers lies with probability LEVEL: tests of a whole fleet, not of a model."""
    return norm.isf(LEVEL / (2 * tests))


def in_sigmas(distance, dof):
    """A distance whose spread was estimated from dof + 1 devices, as that of a normal number as rare (Student's t has more far out)."""
    return np.sign(distance) * norm.isf(np.maximum(t.sf(np.abs(distance), dof), 1e-300))


def from_the_others(x, sigma, core):
    """Of each device from the mean of the core's others, in sigmas: a device that is tested takes no part in what it is tested by."""
    far = np.empty(len(x))
    for d in range(len(x)):
        others = core.copy()
        others[d] = False
        mean, variance, tau2 = paule_mandel(x[others], sigma[others] ** 2)
        far[d] = in_sigmas((x[d] - mean) / np.sqrt(tau2 + sigma[d] ** 2 + variance), np.sum(others) - 1)
    return far


def spread_of(x, sigma, told, limit):
    """(Spread, distance of each device in sigmas; nan: not judged). `told`: devices whose logs tell this parameter."""
    far = np.full(len(x), np.nan)
    if not told.any():
        return None, far
    belongs = told.copy()
    if told.sum() >= LEAST_DEVICES:
        own, own_sigma = x[told], sigma[told]
        core = np.abs(in_sigmas(distances(own, own_sigma), len(own) - 1)) <= limit
        far[told] = from_the_others(own, own_sigma, core) if core.sum() >= 3 else np.nan
        belongs &= ~(np.abs(far) > limit)
    mean, variance, tau2 = paule_mandel(x[belongs], sigma[belongs] ** 2)
    return Spread(float(mean), float(np.sqrt(variance)), float(np.sqrt(tau2)), int(belongs.sum())), far


def silent(logs, without, tests):
    """Indices of devices of which more logs gave nothing than those of the others explain: binomial, at the others' rate.
    `logs`, `without`: per device of a model, all logs and those without evidence."""
    logs, without = np.asarray(logs), np.asarray(without)
    if len(logs) < LEAST_DEVICES:
        return []
    rate = (without.sum() - without + 0.5) / (logs.sum() - logs + 1)  # Jeffreys' prior: never zero
    # The others' rate is that of typical devices: its median, where some of them are as bad.
    typical = (np.median(without / logs) * logs.sum() + 0.5) / (logs.sum() + 1)
    chance = binom.sf(without - 1, logs, np.minimum(rate, max(typical, 1 / logs.sum())))
    return list(np.flatnonzero(chance < LEVEL / tests))


def badly_fitting(ratios, tests):
    """Indices of devices whose chi2/dof stands out, with their ratio to the middle. `ratios`: chi2/dof per device of a model;
    `tests`: devices of the fleet."""
    ratios = np.asarray(ratios, float)
    if len(ratios) < LEAST_DEVICES or not (ratios > 0).all():
        return []
    logs = np.log(ratios)
    scatter = max(NORMAL_MAD * np.median(np.abs(logs - np.median(logs))), 1e-3)
    excess = np.exp(logs - np.median(logs))
    z = (logs - np.median(logs)) / scatter
    return [(i, float(excess[i])) for i in np.flatnonzero((z > limit_of(tests)) & (excess > LEAST_FIT_RATIO))]
