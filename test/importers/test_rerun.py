"""`segcal export --to mcap` and `--to rerun`, read by rerun itself: its reader in Python, and its program, which checks and converts."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import unittest

import numpy as np
import yaml
from mcap.reader import make_reader
from PIL import Image
from session_case import SessionCase
from support import SOURCE, main, segcal

HAS_RERUN = importlib.util.find_spec("rerun") is not None
# rerun's program of another place, such as a fresh venv's bin/rerun, reads the MCAP file without the package.
PROGRAM = [os.environ["SEGCAL_RERUN"]] if os.environ.get("SEGCAL_RERUN") else [sys.executable, "-m", "rerun"] if HAS_RERUN else []
NEEDED = ".venv/bin/pip install -r host_tools/exporters/requirements-rerun.txt"


class Session(SessionCase):
    def test_rerun_is_an_extra(self):
        """Where it is not installed, which a package that cannot be imported stands for, one line says the command."""
        (self.folder / "rerun.py").write_text("raise ImportError('none', name='rerun')\n")
        done = segcal("export", self.out, "--to", "rerun", "--out", self.folder / "view", environment={"PYTHONPATH": str(self.folder)})
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        command = done.stderr.split("install it with: ")[1].split()
        self.assertEqual(command[:3], [".venv/bin/pip", "install", "-r"])
        self.assertIn("rerun-sdk==", (SOURCE / command[3]).read_text())
        self.assertFalse((self.folder / "view").exists())

    @unittest.skipUnless(HAS_RERUN, f"no package rerun: {NEEDED}")
    def test_rerun(self):
        """Read back by rerun's own reader."""
        from rerun import chunk
        done = segcal("export", self.out, "--to", "rerun", "--rec", self.rec, "--out", self.folder / "view")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = {}
        for part in chunk.RrdReader(str(self.folder / "view/session.rrd")).stream():
            for row in part.to_record_batch().to_pylist():
                found.setdefault(str(part.entity_path), []).append(row)

        def column(entity, name):
            return [(row["time"].value, row[name]) for row in found[entity]]

        table = np.loadtxt(self.rec / "mav0/imu0/data.csv", delimiter=",")
        for k, entity in enumerate(("/gyro/x", "/gyro/y", "/gyro/z", "/accel/x", "/accel/y", "/accel/z")):
            np.testing.assert_array_equal([v[0] for _, v in column(entity, "Scalars:scalars")], table[:, k + 1])
        stamps = np.loadtxt(self.rec / "mav0/imu0/data.csv", delimiter=",", dtype=str)[:, 0]
        self.assertEqual([t for t, _ in column("/gyro/x", "Scalars:scalars")], list(map(int, stamps)))
        self.assertEqual([(t, bytes(v[0])) for t, v in column("/world/imu/cam0/image", "EncodedImage:blob")], [(self.stamp, self.picture)])
        tracks = np.loadtxt(self.rec / "mav0/cam0/tracks.csv", delimiter=",", dtype=str, skiprows=1)
        points = [(t, *p) for t, marks in column("/world/imu/cam0/tracks", "Points2D:positions") for p in marks]
        np.testing.assert_allclose(points, [(int(t), float(u), float(v)) for t, _, u, v in tracks], rtol=1e-6)  # float
        poses = np.loadtxt(self.out / "trajectory.tum")
        np.testing.assert_allclose([v[0] for _, v in column("/world/imu", "Transform3D:translation")], poses[:, 1:4], atol=1e-6)
        camera = yaml.safe_load((self.out / "camchain-imucam.yaml").read_text())["cam0"]
        rows = found["/world/imu/cam0"]
        mount = next(r["Transform3D:translation"] for r in rows if r.get("Transform3D:translation"))
        np.testing.assert_allclose(mount[0], np.array(camera["T_imu_cam"])[:3, 3], atol=1e-6)
        K = np.reshape(next(r["Pinhole:image_from_camera"] for r in rows if r.get("Pinhole:image_from_camera"))[0], (3, 3)).T  # by columns
        np.testing.assert_allclose([K[0, 0], K[1, 1], K[0, 2], K[1, 2]], camera["intrinsics"], rtol=1e-6)
        result = json.loads((self.out / "result.json").read_text())
        self.assertEqual(len(found["/world/map"]), sum(s["kept"] for s in result["segments"]))
        self.assertIn("parameters observed", found["/log"][0]["TextLog:text"][0])


