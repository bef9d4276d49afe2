"""A recording of made-up glasses in a file, with known samples, images and factory calibration."""

import importlib.util
import unittest

import numpy as np
import yaml
from support import Case, tumbling
from vrs_files import VrsFile, factory

SIZE = (64, 48)
BOOT_NS = 280_566_996_375  # the first stamp of a recording: ns since the device was switched on
NEEDED = "host_tools/importers/requirements-vrs.txt"
needs_vrs = unittest.skipUnless(importlib.util.find_spec("pyvrs"), f"no package vrs: .venv/bin/pip install -r {NEEDED}")
LENS = [30.0, 31.2, 24.6, -0.03, 0.1, -0.07, 0.01, 0.0, 0.0]  # f cx cy k0..k5: an equidistant lens
PLAIN, PRISM = [0.0] * 6, [0.004, -0.003, 0.006, -0.002, 0.005, 0.001]  # p0 p1 s0..s3
M_GYRO = np.array([[1.004, -0.002, 0.003], [0.011, 0.995, -0.004], [-0.006, 0.009, 1.002]])
M_ACCEL = np.array([[1.003, -0.001, -0.002], [0, 0.999, -0.003], [0, 0, 1.002]])
T_CAMERA = (0.6, 0.48, -0.64, 0.0), (0.01, -0.02, 0.005)  # unit quaternions
T_IMU = (0.5, -0.5, 0.5, 0.5), (0.0046, -0.102, -0.086)
LATE_S = 0.0041, 0.0028


def rotated(q, v):
    w, u = q[0], np.array(q[1:])
    return np.asarray(v) + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))


def calibration(size, rest=PLAIN):
    left, right = (M_GYRO, M_ACCEL, T_IMU, *LATE_S), (np.eye(3), np.eye(3), ((1, 0, 0, 0), (0, 0, 0)), 0.0, 0.0)
    cameras = {f"camera-slam-{side}": (LENS + rest, T_CAMERA) for side in ("left", "right")}
    return factory(size, cameras, {"imu-right": left, "imu-left": right})


class Aria(Case):
    def setUp(self):
        super().setUp()
        self.stamps, *values = tumbling(5)
        self.stamps += BOOT_NS - self.stamps[0]
        self.gyro, self.accel = (v.astype(np.float32) for v in values)
        self.file = self.folder / "run.vrs"
        self.image_stamps = self.stamps[10:200:20]
        self.images = [np.random.default_rng(k).integers(0, 256, SIZE[::-1], np.uint8) for k in range(len(self.image_stamps))]

    def put(self, calib=None, **imu_options):
        vrs = VrsFile(calib)
        vrs.imu("1202-1", self.stamps, self.gyro, self.accel, **imu_options)
        vrs.imu("1202-2", self.stamps + 77, self.accel * 0.1, self.accel)
        for number in (1, 2):
            vrs.camera(f"1201-{number}", self.image_stamps + 12 * (number - 1), self.images, SIZE)
        vrs.camera("214-1", self.image_stamps[::3], self.images, SIZE)
        vrs.camera("211-1", self.image_stamps, self.images, SIZE)
        vrs.write(self.file)
        return vrs

    def chain(self, name="camchain-imucam.yaml"):
        return yaml.safe_load((self.rec / name).read_text())
