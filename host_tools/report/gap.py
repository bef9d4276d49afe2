"""The gap page: what `segcal diagnose` found, and how the disagreement of model and measurements shrinks."""

import figures
import numpy as np
import plotly.graph_objects as go
import twin_page
import words
from page import attempt, document, drawn, heading, joined, note, section, table
from page import headline as box
from plotly.subplots import make_subplots

BEFORE, AFTER, FLOOR = "#d9480f", "#1864ab", "#adb5bd"
VERDICTS = {"consistent": ("calibrated", "Model and measurements agree"), "explained": ("calibrated", "Explained"),
            "partly_explained": ("insufficient", "Partly explained"), "unexplained": ("failed", "Unexplained"),
            "bad_data": ("failed", "Bad data")}


def headline(diagnosis):
    """The verdict, then the faults of the data."""
    css, title = VERDICTS.get(diagnosis["verdict"], ("failed", diagnosis["verdict"]))
    if not diagnosis.get("judged", True):
        css, title = "insufficient", "Cannot tell"
    found = [f"{f['words']} ({f['sensor']}, {words.plain(f['count'])})." for f in diagnosis.get("faults") or []]
    sentence = diagnosis.get("sentence", "").replace("->", "→")
    told = sentence[:1].upper() + sentence[1:] if sentence.lower().startswith(title.lower()) else f"{title}: {sentence}"
    return box(css, f"{told}.", *found)


def effects(diagnosis):
    rows = []
    for e in diagnosis.get("effects") or []:
        for k, p in enumerate(e.get("parameters") or []):
            value = f'{words.with_digits_of(p["value"], p["sigma"])} ± {words.with_digits_of(p["sigma"], p["sigma"])}'
            last = (words.plain(e["statistic"]), f'{e["log10_p"]:.1f}', "-" if e["gap_closed"] is None else f'{100 * e["gap_closed"]:.1f} %') if k == 0 else ("", "", "")
            rows.append((p["name"], value, p["unit"], *last))
        for other in e.get("or") or []:
            rows.append((f"or {other}", "told apart by " + e.get("separated_by", ""), "", "", "", ""))
    if not rows:
        return section("Effects", note("None was named."))
    header = ("parameter", "value ± sigma", "unit", "statistic", "log10 p", "gap closed")
    return section("Effects", table(header, rows),
                        note("Statistic: what chi² falls by, over its dispersion. Gap closed: on segments that the value was not fitted to."))


SENSORS = ("total", "camera", "gyro", "accel")


def measured_sensors(gap):
    """Without those of whose rows nothing was left: an excess of zero would say that they agree."""
    dof = gap.get("dof") or {}
    return [s for s in SENSORS if dof.get(s, 1) > 0]


def gap_figure(diagnosis):
    """How often its own noise each sensor leaves, which is 1 where the model is right."""
    gap = figures.member(diagnosis, "gap")
    sensors = measured_sensors(gap)
    if not sensors or not (gap.get("noise_floor") or {}).get("total"):
        raise figures.Missing("nothing was fitted")
    sigmas = gap.get("sigma") or {}
    spread = [2 * sigmas.get(s, gap.get("after_sigma") or 0) for s in sensors]
    figure = go.Figure()
    for name, color in (("before", BEFORE), ("after", AFTER)):
        values = [1 + gap[name][s] for s in sensors]
        figure.add_bar(x=sensors, y=values, name=name, marker_color=color, text=[f"{v:.3g}" for v in values], textposition="inside", insidetextanchor="start",
                       error_y=dict(type="data", array=spread, thickness=1.2, color="#495057"))
    floor = dict(color="#212529", width=1, dash="dash")
    figure.add_hline(y=1, line=floor)
    figure.add_scatter(x=[sensors[0]], y=[None], mode="lines", line=floor, name="noise floor")   # in the legend: bars leave no room at the line
    all_values = [1 + gap[name][s] for name in ("before", "after") for s in sensors]
    smallest, largest = max(min(all_values), 0.01), max(all_values)
    scale = dict(type="log", dtick="D2", range=[np.log10(smallest) - 0.3, np.log10(largest) + 0.15]) if largest > 4 * smallest else dict(rangemode="tozero")
    figure.update_yaxes(title="chi² / dof, noise = 1", **scale)
    return figures.styled(figure, 340)


