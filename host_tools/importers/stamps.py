"""Which stamp of a sample is used, and stamps that were taken in a callback made regular again."""

import numpy as np

IRREGULAR = 0.5  # (95 % - 5 % quantile) of the intervals over their median; hardware stamps stay below 0.1, callbacks lie above 0.6
LONGEST_LOG_NS = 3.2e16  # a year: what begins at zero and reaches further has a stamp that was never set
WINDOW_S = 1.0  # over which an oscillator's drift (below 100 ppm) does not matter, and some 200 samples average their delays


def usable(t_ns):
    """Stamps that were set: not all zero or equal, few that go back, and none of zero among those of an epoch."""
    if len(t_ns) == 0 or (np.any(t_ns <= 0) and np.max(t_ns) - np.min(t_ns) > LONGEST_LOG_NS):
        return False
    steps = np.diff(t_ns)
    return len(steps) == 0 or (np.count_nonzero(steps > 0) >= 0.9 * len(steps))


def irregular(t_ns):
    """True where the intervals scatter as those of callbacks do."""
    if len(t_ns) < 50:
        return False
    low, middle, high = np.quantile(np.diff(t_ns), [0.05, 0.5, 0.95])
    return bool(high - low > IRREGULAR * middle)


def regular(t_ns):
    """Stamps of a sensor that samples at a steady rate and whose samples were stamped when they arrived.

    Arrival k is at t_0 + k T + delay_k. T is the slope of a line through all (robust: the median of slopes over half the
    log), the delays' running median over WINDOW_S follows clock drift. Where the stamps jump by whole periods, samples
    were lost: the line is continued there with k raised. What remains of the delays, their median, is constant and is
    for the calibration to find (time_offset)."""
    t = (t_ns - t_ns[0]).astype(float)
    n = len(t)
    half = n // 2
    T = float(np.median((t[half:] - t[: n - half]) / half))
    k = np.arange(n) + np.concatenate(([0], np.cumsum(lost_before(t, T))))
    T = float(np.median((t[half:] - t[: n - half]) / (k[half:] - k[: n - half])))
    delay = running_median(t - k * T, max(int(WINDOW_S * 1e9 / T) // 2, 5))
    out = t_ns[0] + np.rint(k * T + delay).astype(np.int64)
    return np.maximum.accumulate(out)


def lost_before(t, T, side=25):
    """Samples lost between k and k + 1, by the level of the delays before and after: a late sample comes back, a loss does not."""
    lost = np.zeros(len(t) - 1, int)
    steps = np.diff(t)
    for k in np.flatnonzero(steps > 1.6 * T):
        if steps[k] < np.max(steps[max(0, k - side) : k + side]):
            continue  # the levels beside a late sample would tell of the loss beside it once more
        before, after = t[max(0, k - side + 1) : k + 1], t[k + 1 : k + 1 + side]
        levels = [np.median(part - T * np.arange(len(part))) for part in (before[::-1] + 2 * T * np.arange(len(before)), after)]
        # before[::-1] + 2 T i - T i: each sample carried forward to k; after - T i: each carried back to k + 1
        lost[k] = max(0, int(np.rint((levels[1] - levels[0]) / T)) - 1)
    return lost


def running_median(values, half):
    half = min(half, len(values) - 1)
    wide = np.pad(values, half, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(wide, 2 * half + 1)
    return np.median(windows, axis=1)
