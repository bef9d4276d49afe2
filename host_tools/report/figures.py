"""The figures of the report. Each function takes report_data.json's content and returns a plotly figure.

A figure that cannot be drawn raises Missing with the reason in words; the page then shows the sentence instead.
"""

import numpy as np
import plotly.graph_objects as go
import plotly.io
from plotly.subplots import make_subplots

KEPT = "#d9480f"
PATH = "#8a99ad"
TRUTH = "#2b8a3e"
AXES = {"x": "#1864ab", "y": "#e67700", "z": "#862e9c"}
LIMIT = "#c92a2a"
LARGEST_NUMBER_OF_POINTS = 6000
plotly.io.templates.default = "plotly_white"  # said here once: said of each figure, plotly copies it four times as often


class Missing(ValueError):
    """Why a figure is left out."""


def member(data, *path):
    """data[path[0]][path[1]]..., or Missing."""
    for depth, name in enumerate(path, start=1):
        if not isinstance(data, dict) or data.get(name) in (None, [], {}):
            raise Missing(f"The data hold no {'.'.join(path[:depth])}.")
        data = data[name]
    return data


def numbers(values, columns, name):
    """An array of n rows; null becomes NaN, which is drawn as a gap."""
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise Missing(f"{name} is not a table of numbers.") from None
    if array.ndim != (1 if columns == 1 else 2) or (columns > 1 and array.shape[1] != columns):
        raise Missing(f"{name} does not have {columns} columns.")
    return array


def series(data, group, names):
    """Times and the named three-column tables of one group, all of the same length."""
    t = numbers(member(data, *group, "t"), 1, ".".join(group) + ".t")
    tables = {}
    for name in names:
        tables[name] = numbers(member(data, *group, name), 3, name)
        if len(tables[name]) != len(t):
            raise Missing(f"{'.'.join(group)}: t and {name} differ in length.")
    return t, tables


def thinned(count):
    """Indices of at most LARGEST_NUMBER_OF_POINTS of `count` points, evenly spread."""
    step = max(1, -(-count // LARGEST_NUMBER_OF_POINTS))
    return slice(0, count, step)


def rounded(values, decimals):
    """Digits that no screen shows only make the page larger."""
    return np.round(np.asarray(values, dtype=float), decimals)


def styled(figure, height):
    # Titles of subplots stand where the legend would end: it goes to the figure's edge, with room for three lines on a phone.
    titled = bool(figure.layout.annotations)
    place = dict(yref="container", yanchor="top", y=0.995) if titled else dict(yanchor="bottom", y=1.0)
    figure.update_layout(
        height=height + (50 if titled else 0), margin=dict(l=58, r=12, t=110 if titled else 60, b=44),
        font=dict(size=13), legend=dict(orientation="h", x=0, itemsizing="constant", **place), hovermode="closest",
        dragmode=False)  # a finger on a figure scrolls the page
    figure.update_xaxes(automargin=True)
    figure.update_yaxes(automargin=True)
    return figure


def kept_runs(kept):
    """(segment, first, last + 1) for each run of poses inside one kept segment; -1 is none."""
    kept = np.asarray(kept)
    edges = np.flatnonzero(np.diff(kept)) + 1
    starts = np.concatenate(([0], edges))
    ends = np.concatenate((edges, [len(kept)]))
    return [(int(kept[a]), a, b) for a, b in zip(starts, ends) if kept[a] >= 0]


def aligned(p_from, p_to):
    """Yaw and translation that bring p_from onto p_to in least squares: (R, offset), p_to = R p_from + offset."""
    mean_from, mean_to = p_from.mean(axis=0), p_to.mean(axis=0)
    a, b = p_from - mean_from, p_to - mean_to
    yaw = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]))
    R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    return R, mean_to - R @ mean_from


def true_path(data, t, p):
    """The true positions at the times t that the truth covers, turned and moved onto the path: an odometry knows neither
    its heading nor its place. None without truth."""
    if not isinstance(data.get("truth"), dict) or not data["truth"].get("p"):
        return None
    t_truth, tables = series(data, ("truth",), ("p",))
    covered = (t >= t_truth[0]) & (t <= t_truth[-1]) & np.isfinite(p).all(axis=1)
    if np.count_nonzero(covered) < 3:
        return None
    truth = np.column_stack([np.interp(t[covered], t_truth, tables["p"][:, axis]) for axis in range(3)])
    R, offset = aligned(truth, p[covered])
    return rounded(truth @ R.T + offset, 4)


