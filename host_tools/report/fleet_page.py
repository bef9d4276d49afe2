"""The page of `segcal fleet`: what to look at and why, what changed and when, the models, and the trend of each device.

`rows` are the tables of docs/fleet.md as lists of dictionaries."""

import json
import os
from html import escape

import plotly.graph_objects as go

import figures
import history
import words
from page import FIGURE_CONFIG, Html, Sentence, chip, document, figure, heading, headline, joined, note, section, table

MOST_LOGS = 10       # to look at
MOST_PANELS = 6      # of changes; the table has all of them
MOST_MODELS = 12     # with a figure and a table of their own
MOST_DEVICES = 200   # whose trend is in the page: some 10 kB each for twenty logs
EDGE = 10            # sigmas; what lies further out is drawn at the edge
OF_DEVICES = ("change", "outlier", "misfit")
STATUSES = ("calibrated", "insufficient", "failed", "refused")

# Panels are drawn here, when a device is chosen: all panels of all devices at once would be a slow page.
SCRIPT = """
const fleet = %(data)s, layout = %(layout)s, config = %(config)s, colors = %(colors)s;
function panel(into, title, device, block) {
  const box = document.createElement("div"), head = document.createElement("h3"), div = document.createElement("div"), traces = [];
  head.textContent = title; div.className = "plotly-graph-div"; box.append(head, div); into.append(box);
  block.names.forEach((name, i) => {
    const color = colors[i %% colors.length];
    traces.push({x: device.places, y: block.values[i], text: device.logs, name, mode: "lines+markers", line: {color, width: 1.3}, marker: {size: 5},
                 error_y: {type: "data", array: block.sigmas[i], width: 3, thickness: 1}, hovertemplate: "%%{text}<br>%%{y:.4g}<extra>" + name + "</extra>"});
    traces.push({x: device.places, y: block.fused[i], mode: "lines", showlegend: false, hoverinfo: "skip", line: {color, width: 2, dash: "dash"}});
  });
  const own = structuredClone(layout);
  own.shapes = block.changed.map(x => ({type: "line", x0: x - 0.5, x1: x - 0.5, yref: "paper", y0: 0, y1: 1, line: {color: "#c92a2a", width: 1.5, dash: "dot"}}));
  own.xaxis.title = {text: "log of the device"};
  own.xaxis.dtick = Math.max(1, Math.ceil(device.places.at(-1) / 8));
  own.yaxis.title = {text: "change [" + block.unit + "]"};
  Plotly.newPlot(div, traces, own, config);
}
function trend(name) {
  const into = document.getElementById("trend"), device = fleet[name];
  into.querySelectorAll(".plotly-graph-div").forEach(Plotly.purge);
  into.replaceChildren();
  for (const block of device.blocks) panel(into, block.title, device, block);
}
addEventListener("DOMContentLoaded", () => {
  document.querySelectorAll("[data-change]").forEach(box => {
    const device = fleet[box.dataset.change], block = device && device.blocks.find(b => b.title == box.dataset.block);
    if (block) panel(box, box.dataset.change + ": " + block.title, device, block);
  });
  const chosen = document.getElementById("device");
  if (!chosen) return;
  chosen.addEventListener("change", () => trend(chosen.value));
  trend(chosen.value);
});
"""


def short(number):
    """Digits that no screen shows only make the page larger."""
    return float(f"{number:.5g}")


def below(logs):
    """{log: its path without what all have in common}."""
    common = os.path.dirname(os.path.commonpath(logs)) if len(logs) == 1 else os.path.commonpath(logs) if logs else ""
    return {log: os.path.relpath(log, common) for log in logs}


def worst_logs(attention):
    """[(log, device, kinds, sentences)] of the ten logs to look at, each once. A graver sentence may hold a lesser one."""
    found = {}
    for row in sorted(attention, key=lambda row: row["rank"]):
        _, kinds, sentences = found.setdefault(row["log"], (row["device"], [], []))
        kinds += [] if row["kind"] in kinds else [row["kind"]]
        sentences += [] if any(row["sentence"] in s for s in sentences) else [row["sentence"]]
    return [(log, *entry) for log, entry in found.items()][:MOST_LOGS]


def to_look_at(attention, names):
    worst = worst_logs(attention)
    if not worst:
        return section("Logs to look at", note("None stands out."))
    rows = [(names.get(log, log), device, joined(*(chip(k, "weak" if k in OF_DEVICES else "fixed") for k in kinds)), Sentence("; ".join(sentences)))
            for log, device, kinds, sentences in worst]
    more = len({row["log"] for row in attention}) - len(worst)
    return section("Logs to look at", table(("log", "device", "what", "why"), rows),
                   note(f"The gravest first; {more} more in attention.parquet." if more else "The gravest first. All of attention.parquet."))


