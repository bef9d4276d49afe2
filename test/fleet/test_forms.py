"""Step, trend and dependence on temperature told apart on made-up results whose truth is known.
A failing case prints its seed:  test_forms.py SOURCE_TREE [SEED]"""

import dataclasses
import pathlib
import sys

import numpy as np
from scipy.stats import chi2

sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "host_tools" / "fleet"))
import evidence  # noqa: E402
import forms  # noqa: E402
import fusion  # noqa: E402
import problem  # noqa: E402
import search  # noqa: E402
from made_up import NAMES, drawn, result_of  # noqa: E402

SEED = int(sys.argv[2]) if len(sys.argv) > 2 else 1
DAY, DATE = 86400 * 10**9, 1_700_000_000 * 10**9  # ns
SIZES = {"cam0.r_CI": 0.04, "gyro.scale": 0.03, "cam0.focal length and centre": 15.0}  # between the ends of a course: some ten sigmas of a log


def axes(degC, days=None):
    """Of logs that are dated on these days, or not at all."""
    start = [None] * len(degC) if days is None else [DATE + round(day * DAY) for day in days]
    return forms.axes_of(start, range(len(degC)), [None if t is None else (t - 2, t + 2) for t in degC])


def logs_of(truths, random):
    return fusion.common([evidence.evidence_of(result_of(truth, random)) for truth in truths])


def truths_of(old, *courses):
    """The device at each log: (block, size, course) each, of the block's first parameter."""
    out = np.array([old] * len(courses[0][2]))
    for block, size, course in courses:
        out[:, problem.indices(NAMES, block)[0]] += size * np.asarray(course)
    return out


def told_by(count, truth, random):
    """A log as long as so many: alone it tells all directions."""
    parts = [evidence.evidence_of(result_of(truth, random)) for _ in range(count)]
    parts = [evidence.about(part, parts[0].initial) for part in parts]
    return dataclasses.replace(parts[0], R=np.vstack([p.R for p in parts]), z=np.concatenate([p.z for p in parts]))


def named(fused):
    return sorted((c.block, c.form.kind, c.form.first) for c in fused.changes)


def check(what, truths, where, random, wanted):
    """Each change in its form, none beside them, no rival; sizes and values within their sigmas."""
    fused = fusion.fuse(logs_of(truths, random), axes=where)
    assert named(fused) == sorted(w[:3] for w in wanted), f"{what}: {named(fused)}; seed {SEED}"
    assert not any(c.rivals for c in fused.changes), f"{what}: rivals {[c.rivals for c in fused.changes]}; seed {SEED}"
    for block, kind, _, size in wanted:
        change = next(c for c in fused.changes if (c.block, c.form.kind) == (block, kind))
        value, sigma = change.size()
        far = (value[0] - size) / sigma[0]
        assert abs(far) < 4, f"{what}: {kind} of {block} is {far:.1f} sigmas off; seed {SEED}"
    return fused


def test_each_form(random):
    """Ten logs on uneven days at random temperatures. The value is that of the last log and the mean temperature."""
    days = np.sort(random.uniform(0, 400, 10))
    warm = random.uniform(-10, 40, 10)
    for block, size in SIZES.items():
        old = drawn(random)
        at_last, from_mean = (days - days[-1]) / np.ptp(days), (warm - warm.mean()) / np.ptp(warm)
        for kind, course, first, rate in (("step", np.arange(10) >= 6, 6, size), ("trend", at_last, 0, size / np.ptp(days)),
                                          ("temperature", from_mean, 0, size / np.ptp(warm))):
            truths = truths_of(old, (block, size, course))
            fused = check(f"{kind} of {block}", truths, axes(warm, days), random, [(block, kind, first, rate)])
            now = truths[-1] if kind == "step" else old
            square = (fused.value - now) @ np.linalg.solve(fused.covariance, fused.value - now)
            assert square < chi2.isf(1e-4, len(NAMES)), f"{kind} of {block}: e' C^-1 e of the value {square:.1f}; seed {SEED}"
            each = [np.abs(fused.at(k) - truths[k])[problem.indices(NAMES, block)].max() / size for k in range(10)]
            assert max(each) < 0.2, f"{kind} of {block}: value at each log {each}; seed {SEED}"


def test_nothing(random):
    """40 devices, whose logs' temperatures vary and rise: 1 % of such fleets has one named."""
    found, tests = [], None
    for _ in range(40):
        where = axes(10 + 3 * np.arange(8) + random.uniform(-5, 5, 8))
        logs = logs_of([drawn(random)] * 8, random)
        tests = tests or 40 * search.tests_of(logs, where)
        found += fusion.fuse(logs, tests=tests, axes=where).changes
    assert not found, f"{found}; seed {SEED}"


def test_together(random):
    """A step and temperature, in one block and in two; a trend and a step back, which no single form explains."""
    count, old = 12, drawn(random)
    warm = random.uniform(0, 40, count)
    from_mean, after = (warm - warm.mean()) / np.ptp(warm), np.arange(count) >= 5
    trend = np.arange(count) / (count - 1) - 1
    for other in ("cam0.r_CI", "gyro.scale"):
        check(f"step and temperature of {other}", truths_of(old, ("cam0.r_CI", 0.04, after), (other, SIZES[other], from_mean)), axes(warm), random,
              [("cam0.r_CI", "step", 5, 0.04), (other, "temperature", 0, SIZES[other] / np.ptp(warm))])
    check("trend and a step back", truths_of(old, ("cam0.r_CI", 0.08, trend), ("cam0.r_CI", -0.04, after)), axes([None] * count), random,
          [("cam0.r_CI", "trend", 0, 0.08 / (count - 1)), ("cam0.r_CI", "step", 5, -0.04)])


