"""All logs of a device as one least-squares problem R x = z (evidence.py), the prior once. A device that fell, ages or is warm has another
value of one block (a camera's rotation, say) in some logs: columns more, the block's times a course over the logs (forms.py)."""

import dataclasses
import functools

import numpy as np

import forms

LEAST_TOLD = 1.0    # singular value against the prior: a direction that the logs know less well than the prior shows no change


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
class Change:
    form: forms.Form
    block: str
    statistic: float    # what it takes off the cost beside the other changes, over the dispersion
    log10_p: float      # corrected for all that were looked at
    value: np.ndarray = None  # of the block's parameters, per 1 of the course
    covariance: np.ndarray = None
    rivals: list = dataclasses.field(default_factory=list)  # other forms that the logs do not tell from this one

    def same(self, other):
        return self.block == other.block and self.form.same(other.form)

    def size(self):
        """(Step, or rate per day, log or degC; its sigma), each of the block's parameters."""
        return self.value / self.form.span, np.sqrt(np.diag(self.covariance)) / self.form.span


def indices(names, block):
    return [i for i, name in enumerate(names) if block_of(name) == block]


def stacked(logs, changes):
    """(A, b, which log each row is of) over [x | one set of columns a change]. x is the value where all courses are zero."""
    log_of_row = np.concatenate([np.full(len(log.z), i) for i, log in enumerate(logs)])
    R, z = np.vstack([log.R for log in logs]), np.concatenate([log.z for log in logs])
    return np.hstack([R, *(columns(R, log_of_row, indices(logs[0].names, c.block), c.form) for c in changes)]), z, log_of_row


def columns(R, log_of_row, chosen, form):
    return R[:, chosen] * form.course[log_of_row][:, None]


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


def solve(logs, changes):
    """With the prior on x and on each change: a value at the course's other end has it as the one here, so that their difference has it
    twice."""
    A, b, log_of_row = stacked(logs, changes)
    chosen = [indices(logs[0].names, change.block) for change in changes]
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


def gains(base, chosen, scale, courses):
    """(What each course's columns would take off the cost, in how many directions). It is the length of the residual along these columns,
    after all that the other columns can do is taken off them; by sums over the logs, so that a course costs next to nothing."""
    if not len(base.residual):
        return np.zeros(len(courses)), np.zeros(len(courses), int)
    begin = np.flatnonzero(np.diff(base.log_of_row, prepend=-1))
    logs = [(X, Q, r) for X, Q, r in zip(*(np.split(rows, begin[1:]) for rows in (base.A[:, chosen] * scale, base.Q, base.residual)))]
    courses = courses[:, base.log_of_row[begin]]  # a log without rows says nothing
    own = np.einsum("fl,lij->fij", courses**2, np.array([X.T @ X for X, _, _ in logs]))
    shared = np.einsum("fl,lij->fij", courses, np.array([Q.T @ X for X, Q, _ in logs]))
    along = courses @ np.array([X.T @ r for X, _, r in logs]) - np.einsum("fij,i->fj", shared, base.Q.T @ base.residual)
    square, V = np.linalg.eigh(own - shared.transpose(0, 2, 1) @ shared)
    told = square > LEAST_TOLD**2
    return np.sum(np.where(told, np.einsum("fji,fj->fi", V, along) ** 2, 0) / np.where(told, square, 1), axis=1), told.sum(axis=1)
