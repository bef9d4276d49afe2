"""Runs `segcal` as a user does, and reads the recordings that it made. The environment gives the program: SEGCAL_PROGRAM."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

PROGRAM = os.environ["SEGCAL_PROGRAM"]
SOURCE = Path(__file__).resolve().parents[2]


def segcal(*arguments, environment=None):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, stdin=subprocess.DEVNULL, env={**os.environ, **(environment or {})})


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="segcal_import_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.rec = self.folder / "rec"

    def converted(self, *arguments):
        """What `segcal import ... --out rec` said; it must succeed."""
        done = segcal("import", *arguments, "--out", self.rec)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def refused(self, words, *arguments):
        """Exit code 2, one line with these words, nothing written, nothing left beside it."""
        before = sorted(self.folder.rglob("*"))
        done = segcal("import", *arguments)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(sorted(self.folder.rglob("*")), before)


def imu_of(rec):
    """(stamps, n x 6 values), text to the nearest double."""
    rows = [line.split(",") for line in (rec / "mav0/imu0/data.csv").read_text().splitlines() if not line.startswith("#")]
    return np.array([int(r[0]) for r in rows]), np.array([[float(x) for x in r[1:]] for r in rows])


def images_of(rec, camera=0):
    """[(stamp, file)]"""
    folder = rec / f"mav0/cam{camera}"
    rows = [line.split(",") for line in (folder / "data.csv").read_text().splitlines() if not line.startswith("#")]
    return [(int(t), folder / "data" / name) for t, name in rows]


def pixels(file):
    with Image.open(file) as image:
        return np.array(image)


def tree_bytes(folder):
    return {str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()}


def tumbling(seconds=20, rate_hz=200, seed=1):
    """Stamps, rates [rad/s] and specific force [m/s^2] of a device that is turned about all axes in place."""
    n = int(seconds * rate_hz)
    t = np.arange(n) / rate_hz
    phase = np.random.default_rng(seed).uniform(0, 6, 3)
    w = np.stack([1.2 * np.sin(2.1 * t + phase[0]), 0.9 * np.sin(1.3 * t + phase[1]), 0.7 * np.sin(1.7 * t + phase[2])], axis=1)
    up = np.zeros((n, 3))
    up[0] = (0, 0, 1)
    for k in range(n - 1):  # d up / dt = -w x up, small steps
        up[k + 1] = up[k] - np.cross(0.5 * (w[k] + w[k + 1]), up[k]) / rate_hz
        up[k + 1] /= np.linalg.norm(up[k + 1])
    return 1_700_000_000_000_000_000 + np.round(t * 1e9).astype(np.int64), w, 9.81 * up


def main():
    unittest.main(argv=sys.argv, verbosity=1)
