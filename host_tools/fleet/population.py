"""A model from its devices: mean and spread of each parameter, which are the next device's prior, and the devices that do not
belong to it.

A device's value is x_d ~ N(mean, spread^2 + sigma_d^2). The spread is Paule and Mandel's (J. Res. NBS 87, 1982): the one with which the
devices scatter as much as they should. Outliers would widen it, so median and median absolute deviation find these first."""

import dataclasses

import numpy as np
from scipy.stats import norm

LEAST_DEVICES = 5     # for a median absolute deviation to mean anything
LEVEL = 1e-2          # probability that one of a model's devices is named although all belong
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
        for _ in range(200):  # scatter falls with tau2: bisection
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
    return norm.isf(LEVEL / (2 * tests))


def spread_of(x, sigma, told, limit):
    """(Spread, distance of each device in sigmas; nan: not judged). `told`: devices whose logs tell this parameter."""
    far = np.full(len(x), np.nan)
    if not told.any():
        return None, far
    belongs = told.copy()
    if told.sum() >= LEAST_DEVICES:
        far[told] = distances(x[told], sigma[told])
        belongs &= np.abs(far) <= limit
    mean, variance, tau2 = paule_mandel(x[belongs], sigma[belongs] ** 2)
    if told.sum() >= LEAST_DEVICES:
        far[told] = (x[told] - mean) / np.sqrt(tau2 + sigma[told] ** 2 + variance)
    return Spread(float(mean), float(np.sqrt(variance)), float(np.sqrt(tau2)), int(belongs.sum())), far


def badly_fitting(ratios):
    """Indices of devices whose chi2/dof stands out, with their ratio to the middle. `ratios`: chi2/dof per device."""
    ratios = np.asarray(ratios, float)
    if len(ratios) < LEAST_DEVICES or not (ratios > 0).all():
        return []
    logs = np.log(ratios)
    scatter = max(NORMAL_MAD * np.median(np.abs(logs - np.median(logs))), 1e-3)
    excess = np.exp(logs - np.median(logs))
    z = (logs - np.median(logs)) / scatter
    return [(i, float(excess[i])) for i in np.flatnonzero((z > limit_of(len(ratios))) & (excess > LEAST_FIT_RATIO))]
