"""The memory table of README.md against what the program says. Usage: readme_memory.py SEGCAL README FOLDER"""

import pathlib
import re
import subprocess
import sys

segcal, readme, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])


def run(*arguments):
    return subprocess.run([segcal, *map(str, arguments)], capture_output=True, text=True, check=False).stdout


run("simulate", "--out", folder / "rec", "--seconds", 10)
wrong = []
for profile in ("mcu", "mobile", "host"):
    row = re.search(rf"^\| {profile} \|.*$", readme.read_text(), re.M)[0]
    stated = [number.replace(",", "") for number in re.findall(r"\d[\d,]+", row)[-3:]]
    said = re.findall(r"\d+", re.search(r"state_bytes.*?\)", run("replay", folder / "rec", "--out", folder / profile, "--profile", profile))[0])
    if stated != said:
        wrong.append(f"{profile}: README has {stated}, the program {said} (state, segment, workspace)")
sys.exit("\n".join(wrong) or 0)
