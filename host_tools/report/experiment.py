"""Writes report.html beside NAME.json, which `segcal experiments NAME` left.

Usage: experiment.py DIR/NAME.json. Exit code 0 when the page is written, 2 with one line on stderr when it cannot be.
"""

import sys
from pathlib import Path

import report
import words


def cell(value):
    return words.plain(value) if value is not None else "–"


def table(entry):
    import page
    rows = [tuple(map(cell, row)) for row in entry["rows"]]
    long = "tall" if len(rows) > 24 else ""
    return page.section(entry["title"], page.note(entry["note"]) if entry["note"] else "", page.table(entry["columns"], rows, long))


def limits(entries):
    import page
    if not entries:
        return ""
    rows = [(e["what"], cell(e["value"]), f"{'≥' if e['at_least'] else '≤'} {cell(e['limit'])}",
             page.chip("met", "observed") if e["met"] else page.chip("missed", "weak")) for e in entries]
    return page.section("Limits", page.table(("what", "found", "limit", ""), rows))


def traces(entry):
    import plotly.graph_objects as go
    for series in entry["series"]:
        if entry["kind"] == "lines":
            yield go.Scatter(x=series["x"], y=series["y"], name=series["name"], mode="lines+markers")
        elif entry["kind"] == "bars":
            yield go.Bar(x=series["x"], y=series["y"], name=series["name"])
        elif entry["kind"] == "boxes":
            yield go.Box(x=series["x"], y=series["y"], name=series["name"])
        else:
            raise report.InputError(f"expected lines, bars or boxes as kind of a figure, found {entry['kind']!r}")


def figure(entry):
    import figures
    import page
    import plotly.graph_objects as go
    drawing = go.Figure(list(traces(entry)))
    drawing.update_xaxes(title=entry["x"])
    drawing.update_yaxes(title=entry["y"], type="log" if entry["log_y"] else "linear")
    if entry["kind"] == "boxes":
        drawing.update_layout(boxmode="group")
    figures.styled(drawing, 420)
    return page.section(entry["title"], page.figure(drawing))


def render(study):
    import page
    missed = sum(not e["met"] for e in study["limits"])
    verdict = f"{len(study['limits']) - missed} of {len(study['limits'])} limits met." if study["limits"] else "No limits; figures only."
    command = f"segcal experiments {study['experiment']} --seed {study['seed']}{' --quick' if study['quick'] else ''}"
    return page.document(
        study["experiment"], page.heading(f"segcal: {study['experiment']}"),
        page.note(study["description"]),
        page.headline("insufficient" if missed else "calibrated", verdict),
        page.note(command),
        limits(study["limits"]),
        *map(figure, study["figures"]),
        *map(table, study["tables"]))


def main(arguments):
    if len(arguments) != 1:
        raise report.InputError("expected one argument, the NAME.json that `segcal experiments` wrote")
    file = Path(arguments[0])
    study = report.read_json(file, required=True)
    try:
        html = render(study)
    except ImportError as error:
        raise report.InputError(f"the Python package '{error.name}' is missing; host_tools/setup.sh installs it") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise report.InputError(f"{file}: expected the layout of `segcal experiments` ({error})") from None
    report.write_whole(file.with_name("report.html"), html)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except report.InputError as error:
        print(f"segcal: {error}", file=sys.stderr)
        sys.exit(2)
