"""Devices from the evidence of their logs: the value now, and what changed (search.py)."""

import dataclasses

import numpy as np

import evidence as ev
import forms
import search
from problem import indices, solve


MOST_ROUNDS = 8  # in which the dispersion settles; five where a dozen devices all had temperature in five blocks


@dataclasses.dataclass
class Device:
    names: list
    value: np.ndarray       # now: after the last step, at the end of a trend, at the mean temperature
    covariance: np.ndarray
    initial: np.ndarray
    prior: np.ndarray
    changes: list
    cost: float             # of the logs' rows
    dof: float

    def at(self, log):
        """The value at a log, by its index."""
        value = self.value.copy()
        for change in self.changes:
            value[indices(self.names, change.block)] += change.form.course[log] * change.value
        return value


def common(logs):
    """Logs that have the first one's parameters, about its start and with its prior."""
    first = logs[0]
    return [ev.about(log, first.initial) for log in logs if log.names == first.names]


def dispersion_of(fits):
    """How many times chi-square logs of a device disagree, over the fleet: the median, so that devices that changed do not count, and
    at least 1. `fits`: one a device."""
    ratios = [fit.cost / fit.dof for fit in fits if fit.dof > 1]
    return max(1.0, float(np.median(ratios))) if ratios else 1.0


def fuse(logs, dispersion=1.0, tests=None, axes=None):
    """`logs`: evidence in order of time, from `common`; `axes`: when and how warm they were, else their places alone."""
    axes = axes or forms.places_alone(len(logs))
    changes = search.changes_of(search.Search(logs, forms.forms_of(axes), dispersion, tests or max(1, search.tests_of(logs, axes))))
    found, n = solve(logs, changes), len(logs[0].names)
    at = n
    for change in changes:
        own = slice(at, at + len(indices(logs[0].names, change.block)))
        change.value, change.covariance = found.x[own], dispersion * found.covariance[own, own]
        at = own.stop
    return Device(logs[0].names, logs[0].initial + found.x[:n], dispersion * found.covariance[:n, :n], logs[0].initial, logs[0].prior,
                  changes, found.cost, found.dof)


def fuse_fleet(devices, axes):
    """(Fit of each device, dispersion). `devices`: their evidence, one list each. Where most devices changed, as all of a model with
    temperature, the median is theirs, and lesser changes hide behind it: it is taken again without what was named, until it has settled."""
    tests = max(1, sum(map(search.tests_of, devices, axes)))
    dispersion = dispersion_of([solve(logs, []) for logs in devices])
    for _ in range(MOST_ROUNDS):
        fits = [fuse(logs, dispersion, tests, own) for logs, own in zip(devices, axes)]
        again = dispersion_of(fits)
        if again > 0.95 * dispersion:  # settled
            break
        dispersion = again
    else:
        fits = [fuse(logs, dispersion, tests, own) for logs, own in zip(devices, axes)]
    return fits, dispersion
