"""Prints the calibration table of a result.json: value, sigma, start and verdict of each parameter."""

import json
import sys


def row(parameter):
    name, unit = parameter["name"], parameter.get("unit", "")
    start = parameter.get("initial")
    start = f"{start:12.6g}" if isinstance(start, (int, float)) else " " * 12
    return f"  {name:<16}{parameter['value']:12.6g} +- {parameter['sigma']:<9.2g} {unit:<6} start {start}  {parameter['verdict']}"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        result = json.load(file)
    print(f"\ncalibration: {result['status']}")
    for parameter in result["parameters"]:
        print(row(parameter))
    for blind in result.get("unobservable", []):
        parts = sorted(blind["direction"].items(), key=lambda entry: -abs(entry[1]))
        print("  not excited: " + " ".join(f"{weight:+.2f} {name}" for name, weight in parts[:4]))
    fit = result["fit"]
    if fit.get("dof"):
        print(f"  chi2/dof {fit['chi2'] / fit['dof']:.3f}, reprojection rms {fit['reprojection_rms_px']:.3f} px")


if __name__ == "__main__":
    main()
