"""The README's way from a log of one's own to a calibration: `segcal import`, `track`, `replay`."""

import json
import os
import unittest

import numpy as np
import yaml

from bags import Bag
from support import Case, images_of, imu_of, main, pixels, segcal


@unittest.skipUnless(os.environ.get("SEGCAL_LONG"), "renders 501 images, minutes: SEGCAL_LONG=1")
class ThreeCommands(Case):
    def test_a_log_with_images_to_a_calibration(self):
        """The README's: import, track, replay of an MCAP file with IMU, images, camera_info and /tf_static, by their own defaults."""
        made = self.folder / "made"
        segcal("simulate", "--out", made, "--scenario", "rich", "--seconds", 25, "--rate-camera", 20, "--distortion", "radtan", "--seed", 5, "--images")
        camera = yaml.safe_load((made / "camchain-imucam.yaml").read_text())["cam0"]
        (fx, fy, cx, cy), T = camera["intrinsics"], np.array(camera["T_cam_imu"])
        stamps, values = imu_of(made)
        with Bag(self.folder, "mcap") as bag:
            first = int(stamps[0])
            half = np.sqrt(1 + np.trace(T[:3, :3])) / 2  # quaternion of T's rotation, w first
            wxyz = (half, *(np.array([T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]]) / (4 * half)))
            bag.fixed_transform(first, "camera", "imu", wxyz, T[:3, 3])
            bag.camera_info("/cam0/camera_info", first, camera["resolution"], [fx, 0, cx, 0, fy, cy, 0, 0, 1], [*camera["distortion_coeffs"], 0], "plumb_bob")
            for t_ns, row in zip(stamps.tolist(), values):
                bag.imu("/imu/data", t_ns, row[:3], row[3:6])
            for t_ns, file in images_of(made):
                bag.image("/cam0/image_raw", t_ns, pixels(file), "mono8")
        self.converted(bag.storage)
        for command in (("track", self.rec), ("replay", self.rec, "--out", self.folder / "out")):
            done = segcal(*command)
            self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads((self.folder / "out/result.json").read_text())
        truth = {p["name"]: p["value"] for p in json.loads((made / "truth/truth.json").read_text())["parameters"]}
        self.assertEqual(result["status"], "calibrated")
        far = {p["name"]: (p["value"] - truth[p["name"]]) / p["sigma"] for p in result["parameters"] if p["verdict"] == "observed"}
        self.assertGreater(len(far), 14)
        self.assertLess(max(map(abs, far.values())), 5, far)  # `calibrated` with an entry beyond 5 sigma is a wrong answer


if __name__ == "__main__":
    main()
