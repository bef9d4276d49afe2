"""Units and axes of an IMU, by what gravity and the rotation must agree on.

Turned into one frame by the gyroscope, specific force averages to gravity over a second or so, because velocity is
bounded: f_G = a_G - g, and the mean of a_G is the change of velocity over the time. So the means of two neighbouring
seconds are the same vector. They are compared for the gyroscope as given, with other units, and with other axes; a
right-handed sensor in rad/s wins by itself. Without rotation nothing is said."""

import itertools

import numpy as np

GRAVITY = 9.80665
ACCEL_UNITS = {"m/s^2": 1.0, "g": GRAVITY, "mg": GRAVITY * 1e-3}
GYRO_UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180, "mdeg/s": np.pi / 180e3}
HALF_S = 1.0
MOST_WINDOWS = 120  # spread over the log
STEP_S = 0.01  # rates are averaged over this before they are integrated
LEAST_TURN = 0.1  # rad by which gravity turns between the halves, on average, below which nothing is said
BETTER = 0.6  # an alternative has to leave less than this share of what the sensor as given leaves


def accel_unit(accel):
    """The unit that makes the median specific force gravity's within a third; None where none does."""
    force = float(np.median(np.linalg.norm(accel, axis=1)))
    return next((unit for unit, scale in ACCEL_UNITS.items() if abs(force * scale / GRAVITY - 1) < 0.35), None)


def steps_of(t_ns, values, starts_s, n):
    """Means of `values` over n steps from each start, (windows, n, 3); NaN where a step has no sample."""
    t_s = (t_ns - t_ns[0]) * 1e-9
    edges = starts_s[:, None] + STEP_S * np.arange(n + 1)
    index = np.searchsorted(t_s, edges)
    sums = np.concatenate((np.zeros((1, 3)), np.cumsum(values, axis=0)))
    count = np.diff(index, axis=1)[..., None]
    with np.errstate(invalid="ignore"):
        return (sums[index[:, 1:]] - sums[index[:, :-1]]) / np.where(count > 0, count, np.nan)


def windows_of(t_ns, gyro, accel):
    """Rates and specific force over windows of two halves, (windows, steps, 3); None where the log is too short or sparse."""
    finite = np.isfinite(gyro).all(axis=1) & np.isfinite(accel).all(axis=1)
    t_ns, gyro, accel = t_ns[finite], gyro[finite], accel[finite]
    if len(t_ns) < 2 or (last := (t_ns[-1] - t_ns[0]) * 1e-9 - 2 * HALF_S) < 5:
        return None
    starts = np.linspace(0, last, min(MOST_WINDOWS, int(last / HALF_S)))
    n = round(2 * HALF_S / STEP_S)
    # Rates average to the bias over a log, but for whole turns: 0.08 rad/s on euroc_mh01, as much as the motion in two seconds.
    w, f = steps_of(t_ns, gyro - np.mean(gyro, axis=0), starts, n), steps_of(t_ns, accel, starts, n)
    bridged = np.isnan(w).any(axis=2) | np.isnan(f).any(axis=2)
    w, f = np.where(bridged[..., None], 0, w), np.where(bridged[..., None], 0, f)
    good = bridged.mean(axis=1) < 0.6  # a 50 Hz sensor fills every second step
    filled = 1 / np.maximum(1 - bridged.mean(axis=1), 0.1)  # an empty step stands for its neighbours
    return (w * filled[:, None, None])[good], f[good], ~bridged[good]


def left_over(windows, rates):
    """Mean angle between the mean forces of both halves, turned into one frame by `rates` (..., windows, steps, 3), rad."""
    _, force, filled = windows
    turned = np.zeros(rates.shape[:-2] + (2, 3))
    q = np.zeros(rates.shape[:-2] + (4,))
    q[..., 0] = 1
    n = rates.shape[-2]
    for k in range(n):
        f = np.broadcast_to(force[:, k], turned.shape[:-2] + (3,))
        turned[..., 0 if 2 * k < n else 1, :] += turn(q, f) * filled[:, k, None]
        q = times_small(q, rates[..., k, :] * STEP_S)
    first, second = (turned[..., i, :] / np.linalg.norm(turned[..., i, :], axis=-1, keepdims=True) for i in (0, 1))
    return np.mean(np.arctan2(np.linalg.norm(np.cross(first, second), axis=-1), np.sum(first * second, axis=-1)), axis=-1)


def turn(q, v):
    t = 2 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * t + np.cross(q[..., 1:], t)


def times_small(q, phi):
    """q times the rotation by phi, to second order; normalised."""
    w, u = q[..., :1], q[..., 1:]
    s, v = 1 - np.sum(phi * phi, axis=-1, keepdims=True) / 8, phi / 2
    out = np.concatenate((w * s - np.sum(u * v, axis=-1, keepdims=True), w * v + s * u + np.cross(u, v)), axis=-1)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def axis_words(columns, signs):
    return ",".join(("-" if s < 0 else "") + "xyz"[c] for c, s in zip(columns, signs))


def parse_axes(text):
    """ "y,-x,z" as (columns, signs): the new x is the old y, and so on. Raises ValueError."""
    parts = [part.strip() for part in text.split(",")]
    columns = ["xyz".index(part[-1]) if part and part.lstrip("-+") in ("x", "y", "z") else 9 for part in parts]
    if sorted(columns) != [0, 1, 2]:
        raise ValueError(text)
    return columns, [-1.0 if part.startswith("-") else 1.0 for part in parts]


def gyro_findings(t_ns, gyro, accel):
    """(unit, axes): the unit and the axes with which the gyroscope agrees with gravity; None each where the one given is
    as good or the motion does not tell. `gyro` in rad/s as assumed, `accel` in m/s^2."""
    windows = windows_of(t_ns, gyro, accel)
    if windows is None or len(windows[0]) < 5:
        return None, None
    w = windows[0]
    scale = GYRO_UNITS["deg/s"]
    still, given, degrees = left_over(windows, np.stack((0 * w, w, w * scale)))
    if still < LEAST_TURN:
        return None, None
    unit = "deg/s" if degrees < BETTER * min(given, still) else None
    w, given = (w * scale, degrees) if unit else (w, given)
    choices = [(columns, signs) for columns in itertools.permutations(range(3)) for signs in itertools.product((1, -1), repeat=3)]
    left = left_over(windows, np.stack([w[..., columns] * signs for columns, signs in choices]))
    best = int(np.argmin(left))
    if left[best] >= BETTER * min(given, still):
        return unit, None
    axes = axis_words(*choices[best])
    return unit, axes if axes != "x,y,z" else None
