"""The page of a replay: what happened, the calibration, where it comes from, what contradicts it."""

import figures
import health
import history
import image_figures
import words
from page import Html, attempt, chip, document, drawn, figure, heading, headline, joined, note, section, table

LONG_TABLE = 40  # segments: three minutes; a longer table scrolls


def parameter_row(parameter):
    value, sigma, initial = (parameter.get(k) for k in ("value", "sigma", "initial"))
    both = words.is_number(value) and words.is_number(initial)
    change = words.with_digits_of(value - initial, sigma) if both else "–"
    digits = words.with_digits_of(sigma, sigma)
    unit = parameter.get("unit") if parameter.get("unit") != "-" else ""
    return (parameter["name"], chip(parameter.get("verdict", "–")), f"{words.with_digits_of(value, sigma)} ± {digits} {unit}",
            words.with_digits_of(initial, sigma), change)


def calibration(result):
    header = ("parameter", "", "value ± sigma", "initial", "change")
    legend = ("observed: the data tell it and it is released. weak: the data tell little, its sigma misses the target. "
              "fixed: the data cannot tell it, it stays where it was.")
    if not result["parameters"]:
        return section("Calibration", note("None ran: no segment was kept."))
    return section("Calibration", table(header, map(parameter_row, result["parameters"])), note(legend))


def over_time(result, lines):
    """One panel per block of theta."""
    try:
        panels = [joined(Html("<div><h3>"), block, Html("</h3>"), figure(drawing), Html("</div>")) for block, drawing in history.panels(result, lines)]
    except figures.Missing as reason:
        return section("Theta over calibrations", note(f"No figure: {reason}"))
    course = (result.get("course") or {}).get("words") or ""
    remark = (f"Less the start; {'sessions and what is known now' if len(result.get('history') or []) > 1 else 'one calibration after the other'}. Bars: one sigma. "
              "Point at a value to see where it is from.")
    return section("Theta over calibrations", joined(Html('<div class="panels">'), *panels, Html("</div>")), note(remark), note(course[:1].upper() + course[1:]) if course else "")


def unobservable(result):
    entries = result.get("unobservable") or []
    if not entries:
        return section("Directions without information", note("None: the motion excited every direction."))
    if len(entries) >= len(result["parameters"]):
        return section("Directions without information", note("All of them: the motion excited nothing."))
    rows = [(words.direction(e), words.plain(e.get("sigma"))) for e in entries]
    return section("Directions without information", table(("direction", "sigma [prior sigmas]"), rows), note("1: nothing learned."))


def alignment_remark(data):
    return note("The truth is turned about the vertical and moved onto the path.") if data.get("truth") else ""


def residual_remark(data):
    try:
        shares = figures.outside_three_sigma(data)
    except (AttributeError, TypeError, ValueError):
        return ""
    rows = [(name, words.plain(count), f"{rms:.3f}", f"{100 * share:.2f} %")
            for name, (share, rms, count) in shares.items()]
    if not rows:
        return ""
    return joined(table(("sensor", "residuals", "rms [sigma]", "beyond 3 sigma"), rows),
                  note("Noise as stated gives an rms of 1 and 0.27 % beyond 3 sigma."))


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
    rows = [(LABELS.get(name, name), words.plain(value)) for name, value in values.items()]
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
        return (str(index), kept, *seconds, *cells)

    header = ("segment", "", "start [s]", "end [s]", "session", "keyframes", "landmarks", "A [-]", "D [-]", "E [-]", "rank")
    return section("Segments", table(header, [row(i, e) for i, e in enumerate(entries)], "tall" if len(entries) > LONG_TABLE else ""),
                   note("Time since the first segment. A, D and E: lower is better."))


def counters(counts):
    """All that was counted, the usual things too."""
    rows = [(name.replace("_", " "), words.plain(count)) for name, count in counts.items() if count]
    return section("Counters", table((), rows) if rows else note("The data hold none."))


def told(result, data):
    names = [str(p["name"]) for p in result["parameters"]]
    return drawn("What each segment told of each parameter", lambda of: history.told(of, names), data,
                 note("From the segment and the prior alone. Triangles: segments that the calibration is made from."))


def residual_fields(data):
    try:
        cameras = image_figures.cameras_of(data)
    except (figures.Missing, AttributeError, TypeError, ValueError) as reason:
        return section("Residuals over the image", note(f"No figure: {reason}"))
    parts = []
    for camera in cameras:
        parts += [Html(f"<h3>cam{camera}</h3>")] if len(cameras) > 1 else []
        drawing = attempt(image_figures.residual_field, data, camera)
        parts += [drawing, note(image_figures.field_sentence(data, camera))] if "plotly" in drawing else [drawing]
    return section("Residuals over the image", *parts)


def track_drift(result, data):
    return drawn("Drift along tracks", lambda of: image_figures.track_drift(of, result.get("noise") or {}), data,
                 note("Between two points of a track, per axis. Flat: white noise. Rising: the tracker drifts; segcal replay weighs corners by that where "
                      "nobody states their noise. Fitting landmarks and poses takes part of it away, the more the longer the lag."))


def render(name, result, data, lines):
    status = result["status"] if result["status"] in words.STATUS_WORDS else "failed"
    counts = data.get("faults") or result.get("faults") or {}
    return document(
        name, heading(f"segcal: {name}"), note(health.origin(result)),
        headline(status, *health.sentences(result, counts)),
        calibration(result),
        unobservable(result),
        over_time(result, lines),
        told(result, data),
        drawn("Metric of each segment", figures.metrics, data, note("Lower is better. One mark per segment.")),
        residual_fields(data),
        track_drift(result, data),
        drawn("Camera residuals against 3 sigma", figures.camera_residuals, data),
        drawn("IMU residuals against 3 sigma", figures.imu_residuals, data, residual_remark(data)),
        drawn("Path, seen from above", figures.top_view, data, alignment_remark(data)),
        drawn("Path in space", figures.view_3d, data),
        drawn("Biases", figures.biases, data),
        segments(result),
        Html('<div class="tables">'), pairs("Fit", result.get("fit")), pairs("Timing", result.get("timing")),
        pairs("Memory", result.get("memory")), counters(counts), Html("</div>"))