def size_of(row):
    return row["rate"] if row["step"] is None else row["step"]


def size_words(row):
    return f"{row['name'].rpartition('.')[2]} {words.with_digits_of(size_of(row), row['sigma'])} ± {words.with_digits_of(row['sigma'], row['sigma'])}"


def form_words(row, names):
    first = names.get(row["from_log"], row["from_log"])
    said = {"step": f"step before {first}", "trend": f"trend since {first}"}.get(row["form"], row["form"])
    return f"{said}, or {row['or_form'].replace(', ', ' or ')}: not told apart" if row["or_form"] else said


def changes(rows, names, drawn):
    """All changes, and the trends of the surest."""
    if not rows["changes"]:
        return section("Changes", note("No device changed beyond what its logs scatter by."))
    found = {}
    for row in rows["changes"]:
        found.setdefault((row["device"], row["block"], row["form"], row["from_place"]), []).append(row)
    ordered = sorted(found.values(), key=lambda own: own[0]["log10_p"])
    cells = [(own[0]["device"], Sentence(own[0]["block"]), Sentence(form_words(own[0], names)),
              Sentence(f"{', '.join(map(size_words, own))} {(own[0]['rate_unit'] or own[0]['unit']).strip('-')}"), f"1e{own[0]['log10_p']:.0f}")
             for own in ordered]
    panels = [Html(f'<div data-change="{escape(device)}" data-block="{escape(block)}"></div>')
              for device, block in dict.fromkeys((own[0]["device"], panel_of(own)) for own in ordered) if device in drawn][:MOST_PANELS]
    return section("Changes", table(("device", "what", "form", "step or rate ± sigma", "chance"), cells),
                   joined(Html('<div class="panels">'), *panels, Html("</div>")),
                   note("Step: a fall, a repair, an exchanged part; from this log on the device has another value. Trend: it ages, linear in time. Temperature: "
                        "linear in the log's mean temperature. Chance: that a fleet without any change shows one like it."))


def panel_of(change):
    """The panel in which a change of several parameters is seen best."""
    return history.block_of(max(change, key=lambda row: abs(size_of(row) / row["sigma"]))["name"])


def statuses(runs):
    rows = []
    for model in sorted({r["model"] for r in runs}):
        own = [r for r in runs if r["model"] == model]
        counts = [sum(r["status"] == s for r in own) for s in STATUSES]
        rows.append((model, *(words.plain(n) for n in (len({r["device"] for r in own}), len(own), *counts))))
    return section("Logs", table(("model", "devices", "logs", *STATUSES), rows),
                   note("insufficient: the motion told too little, or odometry did not start. refused: the log cannot be read."))


def distances(model, devices, named):
    """How far each device is from the others of its model, by parameter."""
    own = [r for r in devices if r["model"] == model and words.is_number(r["distance_sigma"])]
    if not own:
        raise figures.Missing("fewer than five devices of this model have told the same parameter.")
    drawing = go.Figure()
    for looked_at, color, label in ((False, figures.PATH, "devices"), (True, figures.KEPT, "devices to look at")):
        mine = [r for r in own if (r["device"] in named) == looked_at]
        far = [r["distance_sigma"] for r in mine]
        drawing.add_scatter(x=[short(max(-EDGE, min(EDGE, d))) for d in far], y=[r["name"] for r in mine], mode="markers", name=label,
                            text=[f"{r['device']}: {d:+.1f}" for r, d in zip(mine, far)], hoverinfo="text+y",
                            marker=dict(color=color, size=8 if looked_at else 6, opacity=0.8, symbol=["diamond" if abs(d) > EDGE else "circle" for d in far]))
    names = list(dict.fromkeys(r["name"] for r in own))
    drawing.update_xaxes(title="distance from the others [sigma]", range=[-EDGE - 1, EDGE + 1])
    drawing.update_yaxes(categoryorder="array", categoryarray=names[::-1], tickmode="linear", tickfont=dict(size=11))
    return figures.styled(drawing, 150 + 17 * len(names))


def model_table(model, rows):
    def cell(r):
        digits = words.with_digits_of(r["mean_sigma"], r["mean_sigma"])
        unit = r["unit"] if r["unit"] != "-" else ""
        spread = words.with_digits_of(r["spread"], r["mean_sigma"])
        return r["name"], f"{words.with_digits_of(r['mean'], r['mean_sigma'])} ± {digits} {unit}", spread, words.plain(r["devices"])
    return table(("parameter", "mean ± sigma", "spread", "devices"), [cell(r) for r in rows if r["model"] == model])


