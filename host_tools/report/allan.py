"""The page of `segcal allan`: deviation against averaging time, and what was fitted to it."""

import math

import figures
import plotly.graph_objects as go
from page import document, heading, note, section, table
from page import figure as embedded

SENSORS = (("gyro", "Gyroscope", "rad/s"), ("accel", "Accelerometer", "m/s²"))


def fitted(axis, tau):
    return math.sqrt(axis["density"] ** 2 / tau + axis["instability"] ** 2 * 2 * math.log(2) / math.pi + (axis["walk"] if axis["walk_seen"] else 0.0) ** 2 * tau / 3)


def figure(sensor, unit):
    drawing = go.Figure()
    taus = [point[0] for point in sensor["points"]]
    for i, (name, colour) in enumerate(zip("xyz", ("#1f77b4", "#d95f02", "#2a9d4a"))):
        drawing.add_scatter(x=taus, y=[point[1 + i] for point in sensor["points"]], mode="markers", name=name, marker=dict(color=colour, size=6))
        drawing.add_scatter(x=taus, y=[fitted(sensor["axes"][i], tau) for tau in taus], mode="lines", name=f"{name}, fitted", line=dict(color=colour, width=1))
    drawing.update_xaxes(type="log", title="averaging time [s]")
    drawing.update_yaxes(type="log", title=f"Allan deviation [{unit}]")
    return figures.styled(drawing, 420)


def rows(sensor, unit):
    for name, axis in zip("xyz", sensor["axes"]):
        walk = f"{axis['walk']:.3g}" if axis["walk_seen"] else f"below {axis['walk']:.3g}"
        yield name, f"{axis['density']:.4g} {unit}/√Hz", f"{axis['instability']:.3g} {unit}", f"{walk} {unit}/s/√Hz"


def render(name, data):
    parts = [note(f"Longest rest: {data['rest_s']:.1f} s from {data['start_s']:.1f} s on, {data['rate_hz']:.1f} Hz. Lines: N²/τ + B² 2 ln2/π + K² τ/3.")]
    header = ("axis", "noise density N", "bias instability B", "bias walk K")
    for key, title, unit in SENSORS:
        parts.append(section(title, embedded(figure(data[key], unit)), table(header, rows(data[key], unit))))
    return document(name, heading(f"segcal allan: {name}"), *parts)
