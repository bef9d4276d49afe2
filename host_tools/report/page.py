"""The page: a headline, tables and figures in one column, everything inside one file."""

from html import escape

from plotly.offline import get_plotlyjs

import figures
import words

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 0.8rem; color: #212529; background: #fff;
       font: 16px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.35rem; margin: 0.2rem 0 0.6rem; overflow-wrap: anywhere; }
h2 { font-size: 1.1rem; margin: 2rem 0 0.4rem; border-bottom: 1px solid #dee2e6; padding-bottom: 0.2rem; }
p { margin: 0.4rem 0; }
.cause { font-weight: 600; }
.headline { font-size: 1.1rem; padding: 0.7rem 0.9rem; border-radius: 0.5rem; border-left: 0.4rem solid; }
.calibrated { background: #ebfbee; border-color: #2b8a3e; }
.insufficient { background: #fff9db; border-color: #e67700; }
.failed { background: #fff5f5; border-color: #c92a2a; }
.note { color: #495057; font-size: 0.92rem; }
.scroll { overflow-x: auto; -webkit-overflow-scrolling: touch; }
.tall { max-height: 26rem; overflow-y: auto; }
table { border-collapse: collapse; font-size: 0.92rem; white-space: nowrap; }
th, td { padding: 0.25rem 0.7rem 0.25rem 0; text-align: right; border-bottom: 1px solid #f1f3f5; }
th { color: #495057; font-weight: 600; border-bottom: 1px solid #ced4da; position: sticky; top: 0; background: #fff; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: #fff; }
td { font-variant-numeric: tabular-nums; }
.chip { padding: 0.05rem 0.5rem; border-radius: 1rem; font-size: 0.85rem; }
.observed { background: #d3f9d8; color: #1b5e20; }
.weak { background: #fff3bf; color: #7a4a00; }
.fixed { background: #e9ecef; color: #495057; }
.tables { display: flex; flex-wrap: wrap; gap: 0 2.5rem; }
"""


def table(header, rows, css="scroll"):
    """`rows` hold HTML; the caller escapes what is not."""
    head = "".join(f"<th>{escape(h)}</th>" for h in header)
    head = f"<thead><tr>{head}</tr></thead>" if header else ""
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return f'<div class="{css}"><table>{head}<tbody>{body}</tbody></table></div>'


def section(title, *content):
    return f"<section><h2>{escape(title)}</h2>{''.join(content)}</section>"


def note(text):
    return f'<p class="note">{escape(text)}</p>'


def chip(text, color=None):
    """A coloured word; verdicts have the colour of their own name."""
    known = color or (text if text in ("observed", "weak", "fixed") else "fixed")
    return f'<span class="chip {known}">{escape(str(text))}</span>'


def parameter_row(parameter):
    value, sigma, initial = (parameter.get(k) for k in ("value", "sigma", "initial"))
    both = words.is_number(value) and words.is_number(initial)
    change = words.with_digits_of(value - initial, sigma) if both else "–"
    digits = words.with_digits_of(sigma, sigma)
    return (escape(parameter["name"]), chip(parameter.get("verdict", "–")),
            f"{words.with_digits_of(value, sigma)} ± {digits}", escape(parameter.get("unit") or "–"),
            words.with_digits_of(initial, sigma), change)


def calibration(result):
    header = ("parameter", "verdict", "value ± sigma", "unit", "initial", "change")
    legend = ("observed: the data tell it and it is released. weak: the data tell little, its sigma misses the target. "
              "fixed: the data cannot tell it, it stays where it was.")
    return section("Calibration", table(header, map(parameter_row, result["parameters"])), note(legend))


def unobservable(result):
    entries = result.get("unobservable") or []
    if not entries:
        return section("Directions without information", note("None: the motion excited every direction."))
    rows = [(escape(words.direction(e)), "not excited", words.plain(e.get("sigma"))) for e in entries]
    return section("Directions without information", table(("direction", "verdict", "sigma [prior sigmas]"), rows))


# The button that offers to upload a chart goes: the page must not reach for the network.
FIGURE_CONFIG = {"responsive": True, "displaylogo": False, "scrollZoom": False,
                 "modeBarButtonsToRemove": ["sendChartToCloud", "lasso2d", "select2d", "zoomIn2d", "zoomOut2d",
                                            "autoScale2d", "tableRotation", "resetCameraLastSave3d"]}


def drawn(title, build, data, *remarks):
    """The figure, or a sentence that says why there is none."""
    try:
        figure = build(data)
    except figures.Missing as reason:
        return section(title, note(f"No figure: {reason}"))
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        return section(title, note(f"No figure: the data have an unexpected form ({error})."))
    return section(title, figure.to_html(full_html=False, include_plotlyjs=False, config=FIGURE_CONFIG), *remarks)


def alignment_remark(data):
    return note("The truth is turned about the vertical and moved onto the path.") if data.get("truth") else ""


def residual_remark(data):
    try:
        shares = figures.outside_three_sigma(data)
    except (AttributeError, TypeError, ValueError):
        return ""
    rows = [(escape(name), words.plain(count), f"{rms:.3f}", f"{100 * share:.2f} %")
            for name, (share, rms, count) in shares.items()]
    if not rows:
        return ""
    return table(("sensor", "residuals", "rms [sigma]", "beyond 3 sigma"), rows) + note(
        "Noise as stated gives an rms of 1 and 0.27 % beyond 3 sigma.")


LABELS = {
    "chi2": "chi² [-]", "dof": "degrees of freedom", "iterations": "iterations",
    "reprojection_rms_px": "reprojection rms [px]",
    "reprojection_median_px": "reprojection median [px]", "noise_scale": "noise found / stated [-]",
    "image_points": "image points", "vio_ms_median": "VIO per frame, median [ms]",
    "vio_ms_p95": "VIO per frame, 95 % [ms]", "score_ms_median": "score of a segment, median [ms]",
    "calibrate_ms": "calibration [ms]", "state_bytes": "state [bytes]", "segment_bytes": "one segment [bytes]",
    "workspace_bytes": "workspace [bytes]",
}


def pairs(title, values):
    if not isinstance(values, dict) or not values:
        return section(title, note("Not in the result."))
    rows = [(escape(LABELS.get(name, name)), escape(words.plain(value))) for name, value in values.items()]
    return section(title, table((), rows))


def segments(result):
    entries = result.get("segments") or []
    if not entries:
        return section("Segments", note("Not in the result."))
    first = min(e.get("start_ns", 0) for e in entries)

    def row(index, e):
        seconds = [f"{(e.get(k, first) - first) * 1e-9:.1f}" for k in ("start_ns", "end_ns")]
        cells = [words.plain(e.get(k)) for k in ("session", "keyframes", "landmarks", "A", "D", "E", "rank")]
        kept = chip("kept", "observed") if e.get("kept") else ""
        return (str(index), kept, *seconds, *map(escape, cells))

    header = ("segment", "", "start [s]", "end [s]", "session", "keyframes", "landmarks", "A [-]", "D [-]", "E [-]", "rank")
    return section("Segments", table(header, [row(i, e) for i, e in enumerate(entries)], "scroll tall"),
                   note("Time since the first segment. A, D and E: lower is better."))


def faults(data, result):
    counts = data.get("faults") or result.get("faults")
    if not isinstance(counts, dict):
        return section("Data and faults", note("The data hold no counts of faults."))
    found = {k: v for k, v in counts.items() if v}
    if not found:
        return section("Data and faults", note("No faults found."))
    rows = [(escape(name.replace("_", " ")), escape(words.plain(count))) for name, count in found.items()]
    return section("Data and faults", table(("what", "count"), rows))


def cause_and_suspects(result):
    """Why there is no calibration, and what else may be wrong: first of all that a reader sees."""
    cause = result.get("cause") or ""
    parts = [f'<p class="cause">{escape(cause)}</p>'] if cause else []
    for suspect in (result.get("health") or {}).get("suspects") or []:
        text = suspect.get("words") or suspect.get("name") or ""
        if text and text not in cause:
            parts.append(note("Suspect: " + text))
    return "\n".join(parts)


def body(name, result, data):
    status = result["status"] if result["status"] in words.STATUS_WORDS else "failed"
    return "\n".join([
        f"<h1>segcal: {escape(name)}</h1>",
        f'<p class="headline {status}">{escape(words.headline(result))}</p>',
        cause_and_suspects(result),
        calibration(result),
        unobservable(result),
        drawn("Path, seen from above", figures.top_view, data, alignment_remark(data)),
        drawn("Path in space", figures.view_3d, data),
        drawn("Metric of each segment", figures.metrics, data, note("Lower is better. One bar per segment.")),
        drawn("Camera residuals against 3 sigma", figures.camera_residuals, data),
        drawn("IMU residuals against 3 sigma", figures.imu_residuals, data, residual_remark(data)),
        drawn("Biases", figures.biases, data),
        segments(result),
        f'<div class="tables">{pairs("Fit", result.get("fit"))}{pairs("Timing", result.get("timing"))}'
        f'{pairs("Memory", result.get("memory"))}{faults(data, result)}</div>',
    ])


def document(name, content):
    """The whole page; plotly.js is inside once, nothing is fetched from elsewhere."""
    return ("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            f"<title>segcal: {escape(name)}</title>\n<style>{STYLE}</style>\n"
            f"<script>{get_plotlyjs()}</script>\n</head>\n<body>\n{content}\n</body>\n</html>\n")


def render(name, result, data):
    return document(name, body(name, result, data))