def models(rows, named):
    parts, known = [], sorted({r["model"] for r in rows["models"]})
    if not known:
        return section("Models", note("No log told anything."))
    for model in known[:MOST_MODELS]:
        try:
            drawing = figure(distances(model, rows["devices"], named))
        except figures.Missing as reason:
            drawing = note(f"No figure: {reason}")
        parts += [Html("<h3>"), model, Html("</h3>"), drawing, model_table(model, rows["models"])]
    more = f" {len(known) - MOST_MODELS} more models in models.parquet." if len(known) > MOST_MODELS else ""
    return section("Spread per model", joined(*parts),
                   note(f"Spread: standard deviation between devices, without the noise of their logs. Diamonds lie beyond {EDGE} sigma. Mean and spread "
                        f"together are the next device's prior.{more}"))


def trends(rows, devices):
    """{device: what its panels show}: each log's fit less the start, with its sigma, and the fused value at each."""
    usable = {r["key"] for r in rows["runs"] if r["status"] in ("calibrated", "insufficient")}
    of_log = {(r["device"], r["place"], r["name"]): r for r in [*rows["parameters"], *rows["effects"]] if r["key"] in usable and words.is_number(r["mean"])}
    steps = {(r["device"], r["name"], r["from_place"]) for r in rows["changes"] if r["form"] == "step"}
    fused, runs, out = {}, {}, {}
    for row in rows["devices"]:
        fused.setdefault(row["device"], {})[row["name"]] = row
    for row in rows["runs"]:
        runs.setdefault(row["device"], []).append(row)
    for device in devices:
        names = list(fused[device])
        own = [r for r in runs[device] if (device, r["place"], names[0]) in of_log]
        places = [r["place"] for r in own]
        blocks = []
        for title, members in history.blocks(names).items():
            at = [fused[device][n] for n in members]
            each = [[of_log.get((device, p, n)) for p in places] for n in members]
            blocks.append({
                "title": title, "unit": at[0]["unit"], "names": [n.rpartition(".")[2] for n in members],
                "values": [[short(r["mean"] - f["initial"]) if r else None for r in line] for line, f in zip(each, at)],
                "sigmas": [[short(r["sigma"]) if r else None for r in line] for line in each],
                "fused": [[short(r["fused"] - f["initial"]) if r and r["fused"] is not None else None for r in line] for line, f in zip(each, at)],
                "changed": sorted({place for at_device, name, place in steps if at_device == device and name in members})})
        out[device] = {"places": places, "logs": [os.path.basename(r["log"]) for r in own], "blocks": blocks}
    return out


def trend_section(drawn, total):
    if not drawn:
        return section("Trend per device", note("No log told anything."))
    options = "".join(f'<option value="{escape(d)}">{escape(d)}</option>' for d in drawn)
    more = f" {total - len(drawn)} more devices in parameters.parquet." if total > len(drawn) else ""
    return section("Trend per device", Html(f'<p><label>Device: <select id="device">{options}</select></label></p><div class="panels" id="trend"></div>'),
                   note("Each log's own fit less the start, with one sigma; where a log tells nothing, it is the start with the prior's sigma. Dashed: all logs "
                        f"together, with what changed. Dotted: a step.{more}"))


def script(drawn):
    layout = figures.styled(go.Figure(), 250).to_plotly_json()["layout"]
    layout["yaxis"].update(exponentformat="e", nticks=6)
    values = {"data": drawn, "layout": json.loads(json.dumps(layout, default=lambda o: o.to_plotly_json())), "config": FIGURE_CONFIG, "colors": history.LINES}
    # A device may be called </script>.
    texts = {name: json.dumps(value, separators=(",", ":")).replace("<", "\\u003c") for name, value in values.items()}
    return Html(f"<script>{SCRIPT % texts}</script>")


def render(rows, sentences):
    """`sentences`: the summary, the first for the top."""
    runs, attention = rows["runs"], rows["attention"]
    named = list(dict.fromkeys(r["device"] for r in attention if r["kind"] in OF_DEVICES))
    usable = [r for r in runs if r["status"] in ("calibrated", "insufficient")]
    status = "failed" if not rows["devices"] else "insufficient" if named or len(usable) < len(runs) else "calibrated"
    known = dict.fromkeys(r["device"] for r in rows["devices"])
    chosen = ([d for d in named if d in known] + [d for d in known if d not in named])[:MOST_DEVICES]
    drawn, names = trends(rows, chosen), below([r["log"] for r in runs])
    return document(
        "fleet", heading("segcal: fleet"), headline(status, *sentences),
        to_look_at(attention, names),
        changes(rows, names, drawn),
        statuses(runs),
        models(rows, named),
        trend_section(drawn, len(known)),
        script(drawn))
