"""`segcal report` as people see it: in a browser on a wide screen, a phone and paper; and what it says to damaged files.
Usage: test_report.py SEGCAL SOURCE_TREE FOLDER [SEED]"""

import copy
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys

import browser

SEGCAL, SOURCE, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
SEED = int(sys.argv[4]) if len(sys.argv) > 4 else 1
sys.path[:0] = [str(SOURCE / "host_tools" / part) for part in ("report", "common")]
import report  # noqa: E402

WIDTHS = 400, 1300
PAPER = 718  # px of 1/96 inch: A4 less a centimetre on each side
MARK = "<script>alert('x')</script>\"'&<b>"

COMMON = ["What each segment told of each parameter", "Metric of each segment", "Path, seen from above", "Path in space", "Biases"]
OF_KEPT = ["Residuals over the image", "Drift along tracks", "Camera residuals against 3 sigma", "IMU residuals against 3 sigma"]


def segcal(*arguments, codes=(0,)):
    environment = {**os.environ, "SEGCAL_PYTHON": sys.executable}
    done = subprocess.run([SEGCAL, *map(str, arguments)], capture_output=True, text=True, check=False, env=environment, timeout=300)
    assert done.returncode in codes, (arguments, done.returncode, done.stderr)
    return done


def simulated(name, *options):
    segcal("simulate", "--out", FOLDER / name, *options)
    return FOLDER / name


def make_folders():
    """One of each kind that a page is made of: (folder, sections with a figure, words at the top)."""
    rich = ["--scenario", "rich", "--seconds"]
    sessions = [simulated(f"rec_{s}", *rich, 13, "--seed", s, "--device-seed", 1, "--cameras", 2) for s in (1, 2, 3)]
    small = ["--segments", 4, "--segment-seconds", 3]
    # Two epochs and more, so that they are what is drawn over time.
    segcal("replay", *sessions, "--segments", 3, "--segment-seconds", 2, "--condense", "--cameras", 2, "--out", FOLDER / "sessions")
    assert len(json.loads((FOLDER / "sessions" / "result.json").read_text())["epochs"]) > 1
    yield "sessions", [*COMMON, *OF_KEPT, "Theta over calibrations"], "Calibrated"
    segcal("replay", simulated("rec_still", "--scenario", "still", "--seconds", 8), *small, "--out", FOLDER / "refused", codes=(1,))
    yield "refused", COMMON, "Not enough information"
    off = simulated("rec_off", *rich, 12, "--effect", "time_offset=0.01", "--seed", 3)
    segcal("diagnose", off, "--out", FOLDER / "diagnosis", codes=(0, 1))
    yield "diagnosis", ["The gap", "Worst windows: mean image residual, simulated minus measured", "Worst window: whitened IMU residuals"], "time_offset"
    segcal("allan", simulated("rec_rest", "--scenario", "still", "--seconds", 70), "--out", FOLDER / "allan")
    yield "allan", ["Gyroscope", "Accelerometer"], "rest"


def check_page(chromium, file, figures, words):
    for width in chromium.at_widths(file, WIDTHS):
        drawn, wrong = chromium.look()
        assert not wrong, f"{file} at {width} px: {wrong[:5]}"
        assert set(figures) <= set(drawn), f"{file} at {width} px: no figure in {sorted(set(figures) - set(drawn))}"
        top = chromium.driver.execute_script("return document.body.innerText.slice(0, 900)")
        assert words in top, f"{file}: {words!r} is not at the top: {top}"
    chromium.print_preview(PAPER)
    _, wrong = chromium.look()
    chromium.on_screen()
    assert not wrong, f"{file} on paper: {wrong[:5]}"
    errors = chromium.errors()
    assert not errors, f"{file}: {errors}"


