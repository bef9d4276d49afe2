"""result.json of a replay against docs/result.schema.json, and what a schema cannot say: the covariance is that of the sigmas, hashes are
those of the files.   Usage: test_result_schema.py SEGCAL SCHEMA FOLDER"""

import hashlib
import json
import pathlib
import shutil
import subprocess
import sys

import jsonschema
import numpy as np
import yaml

SEGCAL, SCHEMA, FOLDER = sys.argv[1], json.loads(pathlib.Path(sys.argv[2]).read_text()), pathlib.Path(sys.argv[3])
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def segcal(*arguments):
    return subprocess.run([SEGCAL, *map(str, arguments)], capture_output=True, text=True, check=False)


def digest(data):
    return hashlib.sha256(data).hexdigest()


def sum_of_folder(log):
    """As a shell would: sha256sum of the lines that sha256sum prints for the files that are read."""
    files = sorted(f.relative_to(log).as_posix() for f in log.rglob("*") if f.is_file())
    read = [f for f in files if f in ("camchain-imucam.yaml", "imu.yaml") or f.startswith(("mav0/imu0/", "mav0/cam0/"))]
    return digest("".join(f"{digest((log / f).read_bytes())}  {f}\n" for f in read).encode())


def simulate(name, *more):
    log = FOLDER / name
    made = segcal("simulate", "--out", log, "--scenario", "rich", "--seconds", 12, *more)
    assert made.returncode == 0, made.stderr
    return log


def replayed(out, *arguments):
    done = segcal("replay", *arguments, "--segments", 3, "--segment-seconds", 3, "--out", FOLDER / out)
    assert done.returncode in (0, 1), done.stderr
    return json.loads((FOLDER / out / "result.json").read_text())


def check_document(result):
    VALIDATOR.validate(result)
    unknown = set(result) - set(SCHEMA["properties"])
    assert not unknown, f"not in docs/result.schema.json: {sorted(unknown)}"


def check_covariance(result):
    sigma = np.array([p["sigma"] for p in result["parameters"]])
    covariance = np.array(result["covariance"]).reshape(len(sigma), len(sigma))
    assert len(sigma) == len(result["mean"]) == 26
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sigma, rtol=1e-6)  # the sigmas are float
    assert (covariance == covariance.T).all() and np.linalg.eigvalsh(covariance).min() > 0
    correlation = covariance / np.outer(sigma, sigma) - np.eye(26)
    assert 0.5 < abs(correlation).max() < 1, "a diagonal matrix tells nothing about directions"


def check_lines(out, result):
    lines = [json.loads(line) for line in (FOLDER / out / "calibration.jsonl").read_text().splitlines()]
    assert [line["status"] for line in lines] == [c["status"] for c in result["calibrations"]] and lines
    assert all(line["format"] == 1 and line["log_sha256"] == result["log_sha256"] for line in lines)
    last = {p["name"]: (p["value"], p["sigma"]) for p in lines[-1]["parameters"]}
    assert last == {p["name"]: (p["value"], p["sigma"]) for p in result["parameters"]}


def words_that_are_numbers(node, path=""):
    """Scalars that PyYAML (YAML 1.1, and so Kalibr) reads as words although they are numbers, as it does with 2e-05."""
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in children:
        yield from words_that_are_numbers(child, f"{path}/{key}")
    if isinstance(node, str):
        try:
            float(node)
            yield path, node
        except ValueError:
            pass


def check_yaml():
    """All YAML files that simulate and replay wrote, among them figures that print as 2e-05: a bias walk, a line delay."""
    files = sorted(FOLDER.rglob("*.yaml"))
    assert {f.name for f in files} == {"camchain-imucam.yaml", "config.yaml", "device.yaml", "imu.yaml", "model.yaml", "sensor.yaml"}, files
    for file in files:
        assert not list(words_that_are_numbers(yaml.safe_load(file.read_text()))), f"{file}: {list(words_that_are_numbers(yaml.safe_load(file.read_text())))}"
    assert yaml.safe_load((FOLDER / "one" / "imu.yaml").read_text())["gyroscope_random_walk"] == 2e-5
    assert list(words_that_are_numbers(yaml.safe_load("a: [1, 2e-05]"))) == [("/a/1", "2e-05")], "PyYAML reads it as a number now"


def check_refusals(result):
    """The schema must be able to say no."""
    broken = [{**result, "format": 1}, {**result, "status": "fine"}, {**result, "log_sha256": "ab"},
              {k: v for k, v in result.items() if k != "covariance"}, {**result, "parameters": [{"name": "cam0.fx"}]},
              {**result, "faults": {"imu_gaps": -1}}]
    for document in broken:
        assert not VALIDATOR.is_valid(document)


def check_notes():
    """A brief recording whose answer rests on one segment says so."""
    log = FOLDER / "brief"
    made = segcal("simulate", "--out", log, "--scenario", "arvr", "--seconds", 14, "--seed", 58)
    assert made.returncode == 0, made.stderr
    done = segcal("replay", log, "--out", FOLDER / "brief_out")
    assert done.returncode in (0, 1), done.stderr
    result = json.loads((FOLDER / "brief_out" / "result.json").read_text())
    check_document(result)
    assert "one_segment" in [note["name"] for note in result["health"]["notes"]]


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    cold, warm = simulate("cold", "--seed", 1), simulate("warm", "--seed", 2, "--device-seed", 1, "--temperature", "25,40,5")
    one = replayed("one", cold)
    check_document(one)
    check_covariance(one)
    check_lines("one", one)
    check_refusals(one)
    assert one["device_id"] == "simulated-1" and one["device_model"] == "simulated" and one["temperature_degC"] is None
    assert one["logs"] == [{"name": "cold", "sha256": sum_of_folder(cold)}] and one["log_sha256"] == sum_of_folder(cold)

    two = replayed("two", cold, warm, "--strategy", "multi", "--device-id", "bench 7", "--calib", cold / "camchain-imucam.yaml")
    check_document(two)
    assert two["device_id"] == "bench 7" and len(two["logs"]) == 2
    assert two["log_sha256"] == digest(f"{sum_of_folder(cold)}\n{sum_of_folder(warm)}\n".encode())
    low, high = two["temperature_degC"]
    assert 25 <= low < 26 and 38 < high <= 40, (low, high)  # 12 s with a time constant of 5 s: 91 % of the way
    assert two["configuration"]["calib_sha256"] == digest((cold / "camchain-imucam.yaml").read_bytes())
    assert two["configuration"]["strategy"] == "multi" and two["configuration"]["segments"] == 3

    check_notes()
    replayed("effects", cold, "--enable", "time_offset", "--enable", "rolling_shutter")
    check_yaml()

    still = replayed("none", cold, "--no-calibration")
    check_document(still)
    assert still["parameters"] == [] and still["covariance"] == []

    shutil.copytree(cold, FOLDER / "changed")
    (FOLDER / "changed" / "device.yaml").unlink()
    (FOLDER / "changed" / "imu.yaml").write_text((cold / "truth" / "imu.yaml").read_text())
    changed = replayed("changed_out", FOLDER / "changed", "--no-calibration")
    assert changed["log_sha256"] != one["log_sha256"] and changed["device_id"] is None
    print("result.json: as docs/result.schema.json says")


main()
