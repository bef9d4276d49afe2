"""Numbers and verdicts in words."""

import math

STATUS_WORDS = {
    "calibrated": "Calibrated",
    "insufficient": "Not enough information to calibrate",
    "failed": "Calibration failed",
}


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def with_digits_of(value, sigma):
    """`value` with as many decimals as two digits of `sigma` need."""
    if not is_number(value):
        return "–"
    if not is_number(sigma) or sigma <= 0:
        return f"{value:.6g}"
    decimals = max(0, min(9, 1 - math.floor(math.log10(sigma))))
    return f"{value:.{decimals}f}"


def plain(value):
    """A number for a table, four significant digits, more above a thousand; whole numbers grouped with thin spaces."""
    if isinstance(value, bool) or value is None:
        return "–" if value is None else ("yes" if value else "no")
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f")
    if is_number(value):
        return f"{value:.1f}" if 1e3 <= abs(value) < 1e6 else f"{value:.4g}"
    return str(value)


def chi2_per_dof(result):
    fit = result.get("fit") or {}
    if is_number(fit.get("chi2")) and is_number(fit.get("dof")) and fit["dof"] > 0:
        return fit["chi2"] / fit["dof"]
    return None


def headline(result):
    """One sentence: the status, and how much is observed."""
    status = STATUS_WORDS.get(result["status"], result["status"])
    parameters = result["parameters"]
    observed = sum(p.get("verdict") == "observed" for p in parameters)
    if result["status"] == "insufficient" and parameters and 2 * observed >= len(parameters):
        status = "Not calibrated"    # it is not for want of motion: the cause says why
    parts = [f"{status}: {observed} of {len(parameters)} parameters observed"]
    rms = (result.get("fit") or {}).get("reprojection_rms_px")
    if is_number(rms) and rms > 0:
        parts.append(f"reprojection rms {rms:.2f} px")
    return ", ".join(parts) + "."


def direction(entry):
    """"gyro.sz + 0.3 accel.mx": the largest weight first and scaled to 1, what is below 5 % of it left out."""
    weights = {n: w for n, w in (entry.get("direction") or {}).items() if is_number(w) and w != 0}
    if not weights:
        return "unnamed direction"
    ordered = sorted(weights.items(), key=lambda item: -abs(item[1]))
    largest = ordered[0][1]
    text = ordered[0][0]
    for name, weight in ordered[1:]:
        share = weight / largest
        if abs(share) >= 0.05:
            factor = f"{abs(share):.2g} " if abs(abs(share) - 1) > 0.005 else ""
            text += f" {'+' if share > 0 else '−'} {factor}{name}"
    return text