def test_looked_back(random):
    """Trend and temperature whose sum is nearly a step: it is taken first, and must go when both are there."""
    count, old = 14, drawn(random)
    trend = np.arange(count) / (count - 1)
    course = (np.arange(count) >= 7) - trend + random.uniform(-0.2, 0.2, count)
    where, size = axes(20 + 30 * course), 0.08
    truths = truths_of(old, ("cam0.r_CI", size, trend), ("cam0.r_CI", size, course))
    alone = search.Search(logs_of(truths, random), forms.forms_of(where), 1.0, 1000).best([])
    assert alone.form.kind == "step", "else this shows nothing"
    check("looked back", truths, where, random,
          [("cam0.r_CI", "trend", 0, size / (count - 1)), ("cam0.r_CI", "temperature", 0, size / 30)])


def test_not_told_apart(random):
    """Temperature that rises with time; once logs at other temperatures follow, it is told. Two logs: step or trend."""
    old, block = drawn(random), "cam0.r_CI"
    rising = 5 + 4 * np.arange(8) + random.uniform(-0.1, 0.1, 8)
    later = np.append(rising, [35, 5, 20])
    fused = fusion.fuse(logs_of(truths_of(old, (block, 0.08 / 28, rising)), random), axes=axes(rising))
    forms_said = [{c.form.kind, *(r.kind for r in c.rivals)} for c in fused.changes]
    assert forms_said == [{"trend", "temperature"}], f"{forms_said}; seed {SEED}"
    check("told by later logs", truths_of(old, (block, 0.08 / 28, later)), axes(later), random, [(block, "temperature", 0, 0.08 / 28)])
    for first, wanted in ((1, {"step", "trend"}), (4, {"step"})):
        count = 2 * first
        logs = [told_by(4, truth, random) for truth in truths_of(old, (block, 0.04, np.arange(count) >= first))]
        fused = fusion.fuse(fusion.common(logs), axes=axes([None] * count))
        forms_said = [{c.form.kind, *(r.kind for r in c.rivals)} for c in fused.changes]
        assert wanted in forms_said and all(said >= {"step", "trend"} for said in forms_said if count == 2), f"{count} logs: {forms_said}; seed {SEED}"


def test_most_devices(random):
    """Nine devices of ten change with temperature, the tenth has a step by less: it does not hide behind what the others are named for."""
    devices, where = [], []
    for d in range(10):
        warm = random.uniform(0, 40, 8)
        course = (warm - warm.mean()) / np.ptp(warm) if d else np.arange(8) >= 4
        devices.append(logs_of(truths_of(drawn(random), ("cam0.r_CI", 0.2 if d else 0.02, course)), random))
        where.append(axes(warm))
    before = fusion.dispersion_of([problem.solve(logs, []) for logs in devices])
    fits, dispersion = fusion.fuse_fleet(devices, where)
    assert before > 3, f"{before}: else this shows nothing; seed {SEED}"
    assert dispersion < 1.15, f"dispersion {dispersion}; seed {SEED}"  # chi2/dof of one device has a sigma of 0.12, the median of ten a third of it
    forms_said = [[(c.block, c.form.kind) for c in fit.changes] for fit in fits]
    assert forms_said == [[("cam0.r_CI", kind)] for kind in ["step"] + ["temperature"] * 9], f"{forms_said}; seed {SEED}"


def test_axes():
    """Days where logs are dated in order, else places; temperature from three logs and five degC on."""
    warm = [(18, 22), (8, 12), None, (28, 32)]
    dated = forms.axes_of([DATE, DATE + DAY // 2, DATE + DAY, DATE + 3 * DAY], [0, 1, 2, 4], warm)
    assert dated.time_unit == "day" and list(dated.time - dated.time[0]) == [0, 0.5, 1, 3] and dated.reference_degC() == 20
    for start in ([10, 20, 30, 40], [DATE, DATE + 2, DATE + 1, DATE + 3], [DATE, None, DATE + 1, DATE + 2], [DATE, DATE, DATE + 1, DATE + 2]):
        placed = forms.axes_of(start, [0, 1, 2, 4], warm)
        assert placed.time_unit == "log" and list(placed.time) == [0, 1, 2, 4], start
    by_kind = {f.kind: f for f in forms.forms_of(placed)}
    assert len(forms.forms_of(placed)) == 5 and by_kind["trend"].span == 4 and list(by_kind["trend"].course) == [-1, -0.75, -0.5, 0]
    assert by_kind["temperature"].span == 20 and list(by_kind["temperature"].course) == [0, -0.5, 0, 0.5]
    for few in ([(18, 22), None, None, (28, 32)], [(18, 22), (22, 26), (20, 24), (22.9, 26.9)], [None] * 4):
        assert "temperature" not in {f.kind for f in forms.forms_of(forms.axes_of([None] * 4, range(4), few))}, few
    assert forms.forms_of(forms.places_alone(1)) == []


for number, test in enumerate([test_each_form, test_nothing, test_together, test_looked_back, test_not_told_apart, test_most_devices]):
    test(np.random.default_rng([SEED, number]))
test_axes()
print("forms: step, trend and temperature told apart, or said that they are not")
