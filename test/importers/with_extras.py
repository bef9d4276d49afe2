"""Runs a test with the packages that `segcal import` asks for by a message only: in a virtual environment that is made once, by the lists that
the message names, beside what setup installs. Where no package index can be reached the test runs without, and says what it skips.
Usage: with_extras.py FOLDER TEST [ARGUMENT...]"""

import fcntl
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
LISTS = [SOURCE / "host_tools/importers" / f"requirements-{extra}.txt" for extra in ("video", "vrs")]


def made(folder):
    """Its Python, or None. The list of what is in it is written last: an interrupted run begins again."""
    python, done, wanted = folder / "bin/python", folder / "made.txt", "".join(file.read_text() for file in LISTS)
    if done.is_file() and done.read_text() == wanted:
        return python
    subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)
    packages = subprocess.run([python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], capture_output=True, text=True, check=True).stdout.strip()
    (Path(packages) / "setup.pth").write_text(sysconfig.get_path("purelib") + "\n")
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *(part for file in LISTS for part in ("-r", file))]
    if subprocess.run(install, check=False).returncode:
        return None
    done.write_text(wanted)
    return python


def main(folder, test, *arguments):
    folder.parent.mkdir(parents=True, exist_ok=True)
    with open(folder.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        python = made(folder)
    if python is None:
        print("no package index: without the extras", flush=True)
    python = str(python or sys.executable)
    os.execve(python, [python, "-B", test, *arguments], {**os.environ, "SEGCAL_PYTHON": python})


main(Path(sys.argv[1]), *sys.argv[2:])
