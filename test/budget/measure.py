#!/usr/bin/env python3
"""Measures one build: runs the recorded session on its target, and reads sizes, stack and instruction counts.

usage: measure.py --target T --profile P --optimisation O --build FOLDER --tools PREFIX [--counter PLUGIN] --out FILE
The library is FOLDER/lib/libsegcal.a, the image FOLDER/run_session.elf. Exit code 1: the run or a proof failed."""
import argparse
import json
import pathlib
import statistics
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Of hosted targets the C library's memory functions are chosen at run time; they are leaves.
HOSTED_LEAVES = ["memcpy=0", "memset=0", "memmove=0"]
# The device log writes through the user's function.
USERS_FUNCTIONS = "segcal_log_"


def run(command, **options):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)


def run_session(args, counts):
    command = [ROOT / "test/firmware/run_image.sh", args.target, args.build / "run_session.elf"]
    if args.counter:
        command += [args.counter, counts]
    done = run(command)
    lines = (done.stdout + done.stderr).splitlines()
    if done.returncode != 0:
        sys.exit("\n".join(lines + [f"{args.target}: the session ended with exit code {done.returncode}"]))
    return lines


def double_of(digits):
    return struct.unpack(">d", bytes.fromhex(digits))[0]


def parse(lines):
    """The image's "name value" lines; each parameter's line is followed by its sigma's."""
    values, theta, name = {}, {}, None
    for line in lines:
        key, value = line.split()
        if key == "sigma":
            theta[name] = {"value": theta[name], "sigma": double_of(value)}
        elif "." in key:
            name = key
            theta[name] = double_of(value)
        else:
            values[key] = value if key == "result_hash" else int(value)
    return values, theta


def instructions(path):
    """From the marked calls in their order (test/firmware/marks.h). A score is the slices between the frame that ended a segment
    and the next such frame."""
    calls = [(k, int(n)) for k, n in (line.split() for line in path.read_text().splitlines())]
    of = lambda *kinds: [n for k, n in calls if k in kinds]
    frame_median = statistics.median_low(of("frame"))
    scores = []
    for kind, n in calls:
        if kind == "frame_closing":
            scores.append(0)
        elif kind == "score_slice" and scores:
            scores[-1] += n
    background = of("start_slice", "score_slice", "calibrate_slice", "calibrate")
    return {
        "imu_sample": max(of("imu_sample")),
        "frame_median": frame_median,
        "frame_max": max(of("frame", "frame_closing")),
        "slice_max": max(background),
        "score_segment": max(scores),
        "calibrate": sum(of("calibrate_slice", "calibrate")),
    }


def code_bytes(args):
    """Code and constants of the whole library, before the linker drops what a program does not call. Inline functions that
    several objects hold count once."""
    merged = args.out.with_suffix(".o")
    run([args.tools + "ld", "-r", "--whole-archive", args.build / "lib/libsegcal.a", "-o", merged], check=True)
    return int(run([args.tools + "size", merged], check=True).stdout.splitlines()[1].split()[0])


def proven_stack(args, path):
    command = [ROOT / "test/gates/call_graph.py", "--graphs", args.build / "lib", "--callbacks", USERS_FUNCTIONS, "--json", path]
    if args.target.startswith("cortex"):
        command += ["--image", args.build / "run_session.elf", "--objdump", args.tools + "objdump"]
    else:
        command += [word for leaf in HOSTED_LEAVES for word in ("--assume", leaf)]
    done = run(command)
    if done.returncode != 0:
        sys.exit(done.stdout + done.stderr)
    return json.loads(path.read_text())["bytes"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("target", "profile", "optimisation"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--tools", default="", help="prefix of ld, size and objdump, such as arm-none-eabi-")
    parser.add_argument("--counter", help="the instruction counter; without it nothing is counted")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    return parser.parse_args()


def main():
    args = arguments()
    args.out.parent.mkdir(parents=True, exist_ok=True)
    counts = args.out.with_suffix(".counts")
    values, theta = parse(run_session(args, counts))
    measured = {
        "target": args.target, "profile": args.profile, "optimisation": args.optimisation,
        "state_bytes": values["state_bytes"],
        "hot_bytes": values["hot_bytes"],
        "code_bytes": code_bytes(args),
        "stack_bytes": {"proven": proven_stack(args, args.out.with_suffix(".stack.json")), "painted": values.get("stack_painted_bytes")},
        "instructions": instructions(counts) if args.counter else None,
        "result_hash": values["result_hash"],
        "theta": theta,
    }
    args.out.write_text(json.dumps(measured, indent=1) + "\n")
    print(f"{args.target} {args.profile} {args.optimisation}: hash {measured['result_hash']}")


if __name__ == "__main__":
    main()
