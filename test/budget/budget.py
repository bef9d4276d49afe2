#!/usr/bin/env python3
"""Collects what measure.py wrote into budget.json and budget.md, and judges it.

usage: budget.py --fixtures FOLDER --out FOLDER [--open-limits] [--keep] MEASURED.json...

Red, exit code 1:
 - a figure is over its limit (FOLDER/limits.json), unless it is listed there under "open": those are printed, and red with
   --open-limits only; an open limit that is met must leave the list;
 - a figure is more than 2 % worse than the number kept in FOLDER/kept.json;
 - results that must be of equal bits are not;
 - theta is further than 0.05 sigma from the double build's.
--keep writes today's figures to kept.json instead of comparing with them: for a commit that says why."""
import argparse
import json
import pathlib
import sys

WORSE = 1.02
THETA_LIMIT = 0.05  # sigmas


def key_of(measured):
    return " ".join(measured[k] for k in ("target", "profile", "optimisation"))


def figures(measured):
    """Flat: "stack_bytes.proven" and so on; what was not measured is left out."""
    flat = {"state_bytes": measured["state_bytes"], "hot_bytes": measured["hot_bytes"], "code_bytes": measured["code_bytes"]}
    flat |= {f"stack_bytes.{k}": v for k, v in measured["stack_bytes"].items()}
    flat |= {f"instructions.{k}": v for k, v in (measured["instructions"] or {}).items()}
    return {k: v for k, v in flat.items() if v is not None}


def check_limits(all_measured, limits, open_limits):
    red, open_notes = [], []
    unmet = {tuple(entry) for entry in limits["open"]}
    seen = set()
    for measured in all_measured:
        key, values = key_of(measured), figures(measured)
        for name, limit in limits["limits"].get(key, {}).items():
            if name not in values:
                red.append(f"{key}: {name} has a limit and was not measured")
            elif values[name] > limit and (key, name) in unmet:
                open_notes.append(f"{key}: {name} is {values[name]:,}, wanted {limit:,}")
            elif values[name] > limit:
                red.append(f"{key}: {name} is {values[name]:,}, the limit is {limit:,}")
            elif (key, name) in unmet:
                red.append(f"{key}: {name} meets its limit of {limit:,}; take it off the open ones in limits.json")
            seen.add((key, name))
    keys = {key_of(m) for m in all_measured}
    red += [f"{k}: {n} is listed as open and has no limit" for k, n in sorted(unmet - seen) if k in keys]
    return red + (open_notes if open_limits else []), open_notes


def check_kept(all_measured, kept):
    red = []
    for measured in all_measured:
        before = kept.get(key_of(measured))
        if before is None:
            red.append(f"{key_of(measured)}: no kept figures; run with --keep")
            continue
        for name, value in figures(measured).items():
            if name not in before:
                red.append(f"{key_of(measured)}: {name} is not among the kept figures")
            elif value > before[name] * WORSE:
                red.append(f"{key_of(measured)}: {name} went from {before[name]:,} to {value:,} ({value / before[name] - 1:+.1%})")
    return red


def check_bits(all_measured):
    """One hash per profile, whatever the target and optimisation. The double build is another arithmetic."""
    red, hashes = [], {}
    for measured in all_measured:
        hashes.setdefault(measured["profile"], {}).setdefault(measured["result_hash"], []).append(key_of(measured))
    for profile, found in hashes.items():
        if len(found) > 1:
            red.append(f"profile {profile}: results differ: " + "; ".join(f"{h}: {', '.join(k)}" for h, k in found.items()))
    return red


def worst_theta(measured, reference):
    pairs = [(abs(p["value"] - reference["theta"][name]["value"]) / p["sigma"], name) for name, p in measured["theta"].items()
             if p["sigma"] > 0]
    return max(pairs)


def check_theta(all_measured):
    red = []
    for reference in (m for m in all_measured if m["profile"].endswith("_double")):
        for measured in all_measured:
            if measured["profile"] + "_double" != reference["profile"]:
                continue
            distance, name = worst_theta(measured, reference)
            measured["theta_from_double_sigma"] = round(distance, 4)
            if not distance <= THETA_LIMIT:
                red.append(f"{key_of(measured)}: {name} is {distance:.3f} sigma from the double build's, at most {THETA_LIMIT}")
    return red


def table(all_measured, kept, limits):
    lines = ["# Budget", "", "The recorded session (fixtures/firmware/session.bin) on each target; in brackets the change against",
             "fixtures/budget/kept.json. Instructions are counted by QEMU, they are not cycles.", ""]
    for measured in all_measured:
        key = key_of(measured)
        limit_of, before = limits["limits"].get(key, {}), kept.get(key, {})
        lines += [f"## {key}", "", f"result_hash {measured['result_hash']}" + (
            f", theta within {measured['theta_from_double_sigma']} sigma of the double build" if "theta_from_double_sigma" in measured else ""),
                  "", "| figure | value | change | limit |", "|---|---:|---:|---:|"]
        for name, value in figures(measured).items():
            change = f"{value / before[name] - 1:+.2%}" if before.get(name) else ""
            over = " **open**" if name in limit_of and value > limit_of[name] else ""
            lines.append(f"| {name} | {value:,} | {change} | {limit_of[name]:,}{over} |" if name in limit_of else
                         f"| {name} | {value:,} | {change} | |")
        lines.append("")
    return "\n".join(lines)


def write(args, all_measured, kept, limits):
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "budget.md").write_text(table(all_measured, kept, limits))
    targets = [{k: v for k, v in m.items() if k != "theta"} for m in all_measured]
    (args.out / "budget.json").write_text(json.dumps({"format": 1, "targets": targets}, indent=1) + "\n")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", nargs="+", type=pathlib.Path)
    parser.add_argument("--fixtures", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--open-limits", action="store_true")
    parser.add_argument("--keep", action="store_true")
    return parser.parse_args()


def main():
    args = arguments()
    all_measured = [json.loads(path.read_text()) for path in args.measured]
    limits = json.loads((args.fixtures / "limits.json").read_text())
    kept_path = args.fixtures / "kept.json"
    kept = json.loads(kept_path.read_text()) if kept_path.exists() else {}
    if args.keep:
        kept |= {key_of(m): figures(m) for m in all_measured}
        kept_path.write_text(json.dumps(kept, indent=1) + "\n")
    red, open_notes = check_limits(all_measured, limits, args.open_limits)
    red += check_kept(all_measured, kept) + check_bits(all_measured) + check_theta(all_measured)
    write(args, all_measured, kept, limits)
    print((args.out / "budget.md").read_text())
    for note in open_notes:
        print("OPEN LIMIT, not met yet:", note)
    for line in red:
        print("RED:", line)
    sys.exit(1 if red else 0)


if __name__ == "__main__":
    main()
