"""One device from many logs, and whether it was one and the same all the time.

All logs of a device are one least-squares problem R x = z (evidence.py), the prior once. A device that fell or was repaired has
another value of one block (a camera's rotation, say) from some log on: a step, columns that only the later logs have. Of all
steps, block by block and between any two logs, the one that lowers the cost most is taken if that is beyond chance, then the next:
forward selection, as the core's own test for outdated segments divides by the noise that the logs show among themselves."""

import dataclasses
import functools
import math

import numpy as np
from scipy.stats import chi2

import evidence as ev

LEVEL = 1e-2        # probability that a fleet without any change has one named
LEAST_TOLD = 1.0    # singular value against the prior: a direction that the logs know less well than the prior shows no step
MOST_STEPS = 8      # of one device; more is a device that never holds still


@functools.cache
def block_of(name):
    """Parameters that change together when something is bent, moved or exchanged."""
    sensor, _, rest = name.partition(".")
    if rest.startswith(("r_", "p_")):
        return f"{sensor}.{rest[:4]}"
    if sensor.startswith("cam"):
        return f"{sensor}.focal length and centre" if rest in ("fx", "fy", "cx", "cy") else f"{sensor}.distortion"
    if sensor in ("gyro", "accel"):
        return f"{sensor}.{'scale' if rest.startswith('s') else 'misalignment'}"
    return sensor  # an effect: all of its parameters


@dataclasses.dataclass
class Step:
    first: int          # index of the first log with the new value
    block: str
    statistic: float
    log10_p: float      # corrected for all steps that were looked at
    value: np.ndarray = None  # new minus old, of the block's parameters
    covariance: np.ndarray = None


@dataclasses.dataclass
class Device:
    names: list
    value: np.ndarray       # now: after the last step
    covariance: np.ndarray
    initial: np.ndarray
    prior: np.ndarray
    steps: list
    cost: float             # of the logs' rows
    dof: float


def log10_chance(statistic, dof):
    """log10 of the probability that chi-square with `dof` degrees of freedom is larger; far out, where it is no number any more, by the
    first term of the incomplete gamma function's expansion (Abramowitz and Stegun, 6.5.32)."""
    chance = chi2.sf(statistic, dof)
    if chance > 1e-300:
        return math.log10(chance)
    half = statistic / 2
    return (-half + (dof / 2 - 1) * math.log(half) - math.lgamma(dof / 2)) / math.log(10)


def indices(names, block):
    return [i for i, name in enumerate(names) if block_of(name) == block]


def stacked(logs, steps):
    """(A, b, which log each row is of) over [x | one set of columns a step]. x is the value now: a step's columns stand on the logs
    before it."""
    log_of_row = np.concatenate([np.full(len(log.z), i) for i, log in enumerate(logs)])
    R, z = np.vstack([log.R for log in logs]), np.concatenate([log.z for log in logs])
    return np.hstack([R, *(step_columns(R, log_of_row, logs[0].names, s.first, s.block) for s in steps)]), z, log_of_row


def step_columns(R, log_of_row, names, first, block):
    return -R[:, indices(names, block)] * (log_of_row < first)[:, None]


@dataclasses.dataclass
class Solution:
    x: np.ndarray
    covariance: np.ndarray
    cost: float             # of the logs' rows
    dof: float              # rows less the parameters that they, not the prior, determine
    Q: np.ndarray           # orthonormal columns of the logs' rows, the prior's share left out
    residual: np.ndarray
    A: np.ndarray
    log_of_row: np.ndarray


def solve(logs, steps):
    """With the prior on x and on each step: a new value has it as the old one had, so that their difference has it twice."""
    A, b, log_of_row = stacked(logs, steps)
    chosen = [indices(logs[0].names, step.block) for step in steps]
    factor = np.zeros((A.shape[1], A.shape[1]))
    at = 0
    for P in [logs[0].prior, *(2 * logs[0].prior[np.ix_(c, c)] for c in chosen)]:
        factor[at:at + len(P), at:at + len(P)] = np.linalg.cholesky(P)
        at += len(P)
    U, s, Vt = np.linalg.svd(A @ factor, full_matrices=False)  # in units of the prior
    gain = 1 / (1 + s**2)
    y = Vt.T @ (s * gain * (U.T @ b))
    untold = np.eye(len(y)) - Vt.T @ Vt
    covariance = factor @ (Vt.T @ (gain[:, None] * Vt) + untold) @ factor.T
    residual = b - A @ (factor @ y)
    return Solution(factor @ y, covariance, float(residual @ residual), float(len(b) - np.sum(s**2 * gain)), U[:, s > LEAST_TOLD],
                    residual, A, log_of_row)


def best_step(logs, steps, dispersion, tests):
    """The most significant further step, or None. `tests`: how many are looked at in the whole fleet. What a step would take off
    the cost is the length of the residual along its columns, after all that the other columns can do is taken off these."""
    base = solve(logs, steps)
    names, best = logs[0].names, None
    R = base.A[:, :len(names)]
    for block in dict.fromkeys(map(block_of, names)):
        scale = np.sqrt(np.diag(logs[0].prior))[indices(names, block)]
        for first in range(1, len(logs)):
            B = step_columns(R, base.log_of_row, names, first, block) * scale
            U, s, _ = np.linalg.svd(B - base.Q @ (base.Q.T @ B), full_matrices=False)
            U = U[:, s > LEAST_TOLD]
            if not U.shape[1]:
                continue
            statistic = float(np.sum((U.T @ base.residual) ** 2)) / dispersion
            log10_p = min(0.0, log10_chance(statistic, U.shape[1]) + math.log10(tests))
            if best is None or log10_p < best.log10_p:
                best = Step(first, block, statistic, log10_p)
    return best if best and best.log10_p < math.log10(LEVEL) else None


def tests_of(logs):
    return (len(logs) - 1) * len(set(map(block_of, logs[0].names)))


def common(logs):
    """Logs that have the first one's parameters, about its start and with its prior."""
    first = logs[0]
    return [ev.about(log, first.initial) for log in logs if log.names == first.names]


def dispersion_of(devices):
    """How many times chi-square logs of a device disagree, over the fleet: the median, so that devices that changed do not count, and
    at least 1. `devices`: their evidence, one list each."""
    solutions = [solve(logs, []) for logs in devices]
    ratios = [s.cost / s.dof for s in solutions if s.dof > 1]
    return max(1.0, float(np.median(ratios))) if ratios else 1.0


def fuse(logs, dispersion=1.0, tests=None):
    """`logs`: evidence in order of time, from `common`."""
    steps = []
    tests = tests or max(1, tests_of(logs))
    while len(logs) > 1 and len(steps) < MOST_STEPS and (step := best_step(logs, steps, dispersion, tests)):
        steps.append(step)
    found, n = solve(logs, steps), len(logs[0].names)
    at = n
    for step in steps:
        own = slice(at, at + len(indices(logs[0].names, step.block)))
        step.value, step.covariance = found.x[own], dispersion * found.covariance[own, own]
        at = own.stop
    return Device(logs[0].names, logs[0].initial + found.x[:n], dispersion * found.covariance[:n, :n], logs[0].initial, logs[0].prior,
                  steps, found.cost, found.dof)
