"""Capacities drawn from a range in which calibration is possible, each built as a user would, each fed simulated devices with IMUs of several
rates: is the truth found within the sigmas, and does what is too small say so? Every run is a device of its own (60 s of `rich`).
Usage: drawn_devices.py --segcal PROGRAM --work FOLDER [--sets 20] [--seed 1] [--only SET ...] [--rates 50 ...]
[--repeats 1] [--range small] [--with NAME=VALUE ...]"""

import argparse
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys

import yaml

from summary import judge, report

HERE = pathlib.Path(__file__).resolve().parent
RATES = [50, 100, 200, 400, 1000, 4000]


def draw(rng):
    """In which calibration is possible: room for a keyframe in half a second. A sensor for whose samples there is no room is averaged."""
    keyframes, landmarks, cameras = rng.randint(8, 24), rng.randint(30, 120), rng.randint(1, 2)
    return {"MAX_CAMERAS": cameras, "MAX_SEGMENTS": rng.randint(4, 16), "MAX_KEYFRAMES": keyframes, "MAX_LANDMARKS": landmarks,
            "MAX_OBSERVATIONS": rng.randint(6, 14) * landmarks * cameras, "MAX_IMU_SAMPLES": rng.randint(300, 2000), "MAX_CLONES": rng.randint(7, 12),
            "MAX_TRACKS": rng.randint(30, 100), "MAX_TIES": rng.choice([0, 4, 8]), "IMU_HISTORY": rng.randint(200, 1000), "PIXEL_BITS": rng.choice([16, 32]),
            "MAX_EFFECT_COLUMNS": rng.choice([0, 1, 3, 12]), "TRACK_WALK": rng.randint(0, 1), "FRAME_FEATURES": rng.randint(6, 30)}


def draw_small(rng):
    """One capacity far below that range: calibrated, refused or named, never silent."""
    small = {"MAX_SEGMENTS": 1, "MAX_KEYFRAMES": rng.randint(2, 5), "MAX_LANDMARKS": rng.randint(4, 12), "MAX_OBSERVATIONS": rng.randint(20, 60),
             "MAX_IMU_SAMPLES": rng.randint(20, 120), "MAX_CLONES": rng.randint(2, 5), "MAX_TRACKS": rng.randint(4, 12), "IMU_HISTORY": rng.randint(10, 80),
             "FRAME_FEATURES": 1}
    name = rng.choice(sorted(small))
    return {**draw(rng), name: small[name]}


def build(capacities, folder):
    """The program, or what the compiler says against these capacities."""
    definitions = ";".join(f"SEGCAL_{name}={value}" for name, value in capacities.items())
    configure = ["cmake", "-G", "Ninja", "-S", HERE / "program", "-B", folder, f"-DSEGCAL_TREE={HERE.parents[1]}", f"-DCAPACITIES={definitions}"]
    for command in configure, ["cmake", "--build", folder]:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return None, next((line.split("error: ", 1)[1] for line in done.stdout.splitlines() if "error: " in line), done.stderr[-3000:])
    return folder / "drawn_device", None


def quaternion(m):
    """w first, of a rotation matrix."""
    w = (1 + m[0][0] + m[1][1] + m[2][2]) ** 0.5 / 2
    return [w, *((m[a][b] - m[b][a]) / (4 * w) for a, b in ((2, 1), (0, 2), (1, 0)))]


def start_of(chain):
    lines = []
    for camera in yaml.safe_load(chain.read_text()).values():
        T = camera["T_cam_imu"]
        numbers = [*quaternion(T), *(row[3] for row in T[:3]), *camera["intrinsics"], *camera["distortion_coeffs"], 0, 0, 0]
        lines.append(" ".join(map(repr, map(float, numbers))))
    return "\n".join(lines) + "\n"


def record(segcal, recording, cameras, rate, seed, seconds, scenario="rich", tracks=60):
    """A simulated device's session, and its start as drawn_device reads it."""
    shutil.rmtree(recording, ignore_errors=True)
    subprocess.run([segcal, "simulate", "--out", recording, "--scenario", scenario, "--seconds", str(seconds), "--seed", str(seed), "--rate-imu", str(rate),
                    "--cameras", str(cameras), "--tracks", str(tracks)], check=True, capture_output=True)
    (recording / "start").write_text(start_of(recording / "camchain-imucam.yaml"))


def run(program, recording, cameras, rate):
    """What drawn_device says of one simulated device."""
    tracks = [recording / f"mav0/cam{c}/tracks.csv" for c in range(cameras)]
    done = subprocess.run([program, str(rate), recording / "start", recording / "mav0/imu0/data.csv", *tracks], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        return {"died": done.returncode}
    said, parameters = {}, {}
    for word, *values in (line.split() for line in done.stdout.splitlines()):
        if word == "parameter":
            parameters[values[0]] = [float(v) for v in values[1:]]
        else:
            said[word] = " ".join(values)
    truth = json.loads((recording / "truth/truth.json").read_text())["parameters"]
    said["errors"] = {t["name"]: (parameters[t["name"]][0] - t["value"]) / parameters[t["name"]][1] for t in truth
                      if t["name"] in parameters and parameters[t["name"]][2] != 0}  # 0: fixed, stayed where it was
    said["sigmas"] = {name: values[1] for name, values in parameters.items()}
    return said


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--segcal", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--sets", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rates", type=int, nargs="+", default=RATES)
    parser.add_argument("--repeats", type=int, default=1, help="devices of each set and rate")
    parser.add_argument("--only", type=int, nargs="+", default=[], help="these of the sets")
    parser.add_argument("--with", dest="fixed", nargs="+", default=[], metavar="NAME=VALUE", help="in place of what is drawn")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--range", choices=["possible", "small"], default="possible")
    o = parser.parse_args()
    o.work.mkdir(parents=True, exist_ok=True)
    rng = random.Random(o.seed)
    runs = []
    with open(o.work / "runs.jsonl", "w", encoding="utf-8") as file:
        for s in range(o.sets):
            capacities = {**(draw if o.range == "possible" else draw_small)(rng), **dict(f.split("=") for f in o.fixed)}
            if o.only and s not in o.only:
                continue
            program, refusal = build(capacities, o.work / f"set{s}")
            for rate in o.rates:
                for repeat in range(o.repeats):
                    seed = ((100 * o.seed + s) * 10000 + rate) * 10 + repeat
                    said = {"not_built": refusal}
                    if program:
                        cameras = int(capacities["MAX_CAMERAS"])
                        record(o.segcal, o.work / "recording", cameras, rate, seed, o.seconds)
                        said = run(program, o.work / "recording", cameras, rate)
                    runs.append({"set": s, "rate": rate, "seed": seed, "capacities": capacities, **said})
                    print(judge(runs[-1]), flush=True)
                    file.write(json.dumps(runs[-1]) + "\n")
    return report(runs)


if __name__ == "__main__":
    os.environ.setdefault("CMAKE_BUILD_PARALLEL_LEVEL", "1")
    sys.exit(main())
