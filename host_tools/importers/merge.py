"""One IMU stream out of a gyroscope's and an accelerometer's."""

import numpy as np

from streams import Imu

LONGEST_BRIDGE = 5  # periods of the accelerometer that interpolation may bridge


def at_times(t_ns, values, times_ns):
    """Linear interpolation, columns of `values`."""
    t0 = t_ns[0]
    seconds, wanted = (t_ns - t0) * 1e-9, (times_ns - t0) * 1e-9
    return np.stack([np.interp(wanted, seconds, column) for column in values.T], axis=1)


def merged(gyro, accel):
    """The accelerometer's values at the gyroscope's stamps, and how many gyroscope samples were dropped: those before the
    first, after the last and in gaps of the accelerometer. The gyroscope's values stay as they are."""
    order = np.argsort(accel.t_ns, kind="stable")
    t_ns, values = accel.t_ns[order], accel.accel[order]
    keep = np.concatenate(([True], np.diff(t_ns) > 0))
    t_ns, values = t_ns[keep], values[keep]
    period = np.median(np.diff(t_ns)) if len(t_ns) > 1 else 0
    after = np.searchsorted(t_ns, gyro.t_ns, side="left")
    inside = (after < len(t_ns)) & ((after > 0) | (gyro.t_ns == t_ns[np.minimum(after, len(t_ns) - 1)]))
    gap = t_ns[np.clip(after, 0, len(t_ns) - 1)] - t_ns[np.clip(after - 1, 0, len(t_ns) - 1)]
    usable = inside & (gap <= LONGEST_BRIDGE * period)
    part = gyro.chosen(usable)
    out = Imu(f"{gyro.name} + {accel.name}", part.t_ns, part.log_ns, part.gyro, at_times(t_ns, values, part.t_ns),
              part.temperature, gyro.gyro_unit, accel.accel_unit)
    return out, int(np.count_nonzero(~usable))
