"""Theta over calibrations, and what each segment told of it."""

import json

import numpy as np
import plotly.graph_objects as go

import figures
import words
from figures import Missing, member, styled

LINES = ["#1864ab", "#e67700", "#862e9c", "#2b8a3e"]


def block_of(name):
    """Parameters that are drawn together: cam0.r_CI, gyro.s, ..."""
    sensor, _, rest = name.partition(".")
    if "_" in rest:
        return f"{sensor}.{rest.rpartition('.')[0]}"
    if rest[:1] in "fc":
        return f"{sensor}.{'fx, fy' if rest[:1] == 'f' else 'cx, cy'}"
    return f"{sensor}.{rest[:1]}" if sensor in ("gyro", "accel") else f"{sensor}.distortion"


def blocks(names):
    out = {}
    for name in names:
        out.setdefault(block_of(name), []).append(name)
    return out


def parse_lines(text):
    """calibration.jsonl: those lines that hold a calibration with parameters. ValueError: one is no JSON."""
    lines = [json.loads(line) for line in text.splitlines() if line.strip()]
    return [line for line in lines if isinstance(line, dict) and isinstance(line.get("parameters"), list) and line["parameters"]]


def entries(result, lines):
    """[({name: (value, sigma)}, label)] over time: what single sessions said and what is known now, where the device remembers several; else its
    epochs, where there are several; else its calibrations."""
    names = [p["name"] for p in result["parameters"]]
    for key, label in (("history", session_label), ("epochs", epoch_label)):
        told = result.get(key) or []
        if len(told) > 1:
            now = [(values(result["parameters"]), "all that is known now")] if key == "history" else []
            return [(dict(zip(names, zip(e["value"], e["sigma"]))), label(e)) for e in told] + now
    return [(values(line["parameters"]), f"calibration {i + 1}") for i, line in enumerate(lines)]


def session_label(entry):
    """Sessions count from one in words."""
    return f"session {entry['session'] + 1}, {entry['segments']} segments, {entry['temperature_degC']:.1f} degC, after {entry['changes_before']} changes"


def epoch_label(entry):
    return f"sessions {entry['first_session'] + 1} to {entry['last_session'] + 1}, {entry['segments']} segments"


def values(parameters):
    return {p["name"]: (p["value"], p["sigma"]) for p in parameters if words.is_number(p.get("value")) and words.is_number(p.get("sigma"))}


def panel(names, points, unit, initial):
    """One block over all entries: values less the start, with their sigmas."""
    drawing = go.Figure()
    for color, name in zip(LINES, names):
        known = [(i + 1, *of[name], label) for i, (of, label) in enumerate(points) if name in of]
        drawing.add_scatter(x=[k[0] for k in known], y=[k[1] - initial.get(name, 0.0) for k in known], mode="lines+markers",
                            name=name.rpartition(".")[2], line=dict(color=color, width=1.3), marker=dict(size=5),
                            error_y=dict(type="data", array=[k[2] for k in known], width=3), text=[k[3] for k in known])
    drawing.update_xaxes(dtick=max(1, len(points) // 6))
    drawing.update_yaxes(title=f"change [{unit}]", exponentformat="e", nticks=6)
    return styled(drawing, 250)


def panels(result, lines):
    """(title, figure) of each block. Missing where there is one calibration only."""
    points = entries(result, lines)
    if len(points) < 2:
        raise Missing("one calibration ran; its values are in the table above.")
    parameters = {p["name"]: p for p in result["parameters"]}
    initial = {n: p["initial"] for n, p in parameters.items() if words.is_number(p.get("initial"))}
    for block, names in blocks(parameters).items():
        yield block, panel(names, points, parameters[names[0]].get("unit") or "-", initial)


def told(data, names):
    """Bits that each segment told of each parameter, over time."""
    segments = [s for s in member(data, "segments") if s.get("told_bits")]
    if not segments:
        raise Missing("the segments do not say what they told.")
    bits = figures.numbers([s["told_bits"] for s in segments], len(names), "told_bits").T
    labels = [f"{s['start_s']:.1f} to {s['end_s']:.1f} s{', kept' if s.get('kept') else ''}" for s in segments]
    drawing = go.Figure(go.Heatmap(
        z=np.round(bits, 2), y=names, zmin=0, zmax=float(np.nanmax(bits)), colorscale="Blues", customdata=np.tile(labels, (len(names), 1)),
        hovertemplate="%{y}, %{customdata}<br>%{z:.2f} bits<extra></extra>",
        colorbar=dict(orientation="h", y=1.02, yanchor="bottom", thickness=12, title=dict(text="bits; each halves the prior's sigma", side="top"))))
    kept = [i for i, s in enumerate(segments) if s.get("kept")]
    drawing.add_scatter(x=kept, y=[names[0]] * len(kept), mode="markers", showlegend=False, hoverinfo="skip", cliponaxis=False,
                        marker=dict(symbol="triangle-down", size=9, color=figures.KEPT, line=dict(color="#fff", width=1)))
    figures.segment_axis(drawing, segments)
    drawing.update_yaxes(autorange="reversed", tickmode="linear", tickfont=dict(size=11))
    styled(drawing, 170 + 17 * len(names))
    drawing.update_layout(margin=dict(t=90))
    return drawing
