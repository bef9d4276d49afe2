#!/usr/bin/env python3
"""The budget itself: each rule of budget.py is broken once and must turn it red; figures as kept must pass."""
import copy
import json
import pathlib
import subprocess
import sys
import tempfile

import measure

BUDGET = pathlib.Path(__file__).with_name("budget.py")
MEASURED = {
    "target": "cortex-m7", "profile": "mcu", "optimisation": "-O2", "state_bytes": 1000, "hot_bytes": 400, "code_bytes": 500,
    "stack_bytes": {"proven": 80, "painted": 76}, "instructions": {"frame_median": 100}, "result_hash": "00",
    "theta": {"cam0.fx": {"value": 256.0, "sigma": 0.1}},
}
KEPT = {"state_bytes": 1000, "hot_bytes": 400, "code_bytes": 500, "stack_bytes.proven": 80, "stack_bytes.painted": 76, "instructions.frame_median": 100}
KEY = "cortex-m7 mcu -O2"
failures = 0


def other(**changes):
    measured = copy.deepcopy(MEASURED)
    measured.update(changes)
    return measured


def expect(code, words, name, *measured, limits=None, open_list=(), options=(), kept=None):
    global failures
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "limits.json").write_text(json.dumps({"limits": {KEY: limits or {"state_bytes": 1000}}, "open": list(open_list)}))
        keys = {" ".join(m[k] for k in ("target", "profile", "optimisation")) for m in measured}
        (root / "kept.json").write_text(json.dumps({k: kept or KEPT for k in keys}))
        files = []
        for i, one in enumerate(measured):
            files.append(root / f"{i}.json")
            files[-1].write_text(json.dumps(one))
        done = subprocess.run([BUDGET, "--fixtures", root, "--out", root / "out", *options, *files], capture_output=True, text=True)
    if done.returncode != code or words not in done.stdout:
        print(f"{name}: exit code {done.returncode}, expected {code} and the words '{words}'\n{done.stdout}{done.stderr}")
        failures += 1


def expect_figures(lines, **expected):
    """Of what the instruction counter wrote."""
    global failures
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "counts"
        path.write_text("\n".join(lines) + "\n")
        found = measure.instructions(path)
    wrong = {k: found[k] for k, v in expected.items() if found[k] != v}
    if wrong:
        print(f"figures from {lines}: {wrong}, expected {expected}")
        failures += 1


expect_figures(["imu_sample 3", "imu_sample 5", "frame 10", "frame_closing 40", "score_slice 7", "score_slice 9", "frame 20",
                "frame_closing 12", "score_slice 8", "frame 11", "calibrate_slice 6", "calibrate_slice 2"],
               imu_sample=5, frame_median=11, frame_max=40, slice_max=9, score_segment=16, calibrate=8)
expect_figures(["imu_sample 3", "frame 10", "calibrate_slice 6", "frame_closing 12", "score_slice 5"], slice_max=6, score_segment=5)

expect(0, "| state_bytes | 1,000 | +0.00% | 1,000 |", "as kept", MEASURED)
expect(1, "RED: cortex-m7 mcu -O2: state_bytes is 1,001, the limit is 1,000", "over a limit", other(state_bytes=1001))
expect(1, "code_bytes went from 500 to 511", "2 % worse", other(code_bytes=511))
expect(0, "+2.00%", "just within 2 %", other(code_bytes=510))
expect(0, "OPEN LIMIT, not met yet: cortex-m7 mcu -O2: state_bytes", "an open limit is said", other(state_bytes=1001),
       open_list=[[KEY, "state_bytes"]])
expect(1, "RED: cortex-m7 mcu -O2: state_bytes", "an open limit with --open-limits", other(state_bytes=1001),
       open_list=[[KEY, "state_bytes"]], options=["--open-limits"])
expect(1, "take it off the open ones", "an open limit that is met", MEASURED, open_list=[[KEY, "state_bytes"]])
expect(1, "state_bytes went from", "an open limit does not hide growth", other(state_bytes=1100),
       open_list=[[KEY, "state_bytes"]])
expect(1, "has a limit and was not measured", "a limit without a figure", MEASURED, limits={"instructions.calibrate": 1})
expect(1, "results differ", "other bits", MEASURED, other(target="aarch64", result_hash="01"))
expect(0, "theta within 0.04", "theta near the double build's", MEASURED,
       other(profile="mcu_double", theta={"cam0.fx": {"value": 256.004, "sigma": 0.1}}))
expect(1, "cam0.fx is 0.060 sigma", "theta far from the double build's", MEASURED,
       other(profile="mcu_double", theta={"cam0.fx": {"value": 256.006, "sigma": 0.1}}))
if failures == 0:
    print("budget: every rule turns red")
sys.exit(1 if failures else 0)
