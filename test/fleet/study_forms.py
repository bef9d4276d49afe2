"""Simulated devices whose truth is known: nothing changes, a step, a trend, a dependence on temperature, and one where temperature rises with
time. Are they told apart, and is nothing else named? Not a test of the workflow: it takes minutes.   study_forms.py SEGCAL FOLDER [DEVICES]"""

import collections
import pathlib
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "host_tools"
sys.path.insert(0, str(TOOLS / "fleet"))
import evidence

SEGCAL, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
DEVICES = int(sys.argv[3]) if len(sys.argv) > 3 else 15
SEED, LOGS, SECONDS, FIRST = 1, 8, 25, 4
KINDS = "nothing", "step", "trend", "temperature", "rising"
# Of a block: direction of the shift, its size as a step, per log and per degC. A log alone tells r_CI to 0.5 mrad, f to 0.12 px, gyro.s to 2e-4.
BLOCKS = {"cam0.r_CI": ((1, 0, 0), 3e-3, 6e-4, 1e-4), "cam0.f": ((1, 1), 1.0, 0.2, 0.03), "gyro.s": ((0, 1, 0), 1.5e-3, 3e-4, 4e-5)}
NAMED = {"cam0.r_CI": "cam0.r_CI", "cam0.f": "cam0.focal length and centre", "gyro.s": "gyro.scale"}


def kind_of(device):
    return KINDS[device % len(KINDS)]


def block_of(device):
    return list(BLOCKS)[device // len(KINDS) % len(BLOCKS)]


def share_of(device):
    """Of the sizes: the first fifteen devices have them whole, the next half, the next a quarter."""
    return 0.5 ** (device // (len(KINDS) * len(BLOCKS)))


def sizes_of(device):
    """(Direction of the shift, {form: step, or rate})"""
    direction, step, per_log, per_degC = BLOCKS[block_of(device)]
    return np.array(direction), {form: size * share_of(device) for form, size in (("step", step), ("trend", per_log), ("temperature", per_degC))}


def temperature_of(device, log):
    """At the log's begin, degC; it warms up by 4 degC, nearly all of it before the log's end."""
    return 10.0 + 4 * log if kind_of(device) == "rising" else np.random.default_rng([SEED, device, log]).uniform(5, 45)


def shift_of(device, log):
    direction, size = sizes_of(device)
    along = {"nothing": 0, "step": size["step"] * (log >= FIRST), "trend": size["trend"] * log}
    return direction * along.get(kind_of(device), size["temperature"] * (temperature_of(device, log) - 25))


def simulate(device, log):
    folder = FOLDER / "logs" / f"device_{device}" / f"session_{log}"
    if folder.exists():
        return
    begin = temperature_of(device, log)
    effect = f"calibration_shift={block_of(device)},0,{','.join(map(str, shift_of(device, log)))}"
    command = [SEGCAL, "simulate", "--out", folder, "--scenario", "rich", "--seconds", SECONDS, "--seed", 1000 * (SEED + device) + log, "--device-seed",
               device + 1, "--temperature", f"{begin},{begin + 4}", "--effect", effect]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def rows(name):
    return pq.read_table(FOLDER / "tables" / f"{name}.parquet").to_pylist()


def named():
    """{device: {(block, "form" or "form or form", first log of a step): rows}}"""
    out = collections.defaultdict(dict)
    for r in rows("changes"):
        forms = " or ".join([r["form"], *filter(None, r["or_form"].split(", "))])
        key = r["block"], forms, r["from_place"] if r["form"] == "step" else 0
        out[int(r["device"].split("-")[1]) - 1].setdefault(key, []).append(r)
    return out


def outcome(device, own):
    """(In a word, what was named beside it)"""
    kind = kind_of(device)
    truth = {"rising": {"temperature", "trend"}, "nothing": set()}.get(kind, {kind})
    mine = {key: set(key[1].split(" or ")) for key in own if key[0] == NAMED[block_of(device)] and (kind != "step" or key[2] == FIRST)}
    right = [key for key, forms in mine.items() if truth and forms == truth]
    tied = [key for key, forms in mine.items() if truth and forms > truth]
    hit = (right or tied)[:1]
    word = "right" if right or not (truth or own) else "tie with the truth in it" if tied else "another" if own else "not named"
    return word, hit, [key for key in own if key not in hit]


def errors(device, own, initial):
    """Of the sizes that were found, in sigmas. A shift of r_CI is a small rotation before it."""
    direction, size = sizes_of(device)
    form = own[0]["form"]
    direction = evidence.rotation_step(initial) @ direction if block_of(device) == "cam0.r_CI" else np.append(direction, np.zeros(4))
    return [((r["rate"] if r["step"] is None else r["step"]) - x * size[form]) / r["sigma"] for r, x in zip(own, direction)]


def main():
    for device in range(DEVICES):
        for log in range(LOGS):
            simulate(device, log)
    command = [SEGCAL, "fleet", FOLDER / "logs", "--out", FOLDER / "tables", "--jobs", "1", "--", "--segments", "6", "--segment-seconds", "4"]
    print(subprocess.run([*map(str, command)], capture_output=True, text=True, check=False).stdout)
    found, words, far = named(), collections.defaultdict(list), []
    rotation = {(r["device"], r["name"][-1]): r["value"] for r in rows("devices") if "r_CI" in r["name"]}
    for device in range(DEVICES):
        own = found.get(device, {})
        word, hit, others = outcome(device, own)
        words[share_of(device), kind_of(device)].append(word)
        for key in others:
            print(f"  beside: device {device} ({kind_of(device)} of {block_of(device)}): {key}, statistic {own[key][0]['statistic']:.1f}")
        far += [e for key in hit if word == "right" and kind_of(device) != "rising"
                for e in errors(device, own[key], [rotation[f"simulated-{device + 1}", axis] for axis in "xyz"])]
    for (share, kind), own in words.items():
        print(f"{share:5.2f} {kind:12}", dict(collections.Counter(own)))
    print(f"(error / sigma)^2 of the sizes: mean {np.mean(np.square(far)):.2f}, {len(far)} of them")
    print("not calibrated:", sum(r["status"] != "calibrated" for r in rows("runs")), "of", len(rows("runs")))
    print(*(f"{r['device']}: {r['sentence']}" for r in rows("attention") if r["kind"] in ("change", "outlier", "misfit")), sep="\n")


main()
