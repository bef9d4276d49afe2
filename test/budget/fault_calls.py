#!/usr/bin/env python3
"""The longest calls on faulty data: each fault of `segcal experiments faults` is simulated, made a device log of profile mcu, and fed
to the core under QEMU, where a plugin counts the instructions of every call. A table, and exit code 1 if a call is beyond the limits
of fixtures/budget/limits.json for cortex-m7. A frame is 1.6 times as many instructions there as on aarch64, a slice 1.2 times, so
what comes near a limit is to be counted on the target itself (docs/porting.md, section 5). Beside the faults: `none`, and `corners_renewed`.

usage: fault_calls.py --segcal PROGRAM --image count_log.elf --counter instruction_counter.so --out FOLDER
                      [--kinds none,camera_jitter,...] [--seconds 40] [--seed 1] [--slices 8] [--requests 0] [--emulator qemu-aarch64]
                      [--most-over-clean FACTOR]
--most-over-clean: also red where a call takes more than so many times the longest of its kind on the clean recording (`none`), which
says the same on every target. --kinds: the default is all of them. --slices: of background work after each sample. --requests: calibrations asked for on the way."""
import argparse
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A frame that came before its samples is processed in the call of the sample that completes it.
COLUMNS = (("imu_sample", "frame_max"), ("frame", "frame_max"), ("frame_closing", "frame_max"), ("start_slice", "slice_max"),
           ("score_slice", "slice_max"), ("calibrate_slice", "slice_max"), ("calibrate", "calibrate"))
# Of these a clean recording has its share.
OVER_CLEAN = ("frame", "frame_closing", "start_slice", "score_slice")
# No fault: a tracker that detects all corners anew every dozen images, so that the filter has thirty short tracks at once.
RENEWED, IMAGES_OF_A_CORNER = "corners_renewed", 12


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stdout}{done.stderr}exit code {done.returncode}")
    return done.stdout


def all_kinds(segcal):
    """A clean recording, and the names that `segcal simulate --help` lists."""
    text = run(segcal, "simulate", "--help")
    names = re.search(r"experiments faults`, at its size:\s*(.*?)\s*--temperature", text, re.S).group(1).split()
    return ["none", RENEWED, *names]


def renew_corners(recording):
    """Ids of the tracks, so that each ends with its dozen of images."""
    file = recording / "mav0/cam0/tracks.csv"
    header, *rows = [line.split(",") for line in file.read_text().splitlines()]
    images = {stamp: i for i, stamp in enumerate(sorted({row[0] for row in rows}, key=int))}
    ids = {}
    for row in rows:
        row[1] = str(ids.setdefault((row[1], images[row[0]] // IMAGES_OF_A_CORNER), len(ids) + 1))
    file.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")
    (recording / "manifest.json").unlink()  # it has the file's hash


def longest_calls(args, kind):
    recording, log, counts = args.out / kind, args.out / f"{kind}.segcal", args.out / f"{kind}.counts"
    fault = [] if kind in ("none", RENEWED) else ["--fault", kind]
    run(args.segcal, "simulate", "--out", recording, "--seconds", args.seconds, "--seed", args.seed, "--tracks", 40, *fault)
    if kind == RENEWED:
        renew_corners(recording)
    run(args.segcal, "convert", recording, "--profile", "mcu", "--out", log)
    text = run(args.emulator, "-plugin", f"{args.counter},out={counts}", args.image, log, args.slices, args.requests)
    longest = dict.fromkeys((name for name, _ in COLUMNS), 0)
    for line in counts.read_text().splitlines():
        name, n = line.split()
        if name in longest:
            longest[name] = max(longest[name], int(n))
    counts.unlink()
    return longest, dict(line.split() for line in text.splitlines())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("segcal", "image", "counter", "out"):
        parser.add_argument(f"--{name}", type=lambda path: pathlib.Path(path).resolve(), required=True)
    parser.add_argument("--kinds", default="")
    parser.add_argument("--emulator", default="qemu-aarch64")
    parser.add_argument("--most-over-clean", type=float, default=float("inf"))
    parser.add_argument("--seconds", type=float, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--slices", type=int, default=8)
    parser.add_argument("--requests", type=int, default=0)
    args = parser.parse_args()
    limits = json.loads((ROOT / "fixtures/budget/limits.json").read_text())["limits"]["cortex-m7 mcu -O2"]
    args.out.mkdir(parents=True, exist_ok=True)
    beyond, clean = [], {}
    print("| fault | " + " | ".join(name for name, _ in COLUMNS) + " | calibrations | late |")
    print("|---|" + "---:|" * (len(COLUMNS) + 2))
    for kind in args.kinds.split(",") if args.kinds else all_kinds(args.segcal):
        longest, counters = longest_calls(args, kind)
        print(f"| {kind} | " + " | ".join(f"{longest[name]:,}" for name, _ in COLUMNS) + f" | {counters['calibrations']} | {counters['late']} |", flush=True)
        beyond += [f"{kind}: {name} took {longest[name]:,} instructions, the limit is {limits['instructions.' + key]:,}"
                   for name, key in COLUMNS if longest[name] > limits["instructions." + key]]
        clean = longest if kind == "none" else clean
        beyond += [f"{kind}: {name} took {longest[name] / n:.2f} times what it took on the clean recording, the limit is {args.most_over_clean}"
                   for name, n in clean.items() if name in OVER_CLEAN and longest[name] > args.most_over_clean * n]
    print("\n".join(beyond) if beyond else "no call beyond its limit")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