def check_that_the_look_sees(chromium):
    """A page with one fault of each kind, so that a look that sees nothing fails."""
    file = FOLDER / "faulty.html"
    good = (FOLDER / "allan" / "report.html").read_text()
    faults = ('<p style="width: 3000px">wide</p><div style="overflow: hidden; width: 60px; white-space: nowrap">hidden text that is cut</div>'
              '<section><h2>Nothing</h2><div class="plotly-graph-div"></div></section><script>undefined.x</script></body>')
    file.write_text(good.replace("</body>", faults))
    chromium.open(file, 400)
    _, wrong = chromium.look()
    for kind in ("page 3", "P. from", "hides text", '"Nothing" is empty'):
        assert any(kind in w for w in wrong), (kind, wrong)
    assert chromium.errors()


def places(value, path=()):
    """Paths to the members of a JSON document; of a list, the first two."""
    children = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, child in children:
        yield (*path, key)
        yield from places(child, (*path, key))


def changed(document, path, change):
    spoiled = copy.deepcopy(document)
    target = spoiled
    for key in path[:-1]:
        target = target[key]
    target[path[-1]] = change
    return spoiled


def check_damage(chosen):
    """A page or one line, never an error of Python's; and text of a file stays text."""
    for name, file in (("sessions", "result.json"), ("sessions", "report_data.json"), ("diagnosis", "diagnosis.json"), ("allan", "allan.json")):
        whole = json.loads((FOLDER / name / file).read_text())
        shutil.copytree(FOLDER / name, FOLDER / "spoiled", dirs_exist_ok=True)
        for change in (None, MARK, [], {}, -1, [[MARK]]):
            for path in chosen.sample(list(places(whole)), 2):
                (FOLDER / "spoiled" / file).write_text(json.dumps(changed(whole, path, change)))
                try:
                    page = report.rendered(FOLDER / "spoiled")
                except report.InputError as error:
                    assert str(FOLDER / "spoiled") in str(error) and "\n" not in str(error), error
                    continue
                except Exception as error:
                    raise AssertionError(f"{file} with {change} at {path}: {error!r}; seed {SEED}") from error
                assert MARK not in page and "<script>alert" not in page, f"{file}: not escaped at {path}; seed {SEED}"
        shutil.rmtree(FOLDER / "spoiled")


def check_scale():
    """Sigmas are scaled by noise_scale, which is more than the square root of chi2/dof where segments disagree."""
    folder = FOLDER / "scale"
    shutil.copytree(FOLDER / "sessions", folder)
    result = json.loads((folder / "result.json").read_text())
    result["fit"]["noise_scale"] = 3.21
    (folder / "result.json").write_text(json.dumps(result))
    assert "all sigmas are scaled by 3.21, since segments disagree by more" in report.rendered(folder)


def check_refusals():
    folder = FOLDER / "refusals"
    shutil.copytree(FOLDER / "refused", folder)
    (folder / "report.html").unlink(missing_ok=True)
    (folder / "manifest.json").unlink()  # as from another program: with it, `segcal report` sees that a file was changed, and says that
    for file, text, says in (("report_data.json", '{"a": [1,\n', "report_data.json:2: expected JSON"), ("report_data.json", "[1]", "expected a JSON object"),
                             ("calibration.jsonl", "{}\n{", "calibration.jsonl: expected a JSON object on each line"),
                             ("result.json", "[" * 100000, "result.json"), ("result.json", "{}", "result.json:1: expected an object with status")):
        before = (folder / file).read_text()
        (folder / file).write_text(text)
        done = segcal("report", folder, codes=(2,))
        assert says in done.stderr and done.stderr.count("\n") == 1, (file, done.stderr)
        assert not (folder / "report.html").exists()
        (folder / file).write_text(before)


def main():
    assert not browser.missing(), f"not installed: {browser.missing()}; host_tools/setup.sh installs them"
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    cases = list(make_folders())
    with browser.Browser() as chromium:
        for name, figures, words in cases:
            segcal("report", FOLDER / name)
            check_page(chromium, FOLDER / name / "report.html", figures, words)
        check_that_the_look_sees(chromium)
    check_damage(random.Random(SEED))
    check_scale()
    check_refusals()
    print("report: drawn on a screen, a phone and paper; damaged files answered in a line")


main()
