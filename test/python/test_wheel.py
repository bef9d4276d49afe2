"""The wheel is built, installed into a fresh venv, and runs the README's example on simulated recordings: the same bits as `segcal replay`,
whatever optimisation either was compiled with.   Usage: test_wheel.py SEGCAL SOURCE_TREE FOLDER"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig

SEGCAL, SOURCE, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
PIP = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]

MORE = """
import numpy as np
result = device.result()
mean, covariance = result["mean"], result["covariance"]
sigma = np.array([p["sigma"] for p in result["parameters"]])
assert mean.shape == (26,) and covariance.shape == (26, 26) and np.allclose(np.sqrt(np.diag(covariance)), sigma, rtol=1e-6)
assert device.pose().shape == (7,) and abs(np.linalg.norm(device.pose()[3:]) - 1) < 1e-6
fresh = segcal.Device(rec.config)
assert fresh.result() is None and fresh.pose() is None
# Lists, other number types, a stamp that goes back, wrong shapes.
assert fresh.push_imu([10, 5], [[0, 0, 0]] * 2, np.zeros((2, 3), np.float32)) == 1
for bad in ([[0, 0]], [[0, 0, 0]] * 2):
    try:
        fresh.push_imu([20], bad, [[0, 0, 9.8]])
        raise SystemExit("a wrong shape was taken")
    except ValueError as error:
        assert "(n, 3)" in str(error), error
for what, error in (("nowhere", FileNotFoundError), ("broken", ValueError)):
    try:
        segcal.read(what)
        raise SystemExit(f"{what} was read")
    except error as reason:
        assert what in str(reason), reason
print("hash", device.result_hash())
print("from", segcal.__file__)
"""


def run(*command, **how):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, **how)
    assert done.returncode in (0, 1), done.stderr + done.stdout
    return done


def build():
    """-O1: half the time, and the bits must be the same. The build folder stays, so that a second run is quick."""
    made = run(*PIP, "wheel", "--no-build-isolation", "--no-deps", "-Ccmake.define.SEGCAL_OPTIMISATION=-O1", f"-Cbuild-dir={FOLDER / 'build'}",
               "-w", FOLDER / "wheel", SOURCE / "python")
    assert made.returncode == 0, made.stderr
    return next((FOLDER / "wheel").glob("segcal-*.whl"))


def installed(wheel):
    """The Python of a new venv with the wheel. There is no network here: what the wheel asks for must be in the project's own .venv, which a
    .pth file lets the new one see; pip fails where it is not."""
    venv = FOLDER / "venv"
    assert run(sys.executable, "-m", "venv", "--clear", "--without-pip", venv).returncode == 0
    python = venv / "bin" / "python"
    site = pathlib.Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").stdout.strip())
    (site / "project.pth").write_text(sysconfig.get_path("purelib") + "\n")
    done = run(*PIP, "--python", python, "install", "--no-index", wheel)
    assert done.returncode == 0, done.stderr
    assert (site / "segcal" / "py.typed").exists() and (site / "segcal" / "__init__.pyi").exists()
    return python, site


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(FOLDER / "wheel", ignore_errors=True)
    python, site = installed(build())
    example = re.search(r"```python\n(.*?)```", (SOURCE / "README.md").read_text(), re.DOTALL)[1]
    assert len(example.strip().splitlines()) <= 10
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    # The demo's recording, which is calibrated (host_tools/demo.sh), and a short one with the column of the temperature.
    for how, status in (("--scenario arvr --seconds 60", "calibrated"), ("--scenario rich --seconds 20 --temperature 25,30,5", None)):
        for name in ("rec", "out", "broken"):
            shutil.rmtree(FOLDER / name, ignore_errors=True)
        run(SEGCAL, "simulate", "--out", FOLDER / "rec", "--seed", 1, *how.split())
        run(SEGCAL, "replay", FOLDER / "rec", "--out", FOLDER / "out")
        shutil.copytree(FOLDER / "rec", FOLDER / "broken")
        (FOLDER / "broken" / "mav0" / "cam0" / "tracks.csv").write_text("#t\n1,2,three,4\n")
        said = run(python, "-c", example + MORE, cwd=FOLDER, env=environment)
        assert said.returncode == 0, said.stderr
        assert f"from {site}" in said.stdout, said.stdout
        result = json.loads((FOLDER / "out" / "result.json").read_text())
        assert f"hash {result['result_hash']}" in said.stdout, (result["result_hash"], said.stdout)
        assert result["parameters"][6]["name"] in said.stdout
        assert status is None or said.stdout.startswith(f"{status} "), said.stdout
    print("wheel: the README's example has the bits of segcal replay")


main()
