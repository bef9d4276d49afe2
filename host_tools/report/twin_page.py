"""How near a simulation of the same motion comes to the measurement, without and with what a diagnosis found."""

import textwrap

import figures
import plotly.graph_objects as go
from page import attempt, note, section, table

BEFORE, AFTER, MEASURED = "#d9480f", "#1864ab", "#212529"


def twin_figure(twin):
    """Where the simulation with the effects stands, between the one without (0) and the measurement (1)."""
    shown = [s for s in twin.get("statistics") or [] if s.get("left") is not None]
    if not shown:
        raise figures.Missing("without the effects the simulation is as the measurement already, within chance")
    names = ["<br>".join(textwrap.wrap(s["name"], 34)) for s in shown]
    span = [s["measured"] - s["without"] for s in shown]
    figure = go.Figure()
    figure.add_scatter(x=[0] * len(shown), y=names, mode="markers", name="simulated without", marker=dict(color=BEFORE, size=9))
    figure.add_scatter(x=[(s["with"] - s["without"]) / d for s, d in zip(shown, span)], y=names, mode="markers", name="simulated with",
                       marker=dict(color=AFTER, size=11, symbol="diamond"))
    figure.add_scatter(x=[1] * len(shown), y=names, mode="markers", name="measured", marker=dict(color=MEASURED, size=9, symbol="square"),
                       error_x=dict(type="data", array=[abs(2 * s["sigma"] / d) for s, d in zip(shown, span)], thickness=1.2))
    figure.update_xaxes(title="0: simulated without, 1: measured")
    figure.update_yaxes(autorange="reversed")
    return figures.styled(figure, 130 + 34 * len(shown))


def twin_section(twin):
    """The simulation beside the measurement, where `segcal diagnose --twin` made one."""
    if not twin:
        return ""
    title = "The simulated twin"
    if twin.get("why_not"):
        return section(title, note(f'None was made: {twin["why_not"]}.'))
    rows = [(s["name"] + ("" if s["unit"] == "-" else f' [{s["unit"]}]'), f'{s["measured"]:.4g}', f'{s["sigma"]:.2g}', f'{s["without"]:.4g}', f'{s["with"]:.4g}',
             "as it was" if s.get("left") is None else f'{100 * s["left"]:.0f} ± {100 * s["left_sigma"]:.0f} %') for s in twin.get("statistics") or []]
    header = ("statistic", "measured", "chance", "simulated without", "simulated with", "difference left")
    what = (f'{twin.get("seconds", 0):.0f} s of the same motion and corners, in a simulator that was written apart from the fit: with the stated noise and no effect, '
            f'and with {", ".join(twin.get("effects") or ["nothing"])}. As it was: the two do not differ by more than chance.')
    if twin.get("seconds", 0) < 0.8 * twin.get("recorded_s", 0):
        what += f' The measured figures are of all {twin["recorded_s"]:.0f} s of the recording: elsewhere the odometry stops or jumps.'
    missing = [note(f"Not simulated: {text}.") for text in twin.get("not_simulated") or []]
    told = [note(f'The simulation {k}, diagnosed: {twin[f"{k}_diagnosed"]}.') for k in ("without", "with") if twin.get(f"{k}_diagnosed")]
    return section(title, attempt(twin_figure, twin), table(header, rows), note(what), *missing, *told)
