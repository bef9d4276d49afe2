"""A simulated fleet with known truth: are fused sigmas honest, and are the devices named that changed or have another lens, and no other?
Not a test of the workflow: it takes minutes.   study_fleet.py SEGCAL FOLDER [DEVICES [LOGS]]"""

import json
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyarrow.parquet as pq
from scipy.stats import chi2, kstest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "host_tools"
sys.path[:0] = [str(TOOLS / "fleet"), str(TOOLS / "common")]
import judge
import work

SEGCAL, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
DEVICES, LOGS = (int(sys.argv[3]) if len(sys.argv) > 3 else 50), (int(sys.argv[4]) if len(sys.argv) > 4 else 20)
# By device: what its later half of logs has, or all of them.
SHOCKS = {0: "cam0.r_CI,0,0.01,0,0", 1: "cam0.p_CI,0,0,0.01,0", 2: "gyro.s,0,0.005,0,0", 3: "accel.r_AI,0,0,0.01,0", 4: "cam0.f,0,4,4"}
LENSES = {5: "0.1,0.3,0.2", 6: "0.15,0.3,0.2", 7: "0.1,-0.3,0.3"}


def simulate(case):
    device, log = case
    folder = FOLDER / "logs" / f"device_{device}" / f"session_{log}"
    if folder.exists():
        return
    effect = []
    if device in SHOCKS and log >= LOGS // 2:
        effect = ["--effect", f"calibration_shift={SHOCKS[device]}"]
    if device in LENSES:
        effect = ["--effect", f"outside:decentred_distortion={LENSES[device]}"]
    command = [SEGCAL, "simulate", "--out", folder, "--scenario", "rich", "--seconds", 17, "--seed", 1000 * device + log + 1, "--device-seed",
               device + 1, *effect]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def truth_of(device):
    """Of the device as it is at the end."""
    content = json.loads((FOLDER / "logs" / f"device_{device}" / "session_0" / "truth" / "truth.json").read_text())
    return {p["name"]: p["value"] for p in content["parameters"]}


def rows(name):
    return pq.read_table(FOLDER / "tables" / f"{name}.parquet").to_pylist()


def fused_devices():
    """With their covariances, which the tables leave out."""
    keys = sorted(rows("runs"), key=lambda r: (r["device"], r["place"]))
    entries = [{"log": r["log"], "key": r["key"]} for r in keys]
    fused, _ = judge.fuse_devices(judge.runs_of(entries, work.Store(str(FOLDER / "tables")), None))
    return {int(d.device.split("-")[1]) - 1: d.fit for d in fused}


def scatter_by_chance(devices):
    """e' C^-1 e of each device, against chi-square; and how many devices lie in 0.8..1.3 if errors are drawn from their covariances: the
    mean of (error / sigma)^2 then is a sum of chi-squares of one degree of freedom, weighted by the eigenvalues of the correlations."""
    squares, shares = [], []
    for device, fit in fused_devices().items():
        if device not in devices:
            continue
        truth, C = truth_of(device), fit.covariance
        e, sigma = fit.value - [truth[name] for name in fit.names], np.sqrt(np.diag(C))
        squares.append(e @ np.linalg.solve(C, e))
        weights = np.linalg.eigvalsh(C / np.outer(sigma, sigma)) / len(e)
        drawn = np.random.default_rng(0).standard_normal((20000, len(e))) ** 2 @ weights
        shares.append(np.mean((drawn > 0.8) & (drawn < 1.3)))
    n = len(e)
    print(f"e' C^-1 e / {n}: mean {np.mean(squares) / n:.3f}, chi-square with p = {kstest(chi2.cdf(squares, n), 'uniform').pvalue:.2f}; "
          f"{np.mean(shares):.0%} of devices in 0.8..1.3 by chance")


def main():
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(simulate, [(d, n) for d in range(DEVICES) for n in range(LOGS)]))
    command = [SEGCAL, "fleet", FOLDER / "logs", "--out", FOLDER / "tables", "--", "--segments", "4", "--segment-seconds", "4"]
    subprocess.run([*map(str, command)], check=False)
    squares = {}
    for device in range(DEVICES):
        if device in LENSES or device in SHOCKS:
            continue
        truth = truth_of(device)
        own = [r for r in rows("devices") if r["device"] == f"simulated-{device + 1}"]
        squares[device] = [((r["value"] - truth[r["name"]]) / r["sigma"]) ** 2 for r in own]
    each = np.array([np.mean(s) for s in squares.values()])
    print(f"(error / sigma)^2: mean {np.mean([x for s in squares.values() for x in s]):.3f} over {len(squares)} devices; of single devices "
          f"{each.min():.2f} to {each.max():.2f}, {np.mean((each > 0.8) & (each < 1.3)):.0%} in 0.8..1.3")
    scatter_by_chance(set(squares))
    for kind, truly in (("change", set(SHOCKS)), ("misfit", set(LENSES)), ("outlier", set())):
        named = {int(r["device"].split("-")[1]) - 1 for r in rows("attention") if r["kind"] == kind}
        print(f"{kind}: {len(named & truly)} of {len(truly)} named, others: {sorted(named - truly)}")
    print("changes:", sorted({(r["device"], r["block"], r["from_place"]) for r in rows("changes")}))
    print("seconds of replay per log, median:", np.median([r["seconds"] for r in rows("times")]))


main()