def gap_table(diagnosis):
    gap = diagnosis.get("gap") or {}
    floor = gap.get("noise_floor") or {}
    sigmas, dof = gap.get("sigma") or {}, gap.get("dof") or {}
    rows = []
    for s in measured_sensors(gap):
        base = floor.get(s) or 1
        cells = [gap.get(k, {}).get(s, 0) for k in ("before", "after")]
        spread = f"{sigmas[s]:.2g}" if s in sigmas else ""
        rows.append((s, *(f"{base * (1 + v):.4f}" for v in cells), f"{base:.4f}", *(f"{v:.2g}" for v in cells), spread, f"{dof[s]:.0f}" if s in dof else ""))
    rows += [(s, "not measured", *("",) * 6) for s in SENSORS if s not in measured_sensors(gap)]
    header = ("sensor", "chi²/dof before", "after", "noise floor", "excess before", "after", "sigma", "dof")
    closed = f'{100 * gap.get("closed", 0):.1f} % of the excess is gone; what lies within ± {2 * (gap.get("after_sigma") or 0):.2g} counts as none.'
    if not gap.get("before", {}).get("total"):
        closed = "Nothing is open in total."
    noise = diagnosis.get("noise")
    tracks = noise.get("tracks") if isinstance(noise, dict) else None
    if isinstance(tracks, dict):
        closed += (f' Corner tracks drift: points were weighed by {tracks.get("white_px", 0):.2f} px of white noise and a walk of '
                   f'{tracks.get("walk_px_per_sqrt_s", 0):.2f} px/sqrt(s) along each track, not by the stated noise.')
    for sensor in ("gyro", "accel"):
        told = noise.get(sensor) if isinstance(noise, dict) else None
        if isinstance(told, dict) and told.get("grows_with_motion"):
            closed += (f' {sensor}: its noise grows with motion, {told["factor"]:.1f} times the stated one where it is quiet and '
                       f'{told["lively_factor"]:.1f} where it shakes most.')
    sensors = note("On segments that were used neither to choose the effects nor to fit them. Camera: images against each other. Gyro: rates against the turns in "
                   "the images. Accel: forces against the motion that both see. Bars of error: two sigmas of chance.") if sigmas else ""
    return joined(table(header, rows), note(closed), sensors)


def worst_windows(data):
    windows = figures.member(data, "windows")[:3]
    figure = make_subplots(rows=len(windows), cols=1, vertical_spacing=0.5 / (3 + len(windows)),
                           subplot_titles=[f'{w["start_s"]:.0f} to {w["end_s"]:.0f} s' for w in windows])
    for row, w in enumerate(windows, start=1):
        for when, color in (("before", BEFORE), ("after", AFTER)):
            if when not in w:
                continue
            for axis, dash in (("u_px", "solid"), ("v_px", "dot")):
                figure.add_scatter(x=figures.rounded(w[when]["t"], 3), y=figures.rounded(w[when][axis], 4), mode="lines",
                                   line=dict(color=color, dash=dash), name=f"{axis[0]}, {when}", showlegend=row == 1, row=row, col=1)
        figure.update_yaxes(title="px", row=row, col=1)
    figure.update_xaxes(title="time [s]", row=len(windows), col=1)
    return figures.styled(figure, 130 + 190 * len(windows))


def imu_windows(data):
    window = figures.member(data, "windows")[0]
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.12, subplot_titles=("gyro", "accel"))
    for when, color in (("before", BEFORE), ("after", AFTER)):
        for row, sensor in ((1, "gyro"), (2, "accel")):
            if when not in window:
                continue
            table = figures.numbers(window[when][sensor], 3, sensor)
            for k, dash in enumerate(("solid", "dash", "dot")):
                figure.add_scatter(x=figures.rounded(window[when]["t_imu"], 3), y=figures.rounded(table[:, k], 4), mode="lines",
                                   line=dict(color=color, dash=dash), name=f'{"xyz"[k]}, {when}', showlegend=row == 1, row=row, col=1)
            figure.update_yaxes(title="sigma", row=row, col=1)
    figure.update_xaxes(title="time [s]", row=2, col=1)
    return figures.styled(figure, 420)