def path_parts(data):
    """The estimated path, its kept runs, and the true path if it is known."""
    t, tables = series(data, ("trajectory",), ("p",))
    index = thinned(len(t))
    t, p = t[index], rounded(tables["p"][index], 4)
    kept = data["trajectory"].get("kept") or []
    runs = kept_runs(kept[index]) if len(kept) == len(tables["p"]) else []
    return t, p, runs, true_path(data, t, p)


def path_traces(data, columns, trace):
    """Traces of the path in the given columns (0 x, 1 y, 2 z); `trace` is go.Scatter or go.Scatter3d."""
    t, p, runs, truth = path_parts(data)

    def line(values, **style):
        return trace(dict(zip("xyz", (values[:, c] for c in columns))), mode="lines", **style)

    traces = []
    if truth is not None:
        traces.append(line(truth, name="truth", line=dict(color=TRUTH, width=2, dash="dot")))
    traces.append(line(p, name="path", line=dict(color=PATH, width=2), hoverinfo="skip"))
    traces.append(trace(dict(zip("xyz", ([p[0, c]] for c in columns))), mode="markers", name="start", hoverinfo="name",
                        marker=dict(color="#212529", size=7 if len(columns) == 2 else 4)))
    for position, (segment, begin, end) in enumerate(runs):
        label = f"segment {segment}, {t[begin]:.1f} to {t[end - 1]:.1f} s"
        traces.append(line(p[begin:end], name="kept segments", legendgroup="kept", showlegend=position == 0,
                           line=dict(color=KEPT, width=5), hovertext=label, hoverinfo="text"))
    return traces


def top_view(data):
    figure = go.Figure(path_traces(data, (0, 1), go.Scatter))
    figure.update_xaxes(title="x [m]")
    figure.update_yaxes(title="y [m]", scaleanchor="x", scaleratio=1)
    return styled(figure, 420)


def view_3d(data):
    figure = go.Figure(path_traces(data, (0, 1, 2), go.Scatter3d))
    figure.update_layout(scene=dict(
        aspectmode="data", xaxis_title="x [m]", yaxis_title="y [m]", zaxis_title="z [m]",
        camera=dict(eye=dict(x=2.2, y=2.2, z=1.3))))
    styled(figure, 440)
    figure.update_layout(margin=dict(l=0, r=0, t=60, b=0), dragmode="orbit")
    return figure


METRICS = {"A": ("A: trace [-]", "log"), "D": ("D: log det [-]", "linear"), "E": ("E: largest eigenvalue [-]", "log")}


