"""The runs of drawn_devices.py in figures: a line for each, then by rate, and what chance alone would give. Usage, of runs that are done:
summary.py WORK/runs.jsonl..."""

import json
import pathlib
import statistics
import sys

NORMAL = statistics.NormalDist()
LIMIT = 5  # sigmas: one in 1.7 million by chance
STATUS = {"-1": "no result", "0": "insufficient", "1": "calibrated", "2": "failed"}


def answer(run):
    """What the device says in the end, and whether a reason is with it."""
    if "died" in run:
        return f"ended with code {run['died']}", False
    if "not_built" in run:
        return f"does not compile: {run['not_built']}", False
    if "refused" in run:
        return f"refused: {run['refused']}", True
    if run["status"] == "1":
        return "calibrated", True
    health, words = run["health"].split(" ", 1)
    status = STATUS[run["status"]]
    return (f"{status}, health: {words}", True) if health != "0" else (f"{status}, health: runs", False)


def judge(run):
    errors = run.get("errors", {})
    line = f"set {run['set']:2} {run['rate']:5} Hz seed {run['seed']}: {answer(run)[0]}"
    if errors:
        name = max(errors, key=lambda n: abs(errors[n]))
        line += (f", {run['segments']} segments, {len(errors)} released, largest {abs(errors[name]):.2f} sigma ({name}), mean square "
                 f"{statistics.mean(e * e for e in errors.values()):.2f}, chi2/dof {run['chi2_per_dof']}, scale {run['noise_scale']}")
    return line


def figures(runs):
    calibrated = [r for r in runs if r.get("status") == "1"]
    errors = [abs(e) for r in calibrated for e in r["errors"].values()]
    beyond = sum(e > 3 for e in errors)
    silent = [r for r in runs if not answer(r)[1] and "not_built" not in r]
    return calibrated, errors, beyond, silent


def report(runs):
    """Prints the table. 1: a set does not compile, a run ended without an answer or a reason, or an entry is beyond what chance gives."""
    print("\n| IMU | runs | not built | calibrated | said why not | silent | entries | largest | beyond 3 sigma | mean (error/sigma)^2 |")
    print("|---" + "|---:" * 9 + "|")
    for rate in [*sorted({r["rate"] for r in runs}), None]:
        some = [r for r in runs if rate in (None, r["rate"])]
        calibrated, errors, beyond, silent = figures(some)
        unbuilt = sum("not_built" in r for r in some)
        named = len(some) - unbuilt - len(calibrated) - len(silent)
        row = [f"{rate} Hz" if rate else "all", len(some), unbuilt, len(calibrated), named, len(silent), len(errors)]
        if errors:
            row += [f"{max(errors):.2f} sigma", f"{beyond} ({100 * beyond / len(errors):.2f} %)", f"{statistics.mean(e * e for e in errors):.2f}"]
        print("| " + " | ".join(map(str, row)) + " |")
    n = len(errors)
    if n > 0:
        print(f"chance alone: {0.0027 * n:.1f} of {n} beyond 3 sigma (0.27 %), the largest {NORMAL.inv_cdf(1 - (1 - 0.5 ** (1 / n)) / 2):.2f} in the median")
    wrong = [r for r in calibrated if max(map(abs, r["errors"].values()), default=0) > LIMIT]
    unbuilt = {r["set"]: r for r in runs if "not_built" in r}.values()
    for r in [*unbuilt, *silent, *wrong]:
        print("LOOK AT", judge(r), r["capacities"], {k: v for k, v in r.items() if k not in ("errors", "capacities")}, sep="\n  ")
    return int(bool(unbuilt or silent or wrong))


if __name__ == "__main__":
    sys.exit(report([json.loads(line) for file in sys.argv[1:] for line in pathlib.Path(file).read_text().splitlines()]))