def track(data):
    """One corner's measured way through the image and the model's, with the error drawn ten times as large."""
    window = figures.member(data, "windows")[0]
    figure = go.Figure()
    for when, color in (("before", BEFORE), ("after", AFTER)):
        entry = window.get(f"track_{when}")
        if not entry or not entry["measured"]:
            continue
        measured, simulated = (figures.numbers(entry[k], 2, k) for k in ("measured", "simulated"))
        if when == "before":
            figure.add_scatter(x=measured[:, 0], y=measured[:, 1], mode="markers", marker=dict(color="#212529", size=6), name="measured")
        shown = measured + 10 * (simulated - measured)
        figure.add_scatter(x=figures.rounded(shown[:, 0], 2), y=figures.rounded(shown[:, 1], 2), mode="lines+markers",
                           line=dict(color=color, width=1), marker=dict(size=4), name=f"simulated, {when}")
    if not figure.data:
        raise figures.Missing("The data hold no track.")
    figure.update_xaxes(title="image x [px]")
    figure.update_yaxes(title="image y [px]", autorange="reversed")
    return figures.styled(figure, 380)


def cause_figure(before, after):
    figure = go.Figure()
    for entry, color, name in ((before, BEFORE, "before"), (after, AFTER, "after")):
        if not entry or not entry.get("cause"):
            continue
        figure.add_scatter(x=figures.rounded(entry["cause"], 5), y=figures.rounded(entry["mean"], 5), mode="lines+markers",
                           error_y=dict(type="data", array=entry["sigma"]), line=dict(color=color), name=name)
    figure.update_xaxes(title=f'{before["against"]} [{before["unit"]}]')
    figure.update_yaxes(title="mean residual [sigma]")
    return figures.styled(figure, 300)


def causes(data):
    before, after = data.get("causes_before") or [], data.get("causes_after") or []
    if not before:
        return section("Residual against its cause", note("No residual follows anything beyond what noise does."))
    parts = []
    for k, entry in enumerate(before[:4]):
        left = after[k] if k < len(after) else None
        parts += [note(f"{entry['sensor']} {entry['axis']} against {entry['against']}"), attempt(cause_figure, entry, left)]
    return section("Residual against its cause", *parts, note("Means of eight bins of equal size, with their sigma."))


def listed(title, entries):
    rows = [(e["name"], e["why"]) for e in entries or []]
    return section(title, table(("effect", "why"), rows)) if rows else ""


def faults(diagnosis):
    rows = [(f["kind"], f["sensor"], words.plain(f["count"]), f["words"]) for f in diagnosis.get("faults") or []]
    return section("Faults of the data", table(("fault", "sensor", "count", "what it is"), rows)) if rows else ""


def scores(diagnosis):
    rows = [(s["name"], words.plain(s["statistic"]) if s["dof"] else "cannot tell", words.plain(s["dof"]), f'{s["log10_p"]:.1f}')
            for s in diagnosis.get("scores") or []]
    remark = note("Each effect by itself, before any was added. A large value may be the likeness of another effect.")
    return section("Score statistics", table(("effect", "statistic", "dof", "log10 p"), rows), remark) if rows else ""


def render(name, diagnosis, data, twin):
    return document(
        name, heading(f"segcal diagnose: {name}"),
        headline(diagnosis),
        faults(diagnosis),
        effects(diagnosis),
        drawn("The gap", gap_figure, diagnosis, gap_table(diagnosis)),
        drawn("Worst windows: mean image residual, simulated minus measured", worst_windows, data),
        drawn("Worst track, error ten times as large", track, data),
        drawn("Worst window: whitened IMU residuals", imu_windows, data),
        causes(data),
        twin_page.twin_section(twin),
        listed("Rejected", diagnosis.get("rejected")),
        listed("Cannot tell from this motion", diagnosis.get("cannot_tell")),
        scores(diagnosis))
