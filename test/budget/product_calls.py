#!/usr/bin/env python3
"""The longest calls of two minutes as a product has them: IMU up to an image, then its tracks; two calibrations asked for on the way; each
schedule of the background for itself (test/firmware/run_product.c). A table, and exit code 1 if a call is beyond the limits of
fixtures/budget/limits.json for cortex-m7, if a schedule that kept all deadlines has other bits than another that did, or if none was kept.

usage: product_calls.py --build FOLDER --target cortex-m7 --counter instruction_counter.so
FOLDER is a build with images (SEGCAL_BUILD_IMAGES=ON), one for each of SEGCAL_PRODUCT_SLICES: slices after each sample; 0: no background at
all; below 0: as many, but in bursts, five times a second."""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FEED, SLICE = ("imu_sample", "frame", "frame_closing"), ("start_slice", "score_slice", "calibrate_slice")


def run(args, image):
    """Exit code, what it printed, and the longest call of each kind."""
    counts = image.with_suffix(".counts")
    command = [ROOT / "test/firmware/run_image.sh", args.target, image, args.counter, counts]
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    values = dict(line.split() for line in done.stdout.splitlines() + done.stderr.splitlines() if len(line.split()) == 2)
    if "result_hash" not in values:
        sys.exit(f"{image}:\n{done.stdout}{done.stderr}exit code {done.returncode}")
    longest = dict.fromkeys(FEED + SLICE, 0)
    for line in counts.read_text().splitlines():
        kind, n = line.split()
        if kind in longest:
            longest[kind] = max(longest[kind], int(n))
    return done.returncode, values, longest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("build", "counter"):
        parser.add_argument(f"--{name}", type=lambda path: pathlib.Path(path).resolve(), required=True)
    parser.add_argument("--target", required=True)
    args = parser.parse_args()
    limits = json.loads((ROOT / "fixtures/budget/limits.json").read_text())["limits"]["cortex-m7 mcu -O2"]
    limit = {**dict.fromkeys(FEED, limits["instructions.frame_max"]), **dict.fromkeys(SLICE, limits["instructions.slice_max"])}
    images = sorted(args.build.glob("run_product_*.elf"), key=lambda path: int(path.stem.rpartition("_")[2]))
    if not images:
        sys.exit(f"{args.build}: no run_product_*.elf; build with SEGCAL_BUILD_IMAGES=ON")
    red, hashes = [], {}
    print("| slices a sample | " + " | ".join(limit) + " | calibrations | late | segments lost | result_hash |")
    print("|---:|" + "---:|" * (len(limit) + 3) + "---|")
    for image in images:
        slices = int(image.stem.rpartition("_")[2])
        code, values, longest = run(args, image)
        print(f"| {slices} | " + " | ".join(f"{n:,}" for n in longest.values())
              + f" | {values['calibrations']} | {values['late']} | {values['segments_late']} | {values['result_hash']} |", flush=True)
        red += [f"{slices} slices: {kind} took {n:,} instructions, the limit is {limit[kind]:,}" for kind, n in longest.items() if n > limit[kind]]
        if values["late"] == "0":
            hashes[slices] = values["result_hash"]
            if code != 0:
                red.append(f"{slices} slices: exit code {code}, not calibrated twice")
    if len(set(hashes.values())) != 1:
        red.append(f"bits of the schedules that kept all deadlines: {hashes or 'none did'}")
    print("\n".join(red) if red else "no call beyond its limit")
    return 1 if red else 0


if __name__ == "__main__":
    sys.exit(main())
