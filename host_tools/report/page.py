"""What all pages share: one column, tables that become cards on a phone, figures, everything inside one file.

Text is escaped here, once: what is HTML says so by its type, Html."""

from html import escape

from plotly.offline import get_plotlyjs

import figures

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 0.8rem; color: #212529; background: #fff;
       font: 16px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.35rem; margin: 0.2rem 0 0.3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.1rem; margin: 2rem 0 0.4rem; border-bottom: 1px solid #dee2e6; padding-bottom: 0.2rem; }
h3 { font-size: 1rem; margin: 0.8rem 0 0; overflow-wrap: anywhere; }
p, li { margin: 0.4rem 0; overflow-wrap: anywhere; }
ul { margin: 0.4rem 0; padding-left: 1.2rem; }
.headline { font-size: 1.1rem; padding: 0.7rem 0.9rem; border-radius: 0.5rem; border-left: 0.4rem solid; }
.headline p, .headline li { font-size: 1rem; }
.headline p.first { font-size: 1.1rem; font-weight: 600; margin-top: 0; }
.calibrated { background: #ebfbee; border-color: #2b8a3e; }
.insufficient { background: #fff9db; border-color: #e67700; }
.failed { background: #fff5f5; border-color: #c92a2a; }
.note { color: #495057; font-size: 0.92rem; }
.tall { max-height: 30rem; overflow-y: auto; }
table { border-collapse: collapse; font-size: 0.92rem; }
th, td { padding: 0.25rem 0.7rem 0.25rem 0; text-align: right; border-bottom: 1px solid #f1f3f5; vertical-align: top; white-space: nowrap; }
th { color: #495057; font-weight: 600; border-bottom: 1px solid #ced4da; position: sticky; top: 0; background: #fff; white-space: normal; }
th:first-child, td:first-child, th.text, td.text { text-align: left; }
td.text { white-space: normal; overflow-wrap: anywhere; }
td { font-variant-numeric: tabular-nums; }
.chip { padding: 0.05rem 0.5rem; border-radius: 1rem; font-size: 0.85rem; }
.observed { background: #d3f9d8; color: #1b5e20; }
.weak { background: #fff3bf; color: #7a4a00; }
.fixed { background: #e9ecef; color: #495057; }
.tables, .panels { display: grid; gap: 0 2rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr)); }
.tables > *, .panels > * { min-width: 0; }
@media (max-width: 40rem) {
  table.wide, .wide tbody { display: block; }
  .wide thead { display: none; }
  .wide tr { display: flex; flex-wrap: wrap; gap: 0 0.8rem; padding: 0.35rem 0; border-bottom: 1px solid #e9ecef; }
  .wide td { border: 0; padding: 0; text-align: left; white-space: normal; overflow-wrap: anywhere; }
  .wide td:first-child { font-weight: 600; }
  .wide td:empty { display: none; }
  .wide td[data-label]::before { content: attr(data-label) " "; color: #6c757d; font-weight: 400; }
  th, td { white-space: normal; overflow-wrap: anywhere; }
}
@media print {
  body { max-width: none; padding: 0; font-size: 11pt; }
  .tall { max-height: none; overflow: visible; }
  tr, .js-plotly-plot, .headline { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
  table { font-size: 8.5pt; }
  th, td { padding-right: 0.45rem; }
  th { position: static; }
  .modebar-container { display: none; }
}
"""

# Figures are as wide as the window; on paper, as wide as a page of A4 between the margins that browsers give it.
PRINTING = """
addEventListener("beforeprint", () => document.querySelectorAll(".js-plotly-plot").forEach(
  f => Plotly.relayout(f, {width: Math.min(f.clientWidth, f.closest(".panels") ? 330 : 690), autosize: false})));
addEventListener("afterprint", () => document.querySelectorAll(".js-plotly-plot").forEach(
  f => Plotly.relayout(f, {width: null, autosize: true})));
"""

LONG_TEXT = 34     # characters: a cell with more is a sentence, which may wrap
NARROW_COLUMNS = 3 # as many fit on a phone

# The button that offers to upload a chart goes: the page must not reach for the network.
FIGURE_CONFIG = {"responsive": True, "displaylogo": False, "scrollZoom": False,
                 "modeBarButtonsToRemove": ["sendChartToCloud", "lasso2d", "select2d", "zoomIn2d", "zoomOut2d",
                                            "autoScale2d", "tableRotation", "resetCameraLastSave3d"]}


class Html(str):
    """Text that is HTML already."""


class Sentence(str):
    """Text for a cell that wraps and begins at the left, however short."""


def safe(content):
    return content if isinstance(content, Html) else Html(escape(str(content)))


def table_cell(content, label):
    css = ' class="text"' if isinstance(content, Sentence) or (len(content) > LONG_TEXT and not isinstance(content, Html)) else ""
    label = f' data-label="{escape(label)}"' if label else ""
    return f"<td{css}{label}>{safe(content)}</td>"


def table(header, rows, css=""):
    """Cells are text, or Html. The first column names the row."""
    labels = ["", *("" if "±" in h else h for h in header[1:])] if header else None  # a value needs no name
    rows = [list(row) for row in rows]
    sentences = {i for row in rows for i, cell in enumerate(row) if isinstance(cell, Sentence)}
    head = "".join(f'<th class="text">{escape(h)}</th>' if i in sentences else f"<th>{escape(h)}</th>" for i, h in enumerate(header))
    head = f"<thead><tr>{head}</tr></thead>" if header else ""
    body = "".join("<tr>" + "".join(table_cell(c, labels[i] if labels else "") for i, c in enumerate(row)) + "</tr>" for row in rows)
    wide = ' class="wide"' if len(header) > NARROW_COLUMNS else ""
    return Html(f'<div class="{css}"><table{wide}>{head}<tbody>{body}</tbody></table></div>')


def heading(text):
    return Html(f"<h1>{escape(text)}</h1>")


def joined(*parts):
    return Html("".join(map(safe, parts)))


def section(title, *content):
    return Html(f"<section><h2>{escape(title)}</h2>{joined(*content)}</section>")


def note(text):
    return Html(f'<p class="note">{escape(text)}</p>')


def headline(status, *sentences):
    """The box that a reader sees first: one sentence, then what else there is to say."""
    first, *others = map(escape, sentences)
    more = f"<ul>{''.join(f'<li>{s}</li>' for s in others)}</ul>" if others else ""
    return Html(f'<div class="headline {escape(status)}"><p class="first">{first}</p>{more}</div>')


def chip(text, color=None):
    """A coloured word; verdicts have the colour of their own name."""
    known = color or (text if text in ("observed", "weak", "fixed") else "fixed")
    return Html(f'<span class="chip {known}">{escape(str(text))}</span>')


def figure(drawing):
    return Html(drawing.to_html(full_html=False, include_plotlyjs=False, config=FIGURE_CONFIG))


def attempt(build, *data):
    """The figure, or a sentence that says why there is none."""
    try:
        return figure(build(*data))
    except figures.Missing as reason:
        return note(f"No figure: {reason}")
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        return note(f"No figure: the data have an unexpected form ({error}).")


def drawn(title, build, data, *remarks):
    content = attempt(build, data)
    return section(title, content, *(remarks if "js-plotly" in content or "plotly-graph-div" in content else ()))


def document(name, *content):
    """The whole page; plotly.js is inside once, nothing is fetched from elsewhere."""
    return ("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n"
            f"<title>segcal: {escape(name)}</title>\n<style>{STYLE}</style>\n"
            f"<script>{get_plotlyjs()}</script>\n<script>{PRINTING}</script>\n</head>\n<body>\n" + "\n".join(map(safe, content)) +
            "\n</body>\n</html>\n")
