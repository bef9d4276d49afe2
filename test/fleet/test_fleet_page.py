"""The page of `segcal fleet` in a browser, of a made-up fleet: one device fell, one ages, one depends on temperature, of one it is not told
which of these, one is unlike the others, one log cannot be read.
Usage: test_fleet_page.py SOURCE_TREE FOLDER [SEED]"""

import pathlib
import sys

import numpy as np

SOURCE, FOLDER = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 1
sys.path[:0] = [*(str(SOURCE / "host_tools" / part) for part in ("fleet", "report", "common")), str(SOURCE / "test" / "report")]
import browser  # noqa: E402
import evidence  # noqa: E402
import fleet  # noqa: E402
import fleet_page  # noqa: E402
import judge  # noqa: E402
from made_up import INITIAL, NAMES, SIGMA, drawn, result_of  # noqa: E402

DEVICES, LOGS = 11, 8
FELL, UNLIKE, SICK = "</script><script>alert(1)</script>", "unlike", "sick"  # a device may have any name
AGES, WARM, EITHER = "ages", "warm", "either"
STEP, FIRST = 0.04, 5
DAY = 86400 * 10**9  # ns
WARMTH = [20, 31, 12, 5, 27, 16, 36, 9]  # degC, of all devices' logs but one: there it rises with time


def shift_of(device, place):
    return {FELL: STEP * (place >= FIRST), AGES: 0.01 * place, EITHER: 0.01 * place, WARM: 0.002 * WARMTH[place]}.get(device, 0)


def result(truth, random, place, warmth):
    """As work.py's records hold it: what result_of makes, and what tables show of it."""
    out = result_of(truth, random)
    sigma = np.sqrt(np.diag(np.reshape(out["covariance"], (len(NAMES), -1))))
    for p, value, s in zip(out["parameters"], out["mean"], sigma):
        p.update(value=value, sigma=s, unit="px" if p["name"][5:6] in ("f", "c") else "rad" if "r_" in p["name"] else "-", verdict="observed")
    segment = {"start_ns": (19000 + 10 * place) * DAY, "end_ns": (19000 + 10 * place) * DAY + 10**9, "kept": True}
    return {**out, "fit": {"chi2": 1000.0, "dof": 1000.0}, "segments": [segment], "faults": {}, "temperature_degC": [warmth - 1.0, warmth + 1.0]}


def made_up_runs(random):
    names = [FELL, UNLIKE, SICK, AGES, WARM, EITHER, *(f"device_{d}" for d in range(6, DEVICES))]
    runs = []
    for device in names:
        truth = INITIAL + 0.3 * (drawn(random) - INITIAL)
        truth[NAMES.index("cam0.fx")] += 40 * (device == UNLIKE)
        for place in range(LOGS):
            now = truth + shift_of(device, place) * (np.arange(len(NAMES)) == NAMES.index("cam0.r_CI.y"))
            found = None if device == SICK and place == 1 else result(now, random, place, 4 * place if device == EITHER else WARMTH[place])
            record = {"result": found, "error": "" if found else "imu0/data.csv:7: expected 7 columns, found 3", "exit_code": 0 if found else 2}
            run = judge.Run(f"{device}{place}", f"/logs/{device.strip('</>')}/session_{place}", record, device, "headset", place)
            run.evidence = evidence.evidence_of(found) if found else None
            runs.append(run)
    return runs