@unittest.skipUnless(PROGRAM, f"no rerun: SEGCAL_RERUN=.../bin/rerun names one, or {NEEDED}")
class Program(SessionCase):
    """The image here is one that can be decoded: rerun looks into it."""

    def setUp(self):
        super().setUp()
        Image.fromarray(np.random.default_rng(3).integers(0, 256, (480, 640), np.uint8)).save(self.rec / "mav0/cam0/data/a.png")
        (self.folder / "home").mkdir()

    def rerun(self, *arguments):
        """What it printed; exit code 0. It keeps its settings, and what it counts of its use, below the home folder."""
        home = str(self.folder / "home")
        done = subprocess.run([*PROGRAM, *map(str, arguments)], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              env={**os.environ, "HOME": home, "XDG_CONFIG_HOME": home, "NO_COLOR": "1"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotIn("ERROR", done.stderr)
        return done.stdout

    def exported(self, to, file):
        done = segcal("export", self.out, "--to", to, "--rec", self.rec, "--out", self.folder / to)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / to / file

    def rows(self, rrd):
        """Rows by entity and column that carry content, of `rerun rrd print`: not those that describe an MCAP file."""
        found = {}
        for rows, entity, columns in re.findall(r"with ([\d ]+) rows \(.*\) - (\S+) - data columns: \[(.*)\]", self.rerun("rrd", "print", rrd)):
            for column in columns.split():
                if not column.startswith(("McapChannel", "McapSchema", "McapStatistics")):
                    found[entity, column] = found.get((entity, column), 0) + int(rows.replace(" ", ""))
        return found

    def test_mcap(self):
        """No issue in any channel, and as many rows of each as the file has messages; of their contents those that rerun has a picture for."""
        file = self.exported("mcap", "session.mcap")
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
        messages = {summary.channels[i].topic: n for i, n in summary.statistics.channel_message_counts.items()}
        report = self.rerun("mcap", "check", "--full", file)
        self.assertEqual(sorted(re.findall(r"^ok +\d+ +\d+ +(/\S+) +—$", report, re.M)), sorted(messages), report)
        converted = self.folder / "converted.rrd"
        self.rerun("mcap", "convert", file, "-o", converted)
        self.rerun("rrd", "verify", converted)
        rows = self.rows(converted)
        for topic, column in (("/tf", "Transform3D:translation"), ("/path", "InstancePoses3D:translations"), ("/map", "Points3D:positions"),
                              ("/map", "InstancePoses3D:translations"), ("/cam0/calibration", "Pinhole:image_from_camera"), ("/cam0/image", "EncodedImage:blob"),
                              ("/cam0/tracks", "foxglove.ImageAnnotations:message"), ("/imu", "McapMessage:data"), ("/log", "TextLog:text")):
            self.assertEqual(rows.get((topic, column)), messages[topic], (topic, column))

    def test_a_damaged_file_is_seen(self):
        """That exit code 0 above says something."""
        file = self.exported("mcap", "session.mcap")
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
        with self.assertRaises(AssertionError):
            self.rerun("mcap", "convert", file, "-o", self.folder / "converted.rrd")
            self.rerun("rrd", "verify", self.folder / "converted.rrd")

    @unittest.skipUnless(HAS_RERUN, f"no package rerun: {NEEDED}")
    def test_rrd(self):
        file = self.exported("rerun", "session.rrd")
        self.rerun("rrd", "verify", file)
        rows = self.rows(file)
        samples = len(np.loadtxt(self.rec / "mav0/imu0/data.csv", delimiter=","))
        poses = len(np.loadtxt(self.out / "trajectory.tum"))
        stamps = np.loadtxt(self.rec / "mav0/cam0/tracks.csv", delimiter=",", dtype=str, skiprows=1)[:, 0]
        kept = sum(s["kept"] for s in json.loads((self.out / "result.json").read_text())["segments"])
        for entity, column, count in [(f"/{s}/{a}", "Scalars:scalars", samples) for s in ("gyro", "accel") for a in "xyz"] + [
                ("/world/imu", "Transform3D:translation", poses), ("/world/path", "LineStrips3D:strips", 1), ("/world/map", "Points3D:positions", kept),
                ("/world/imu/cam0", "Pinhole:image_from_camera", 1), ("/world/imu/cam0/image", "EncodedImage:blob", 1),
                ("/world/imu/cam0/tracks", "Points2D:positions", len(set(stamps)))]:
            self.assertEqual(rows.get((entity, column)), count, (entity, column))


if __name__ == "__main__":
    main()