def segment_axis(figure, segments, **where):
    """One place per segment, labelled by its start: sessions may lie hours apart."""
    step = max(1, -(-len(segments) // 8))
    places = list(range(0, len(segments), step))
    figure.update_xaxes(title="start of the segment [s]", tickvals=places, ticktext=[f"{segments[i]['start_s']:.0f}" for i in places],
                        range=[-0.5, len(segments) - 0.5], **where)


def log_ticks(values):
    """1, 2 and 5 times powers of ten around the values, fewer where they span a lot."""
    low, high = int(np.floor(np.log10(min(values)))), int(np.ceil(np.log10(max(values))))
    digits = (1, 2, 5) if high - low <= 3 else (1,)
    return [d * 10.0**k for k in range(low, high + 1) for d in digits]


def metrics(data):
    segments = member(data, "segments")
    present = [m for m in METRICS if any(s.get(m) is not None for s in segments)]
    if not present:
        raise Missing("No segment carries a metric.")
    figure = make_subplots(rows=len(present), cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for row, metric in enumerate(present, start=1):
        title, scale = METRICS[metric]
        for kept, color, name in ((False, PATH, "seen"), (True, KEPT, "kept")):
            mine = [(i, s[metric]) for i, s in enumerate(segments) if bool(s.get("kept")) == kept and s.get(metric) is not None]
            figure.add_scatter(x=[i for i, _ in mine], y=[v for _, v in mine], mode="markers", name=name, legendgroup=name, showlegend=row == 1,
                               marker=dict(color=color, size=9, symbol="square"), row=row, col=1)
        positive = [s[metric] for s in segments if (s.get(metric) or 0) > 0]
        ticks = log_ticks(positive) if scale == "log" and positive else None
        figure.update_yaxes(title=title, type=scale, nticks=6, tickvals=ticks, ticktext=ticks and [f"{t:g}" for t in ticks], row=row, col=1)
    segment_axis(figure, segments)
    figure.update_xaxes(title=None)
    figure.update_xaxes(title="start of the segment [s]", row=len(present), col=1)
    return styled(figure, 200 * len(present) + 90)


def add_limits(figure, row):
    for limit in (-3, 3):
        figure.add_hline(y=limit, line=dict(color=LIMIT, width=1.5, dash="dash"), row=row, col=1)


def camera_columns(data):
    """t, u and v in sigmas as columns."""
    camera = member(data, "residuals", "camera")
    return np.column_stack([numbers(member(camera, name), 1, f"residuals.camera.{name}") for name in ("t", "u_sigma", "v_sigma")])


def camera_residuals(data):
    table = camera_columns(data)
    shown = rounded(table[thinned(len(table))], 3)
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for row, (axis, color) in enumerate((("u", AXES["x"]), ("v", AXES["y"])), start=1):
        figure.add_scatter(x=shown[:, 0], y=shown[:, row], mode="markers", name=axis, row=row, col=1,
                           marker=dict(size=3, color=color, opacity=0.45))
        figure.update_yaxes(title=f"{axis} residual [sigma]", row=row, col=1)
        add_limits(figure, row)
    figure.update_xaxes(title="time [s]", row=2, col=1)
    return styled(figure, 460)


def add_axes(figure, t, table, row, decimals):
    """Three lines x, y, z in one row; the legend shows each axis once."""
    for column, (axis, color) in enumerate(AXES.items()):
        figure.add_scatter(x=rounded(t, 3), y=rounded(table[:, column], decimals), mode="lines", name=axis,
                           line=dict(color=color, width=1.3), legendgroup=axis, showlegend=row == 1, row=row, col=1)


def imu_residuals(data):
    parts = [p for p in ("rotation", "velocity", "position") if (member(data, "residuals", "imu")).get(p)]
    if not parts:
        raise Missing("The data hold no residuals.imu.")
    t, tables = series(data, ("residuals", "imu"), parts)
    index = thinned(len(t))
    figure = make_subplots(rows=len(parts), cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for row, part in enumerate(parts, start=1):
        add_axes(figure, t[index], tables[part][index], row, 3)
        figure.update_yaxes(title=f"{part} [sigma]", row=row, col=1)
        add_limits(figure, row)
    figure.update_traces(mode="markers", marker=dict(size=3, opacity=0.6))
    figure.update_xaxes(title="time [s]", row=len(parts), col=1)
    return styled(figure, 200 * len(parts) + 90)


def biases(data):
    t, tables = series(data, ("biases",), ("gyro", "accel"))
    index = thinned(len(t))
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.06)
    for row, (sensor, title) in enumerate((("gyro", "gyroscope [rad/s]"), ("accel", "accelerometer [m/s²]")), start=1):
        add_axes(figure, t[index], tables[sensor][index], row, 7)
        figure.update_yaxes(title=title, row=row, col=1)
    figure.update_xaxes(title="time [s]", row=2, col=1)
    return styled(figure, 460)


def outside_three_sigma(data):
    """Per sensor, the share of residuals beyond 3 sigma; a normal distribution has 0.27 %."""
    shares = {}
    residuals = data.get("residuals") or {}
    camera = camera_columns(data)[:, 1:] if (residuals.get("camera") or {}).get("t") else []
    imu = residuals.get("imu") or {}
    groups = {"camera": camera, **{f"IMU {n}": imu.get(n) or [] for n in ("rotation", "velocity", "position")}}
    for name, values in groups.items():
        array = np.abs(np.array(values, dtype=float).ravel())
        array = array[np.isfinite(array)]
        if len(array):
            shares[name] = (float(np.mean(array > 3)), float(np.sqrt(np.mean(array**2))), len(array))
    return shares
