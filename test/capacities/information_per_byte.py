"""What a byte of the database tells: capacities of a segment (keyframes, landmarks, points) against sigmas, with as many segments each and with as much
memory each. Simulated devices of 120 s, 100 corners a frame; each set is built as a user would.
Usage: information_per_byte.py --segcal PROGRAM --work FOLDER [--devices 3] [--seed 1]"""

import argparse
import json
import math
import os
import pathlib
import statistics
import sys

from drawn_devices import build, record, run

SCENARIOS = ["arvr", "nav", "rich"]
SEGMENTS = 8
# keyframes, landmarks, points; the first is profile mobile's, to which the others are compared
SHAPES = [(20, 120, 2000), (20, 60, 1000), (20, 30, 500), (12, 120, 1300), (12, 60, 650), (12, 40, 360), (8, 60, 480), (20, 200, 3300), (28, 120, 2800)]
# Else as profile mobile, so that the filter is the same.
FIXED = {"MAX_CAMERAS": 1, "MAX_IMU_SAMPLES": 2000, "MAX_CLONES": 19, "MAX_TRACKS": 160, "FRAME_FEATURES": 30, "MAX_TIES": 8, "IMU_HISTORY": 1000,
         "PIXEL_BITS": 32, "TRACK_WALK": 1, "MAX_EFFECT_COLUMNS": 0, "MAX_EFFECT_ESTIMATES": 0}
SECONDS, RATE_HZ = 120, 200


def capacities(shape, segments):
    keyframes, landmarks, points = shape
    return {**FIXED, "MAX_KEYFRAMES": keyframes, "MAX_LANDMARKS": landmarks, "MAX_OBSERVATIONS": points, "MAX_SEGMENTS": segments}


def measure(shape, segments, o, recordings):
    """{recording: what the device said}, from a cache where it is done: delete WORK after a change of the core."""
    name = "_".join(map(str, (*shape, segments)))
    done = o.work / f"{name}_seed{o.seed}_{o.devices}.json"
    if not done.exists():
        program, refusal = build(capacities(shape, segments), o.work / name)
        if refusal:
            sys.exit(f"{name}: {refusal}")
        done.write_text(json.dumps({r.name: run(program, r, 1, RATE_HZ) for r in recordings}))
    return json.loads(done.read_text())


def bytes_of(runs):
    return int(next(r["segment_bytes"] for r in runs.values() if "segment_bytes" in r))


def released(runs):
    return sum(len(r.get("errors", {})) for r in runs.values())


def ratio(runs, base, scenario):
    """Geometric mean of sigma over that of `base`, over all entries that both released and all devices of a scenario."""
    logs = [math.log(runs[r]["sigmas"][n] / base[r]["sigmas"][n]) for r in runs if r.startswith(scenario)
            for n in runs[r].get("errors", {}) if n in base[r].get("errors", {})]
    return math.exp(statistics.mean(logs)) if logs else math.nan


def row(shape, segments, runs, base):
    errors = [e for r in runs.values() for e in r.get("errors", {}).values()]
    by_scenario = " | ".join(f"{ratio(runs, base, s):.2f}" for s in SCENARIOS)
    calibrated = sum(r.get("status") == "1" for r in runs.values())
    print(f"| {' | '.join(map(str, shape))} | {segments} | {bytes_of(runs) * segments / 1024:.0f} | {by_scenario} | "
          f"{calibrated} of {len(runs)} | {released(runs)} | {statistics.mean(e * e for e in errors) if errors else math.nan:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--segcal", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--devices", type=int, default=3, help="of each scenario")
    parser.add_argument("--seed", type=int, default=1)
    o = parser.parse_args()
    o.work.mkdir(parents=True, exist_ok=True)
    recordings = [o.work / f"{scenario}_{o.seed + i}" for scenario in SCENARIOS for i in range(o.devices)]
    for r in recordings:
        if not (r / "start").exists():
            scenario, seed = r.name.split("_")
            record(o.segcal, r, 1, RATE_HZ, int(seed), SECONDS, scenario, tracks=100)
    base = measure(SHAPES[0], SEGMENTS, o, recordings)
    bytes_of_base = bytes_of(base)
    print("| keyframes | landmarks | points | segments | kB | sigma arvr | nav | rich | calibrated | released | mean (error/sigma)^2 |\n|" + "---:|" * 11, flush=True)
    for shape in SHAPES:
        runs = measure(shape, SEGMENTS, o, recordings)
        row(shape, SEGMENTS, runs, base)
        as_much = round(SEGMENTS * bytes_of_base / bytes_of(runs))
        if as_much != SEGMENTS:
            row(shape, as_much, measure(shape, as_much, o, recordings), base)
    return 0


if __name__ == "__main__":
    os.environ.setdefault("CMAKE_BUILD_PARALLEL_LEVEL", "1")
    sys.exit(main())
