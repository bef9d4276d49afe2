"""In which ways a block of a device may have changed over its logs: by a step between two of them, by a trend that is linear in time, or
with temperature, linear in it. Each is a course: one number a log, by which what the block changed by is multiplied. The fused
value is where the course is zero: after the step, at the last log, at the logs' mean temperature."""

import dataclasses

import numpy as np

STEP, TREND, TEMPERATURE = "step", "trend", "temperature"

DAY_NS = 86400e9
NEAR_ZERO_NS = 365 * DAY_NS  # a clock that began less than a year ago counts since the device's last start; one with a date, since decades
LEAST_WARM_LOGS = 3          # logs that tell their temperature: two are a line whatever the device does
LEAST_SPAN_DEGC = 5.0        # of the logs' temperatures: the IMU's own heat, and how far it is from the camera's, are a few degC in each log


@dataclasses.dataclass
class Axes:
    """Of a device's logs, in their order: when each was, and how warm (nan: not told)."""
    time: np.ndarray
    time_unit: str      # "day", or "log": the place among the device's logs
    degC: np.ndarray

    def reference_degC(self):
        """The mean of the logs that tell it; None without any."""
        known = self.degC[np.isfinite(self.degC)]
        return float(known.mean()) if len(known) else None


@dataclasses.dataclass
class Form:
    kind: str
    course: np.ndarray  # -1..0 of a step and a trend; of temperature, 1 between the coldest and the warmest log
    span: float = 1.0   # what the course's 1 is, in `unit`
    unit: str = ""      # "day", "log" or "degC"; none of a step
    first: int = 0      # index of the first log with the new value

    def same(self, other):
        return (self.kind, self.first) == (other.kind, other.first)


def axes_of(start_ns, places, temperatures):
    """`start_ns`: of each log, or None; `temperatures`: [lowest, highest] of each in degC, or None."""
    degC = np.array([np.nan if t is None else (t[0] + t[1]) / 2 for t in temperatures], float)
    dated = all(s is not None and s > NEAR_ZERO_NS for s in start_ns) and all(a < b for a, b in zip(start_ns, start_ns[1:]))
    if not dated:
        return Axes(np.array(places, float), "log", degC)
    return Axes(np.array([s - start_ns[-1] for s in start_ns]) / DAY_NS, "day", degC)  # whole ns first: as doubles they are 256 ns apart


def places_alone(count):
    return Axes(np.arange(count, dtype=float), "log", np.full(count, np.nan))


def forms_of(axes):
    """All that are looked at, of each block. Of two logs, step and trend are the same."""
    count, time = len(axes.time), axes.time
    if count < 2:
        return []
    forms = [Form(STEP, -(np.arange(count) < first).astype(float), first=first) for first in range(1, count)]
    forms.append(Form(TREND, (time - time[-1]) / (time[-1] - time[0]), time[-1] - time[0], axes.time_unit))
    known = np.isfinite(axes.degC)
    span = np.ptp(axes.degC[known]) if known.sum() >= LEAST_WARM_LOGS else 0.0
    if span >= LEAST_SPAN_DEGC:  # a log that does not tell its temperature is taken for one at the mean
        forms.append(Form(TEMPERATURE, np.where(known, axes.degC - axes.reference_degC(), 0.0) / span, float(span), "degC"))
    return forms
