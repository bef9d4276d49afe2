"""The trajectory errors of `segcal compare` against those of evo, on a simulated session replayed with two profiles.

Usage: compare_against_evo.py SEGCAL FOLDER. Exit code 77, with a line that says so, where evo is not installed.
"""

import json
import subprocess
import sys
from pathlib import Path

try:
    from evo.core import metrics, sync
    from evo.tools import file_interface
except ImportError as missing:
    print(f"SKIPPED: evo cannot be imported ({missing}); host_tools/setup.sh installs it. Nothing was checked.")
    sys.exit(77)

LENGTHS = (1.0, 5.0)  # m of path
# Both read the same decimals; what is left is the order of summation and arccos of evo near zero (1e-8 rad is 6e-7 deg).
RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 1e-6, 1e-6


def run(*arguments, codes=(0,)):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit(f"{' '.join(map(str, arguments))}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def make_results(segcal, folder):
    """Two trajectories of one session that differ by what a calibration changes."""
    recording = folder / "rec"
    run(segcal, "simulate", "--out", recording, "--scenario", "arvr", "--seconds", "40", "--seed", "3")
    run(segcal, "replay", recording, "--out", folder / "first", codes=(0, 1))
    calibrated = folder / "first" / "camchain-imucam.yaml"
    run(segcal, "replay", recording, "--calib", calibrated, "--out", folder / "second", codes=(0, 1))


def of_evo(metric, pair):
    metric.process_data(pair)
    return {name: metric.get_statistic(kind) for name, kind in (
        ("rmse", metrics.StatisticsType.rmse), ("median", metrics.StatisticsType.median), ("max", metrics.StatisticsType.max))}


def check(what, ours, theirs, unit):
    wrong = 0
    for name, expected in theirs.items():
        value = ours[f"{name}_{unit}"]
        if abs(value - expected) <= ABSOLUTE_TOLERANCE + RELATIVE_TOLERANCE * abs(expected):
            continue
        wrong += 1
        print(f"case: {what} {name}: segcal {value!r}, evo {expected!r} {unit}")
    print(f"{what}: rmse {theirs['rmse']:.6g} {unit}")
    return wrong


def check_alignment(segcal, folder, alignment):
    first, second = folder / "first", folder / "second"
    text = run(segcal, "compare", first, second, "--json", "--align", alignment, "--sigmas", "1e9", "--relative", *LENGTHS)
    ours = json.loads(text)["trajectories"][0]
    reference = file_interface.read_tum_trajectory_file(str(second / "trajectory.tum"))
    estimate = file_interface.read_tum_trajectory_file(str(first / "trajectory.tum"))
    reference, estimate = sync.associate_trajectories(reference, estimate, max_diff=1e-4)
    if estimate.num_poses != ours["poses"]:
        print(f"case: {alignment} poses: segcal {ours['poses']}, evo {estimate.num_poses}")
        return 1
    if alignment == "se3":
        estimate.align(reference)
    pair = (reference, estimate)
    wrong = check(f"{alignment} position", ours["position"], of_evo(metrics.APE(metrics.PoseRelation.translation_part), pair), "m")
    wrong += check(f"{alignment} attitude", ours["attitude"], of_evo(metrics.APE(metrics.PoseRelation.rotation_angle_deg), pair), "deg")
    for length, relative in zip(LENGTHS, ours["relative"]):
        options = dict(delta=length, delta_unit=metrics.Unit.meters, rel_delta_tol=0.1, all_pairs=True, pairs_from_reference=True)
        for name, relation, unit in (("position", metrics.PoseRelation.translation_part, "m"),
                                     ("attitude", metrics.PoseRelation.rotation_angle_deg, "deg")):
            metric = metrics.RPE(relation, **options)
            wrong += check(f"{alignment} over {length} m {name}", relative[name], of_evo(metric, pair), unit)
            if len(metric.error) != relative[name]["n"]:
                wrong += 1
                print(f"case: {alignment} over {length} m pairs: segcal {relative[name]['n']}, evo {len(metric.error)}")
    return wrong


def main(segcal, folder):
    make_results(segcal, folder)
    wrong = sum(check_alignment(segcal, folder, alignment) for alignment in ("none", "se3"))
    print(f"{wrong} differences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
