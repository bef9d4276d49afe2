"""The changes of fused devices, as rows of the table and as sentences."""

import numpy as np

import forms
import problem
import tables

NAMED_AS = {forms.STEP: "a step", forms.TREND: "a trend", forms.TEMPERATURE: "temperature"}


def per(unit, of):
    """rad, day: rad/day; of a number without a unit: 1/day."""
    return f"{'1' if unit == '-' else unit}/{of}"


def rows_of(d):
    """`d`: a judge.Fused."""
    rows = []
    for change in d.fit.changes:
        form, first = change.form, d.runs[change.form.first]
        size, sigma = change.size()
        for k, i in enumerate(problem.indices(d.fit.names, change.block)):
            step = form.kind == forms.STEP
            rows.append({"device": d.device, "model": d.model, "block": change.block, "form": form.kind,
                         "or_form": ", ".join(rival.kind for rival in change.rivals), "from_place": first.place, "from_log": first.log,
                         "statistic": change.statistic, "log10_p": change.log10_p, "name": d.fit.names[i], "unit": d.units[i],
                         "step": size[k] if step else None, "rate": None if step else size[k],
                         "rate_unit": None if step else per(d.units[i], form.unit), "sigma": sigma[k]})
    return rows


def largest(d, change):
    """"0.0021 rad per day (x)": the block's parameter whose rate is the surest."""
    size, sigma = change.size()
    k = int(np.argmax(np.abs(size / sigma)))
    i = problem.indices(d.fit.names, change.block)[k]
    unit = "" if d.units[i] == "-" else f" {d.units[i]}"
    return f"{size[k]:+.2g}{unit} per {change.form.unit} ({d.fit.names[i].rpartition('.')[2]})"


def sentence(d, change):
    form, block = change.form, change.block
    if change.rivals:
        both = [form, *change.rivals]
        words = " or ".join(NAMED_AS[f.kind] + (f" before {tables.last_part(d.runs[f.first].log)}" if f.kind == forms.STEP else "") for f in both)
        return f"{block} changed: {words}: the logs do not tell them apart"
    if form.kind == forms.TREND:
        return f"{block} drifts by {largest(d, change)} since {tables.last_part(d.runs[0].log)}"
    if form.kind == forms.TEMPERATURE:
        return f"{block} changes with temperature by {largest(d, change)}"
    return f"{block} changed before {tables.last_part(d.runs[form.first].log)}"


def log_of(d, change):
    """The log in which to look at it: the first after a step, else the one that lies furthest from where the device is now."""
    form = change.form
    return d.runs[form.first if form.kind == forms.STEP else int(np.argmax(np.abs(form.course)))].log
