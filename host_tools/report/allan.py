"""Writes DIR/allan.html from the allan.json that `segcal allan --out DIR` left there. Usage: allan.py DIR."""

import math
import sys
from html import escape
from pathlib import Path

from report import InputError, read_json, write_whole

SENSORS = (("gyro", "Gyroscope", "rad/s"), ("accel", "Accelerometer", "m/s²"))


def fitted(axis, tau):
    return math.sqrt(axis["density"] ** 2 / tau + axis["instability"] ** 2 * 2 * math.log(2) / math.pi + (axis["walk"] if axis["walk_seen"] else 0.0) ** 2 * tau / 3)


def figure(sensor, unit):
    import figures
    import plotly.graph_objects as go

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
    import page

    parts = [page.note(f"Longest rest: {data['rest_s']:.1f} s from {data['start_s']:.1f} s on, {data['rate_hz']:.1f} Hz. Lines: N²/τ + B² 2 ln2/π + K² τ/3.")]
    for key, title, unit in SENSORS:
        parts.append(page.section(title, figure(data[key], unit).to_html(full_html=False, include_plotlyjs=False, config=page.FIGURE_CONFIG),
                                  page.table(("axis", "noise density N", "bias instability B", "bias walk K"), [tuple(map(escape, r)) for r in rows(data[key], unit)])))
    return page.document(name, "\n".join(parts))


def main(arguments):
    folder = Path(arguments[0])
    data = read_json(folder / "allan.json", required=True)
    try:
        text = render(folder.resolve().name, data)
    except ImportError as error:
        raise InputError(f"the Python package '{error.name}' is missing; host_tools/setup.sh installs it") from None
    write_whole(folder / "allan.html", text)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print(f"segcal: {error}", file=sys.stderr)
        sys.exit(2)
