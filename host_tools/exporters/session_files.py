"""What a session is made of, from the folders of `segcal replay` and of its recording; for viewers."""

import csv
import json
import sys
from pathlib import Path

import numpy as np

from input_error import InputError

sys.path.append(str(Path(__file__).resolve().parent.parent / "report"))
import health  # noqa: E402

NEAR_M = 50  # landmarks further away have no place: their inverse distance is noise


def rows(file):
    """(stamp in ns, other columns) of a CSV file of a recording."""
    with open(file, newline="", encoding="utf-8") as lines:
        for number, row in enumerate(csv.reader(lines), start=1):
            if not row or row[0].startswith("#"):
                continue
            try:
                yield int(row[0]), row[1:]
            except ValueError:
                raise InputError(f"{file}:{number}: expected a stamp in ns") from None


def trajectory(file):
    """[(t_ns, p, q x y z w)]; stamps keep their nanoseconds."""
    poses = []
    for line in file.read_text().splitlines():
        if not line.startswith("#"):
            stamp, *values = line.split()
            seconds, nanoseconds = stamp.split(".")
            values = list(map(float, values))
            poses.append((int(seconds) * 10**9 + int(nanoseconds), values[:3], values[3:]))
    if not poses:
        raise InputError(f"{file}: expected poses; the odometry did not start")
    return poses


def landmarks(file):
    """(t_ns, points n x 3 in the world) of each kept segment, at its end."""
    for segment in json.loads(file.read_text())["segments"]:
        near = [mark for mark in segment["landmarks"] if mark["inverse_distance"] > 1 / NEAR_M]
        if near:
            points = [np.array(mark["anchor"]) + np.array(mark["direction"]) / mark["inverse_distance"] for mark in near]
            yield segment["keyframes"][-1]["t_ns"], np.array(points)


def sentences(folder):
    """(status, what happened in words)."""
    result = json.loads((folder / "result.json").read_text())
    return result["status"], health.sentences(result, result.get("faults") or {})


def images(camera_folder):
    """(t_ns, file) of those that are there."""
    if (camera_folder / "data.csv").exists():
        for t, (name, *_) in rows(camera_folder / "data.csv"):
            file = camera_folder / "data" / name.strip()
            if file.exists():
                yield t, file


def tracks(camera_folder):
    """(t_ns, [(u, v)]) of each image."""
    if not (camera_folder / "tracks.csv").exists():
        return
    stamp, points = None, []
    for t, (_, u, v) in rows(camera_folder / "tracks.csv"):
        if stamp is not None and t != stamp:
            yield stamp, points
            points = []
        stamp = t
        points.append((float(u), float(v)))
    if points:
        yield stamp, points


def imu(recording):
    """(t_ns, rotation rate, specific force)."""
    for t, values in rows(recording / "mav0" / "imu0" / "data.csv"):
        yield t, list(map(float, values[:3])), list(map(float, values[3:6]))