def check_rows(rows):
    """Rate and unit of each form, the value's temperature, and the fused value at each log."""
    of = {r["device"]: r for r in rows["changes"] if r["name"] == "cam0.r_CI.y"}
    forms = {FELL: ("step", "", None), AGES: ("trend", "", "rad/day"), WARM: ("temperature", "", "rad/degC"), EITHER: ("trend", "temperature", "rad/day")}
    said = {d: (r["form"], r["or_form"], r["rate_unit"]) for d, r in of.items()}
    either = [said.pop(EITHER), forms.pop(EITHER)][0]
    assert said == forms and either in (("trend", "temperature", "rad/day"), ("temperature", "trend", "rad/degC")), f"{said}, {either}; seed {SEED}"
    for device, size, truth in ((FELL, "step", STEP), (AGES, "rate", 0.001), (WARM, "rate", 0.002)):
        assert abs(of[device][size] - truth) < 4 * of[device]["sigma"] < truth / 2, f"{of[device]}; seed {SEED}"
    held = {r["device"]: (r["from_place"], r["at_degC"]) for r in rows["devices"] if r["name"] == "cam0.r_CI.y"}
    assert [held[d] for d in (FELL, AGES, WARM)] == [(FIRST, None), (LOGS - 1, None), (0, np.mean(WARMTH))], f"{held}; seed {SEED}"
    for device in (FELL, AGES, WARM):
        fused = [r["fused"] for r in rows["parameters"] if (r["device"], r["name"]) == (device, "cam0.r_CI.y")]
        change = [shift_of(device, place) - shift_of(device, 0) for place in range(LOGS)]
        assert np.allclose(np.array(fused) - fused[0], change, atol=0.01), f"{device}: {fused}; seed {SEED}"


def check(chromium, file, sections):
    for width in chromium.at_widths(file, (400, 1300)):
        drawn_in, wrong = chromium.look()
        assert not wrong, f"{file} at {width} px: {wrong[:5]}"
        assert {s: drawn_in.count(s) for s in sections} == sections, f"{file} at {width} px: {drawn_in}"


def chosen(chromium, device):
    """Figures of a device's trend, with the number of logs in each, after a choice as with the mouse."""
    chromium.driver.execute_script("const s = document.getElementById('device'); s.value = arguments[0]; s.dispatchEvent(new Event('change'))", device)
    chromium.settle()
    return chromium.driver.execute_script("return [...document.querySelectorAll('#trend .plotly-graph-div')].map(f => f.data[0].x.length)")


def main():
    assert not browser.missing(), f"not installed: {browser.missing()}; host_tools/setup.sh installs them"
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows, dispersion = judge.rows_of_fleet(made_up_runs(np.random.default_rng(SEED)))
    check_rows(rows)
    file = FOLDER / "report.html"
    file.write_text(fleet_page.render(rows, fleet.sentences(rows, dispersion)))
    (FOLDER / "nothing.html").write_text(fleet_page.render({name: [] for name in rows}, ["0 logs"]))
    blocks = 10  # cam0: r_CI, p_CI, focal lengths, centre, lens; gyro: s, m; accel: s, m, r_AI
    with browser.Browser() as chromium:
        check(chromium, file, {"Changes": 4, "Spread per model": 1, "Trend per device": blocks})
        assert chosen(chromium, FELL) == [LOGS] * blocks and chosen(chromium, SICK) == [LOGS - 1] * blocks
        _, wrong = chromium.look()
        text = chromium.driver.execute_script("return document.body.innerText")
        chromium.print_preview(718)
        wrong += chromium.look()[1] + chromium.errors()
        assert not wrong, wrong[:5]
        check(chromium, FOLDER / "nothing.html", {})
        assert not chromium.errors()
    assert text.index("88 logs of 11 devices") < 60 and "87 calibrated, 1 refused" in text and "5 devices to look at" in text, text[:400]
    for words in (f"{FELL}", "cam0.r_CI changed before session_5", "sigmas from the other devices", "expected 7 columns", "session_5",
                  "rad per day (y) since session_0", "cam0.r_CI changes with temperature by", "rad per degC (y)", "the logs do not tell them apart",
                  "step before", "trend since", "not told apart", "rad/day", "rad/degC"):
        assert words in text, f"{words}: not on the page; seed {SEED}"
    print("fleet page: drawn on a screen, a phone and paper; a device chosen")


main()
