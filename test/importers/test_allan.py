"""`segcal allan`: known noise is found, a rest is found in a longer recording, and what is no rest is refused."""

import json
import os
from pathlib import Path

import numpy as np
import yaml

from support import SOURCE, Case, main, segcal

RATE = 100.0
DENSITY, WALK = (2e-3, 2e-2), (3e-4, 2e-3)  # gyroscope, accelerometer
HEADING = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"


def samples(seconds, seed, density=DENSITY, walk=WALK):
    """n x 6: white noise of density N has sigma N sqrt(rate), a walk K steps of K / sqrt(rate)."""
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    parts = [rng.normal(0, N * np.sqrt(RATE), (n, 3)) + np.cumsum(rng.normal(0, K / np.sqrt(RATE), (n, 3)), axis=0) for N, K in zip(density, walk)]
    return np.concatenate(parts, axis=1) + [0.01, 0, 0, 0, 0, 9.81]


class Allan(Case):
    def put(self, values, stamps=None):
        stamps = np.round(np.arange(len(values)) / RATE * 1e9).astype(np.int64) if stamps is None else stamps
        file = self.rec / "mav0/imu0/data.csv"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(HEADING + "".join(f"{t}," + ",".join(map(repr, row)) + "\n" for t, row in zip(stamps.tolist(), values.tolist())))

    def run_allan(self):
        return segcal("allan", self.rec, "--out", self.folder / "noise")

    def result(self):
        done = self.run_allan()
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / "noise/allan.json").read_text()), yaml.safe_load((self.folder / "noise/imu.yaml").read_text())

    def refused(self, words):
        done = self.run_allan()
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertIn(words, done.stderr)
        self.assertFalse((self.folder / "noise").exists())

    def test_white_noise_and_a_minute(self):
        """80 s without a walk: the densities to 5 %, and the walk's bound above the truth, which is none."""
        self.put(samples(80, 1, density=(1e-4, 2e-3), walk=(0, 0)))
        found, text = self.result()
        for sensor, N in (("gyro", 1e-4), ("accel", 2e-3)):
            for axis in found[sensor]["axes"]:
                self.assertLess(abs(axis["density"] / N - 1), 0.05)
            self.assertFalse(found[sensor]["walk_seen"])
            self.assertGreater(found[sensor]["walk"], 0)
        self.assertLess(abs(text["gyroscope_noise_density"] / 1e-4 - 1), 0.05)
        self.assertEqual(text["update_rate"], RATE)
        self.assertIn("Allan deviation", (self.folder / "noise/report.html").read_text())

    def test_walks(self):
        """1000 s. At 100 s of averaging ten values are left, so that one axis tells its walk to a third; the mean of six to 25 %."""
        self.put(samples(1000, 2, density=(1e-4, 2e-3), walk=(1e-5, 2e-4)))
        found, text = self.result()
        ratios = [axis["walk"] / K for sensor, K in (("gyro", 1e-5), ("accel", 2e-4)) for axis in found[sensor]["axes"]]
        self.assertTrue(found["gyro"]["walk_seen"] and found["accel"]["walk_seen"])
        self.assertLess(abs(np.mean(ratios) - 1), 0.25, ratios)
        # The file is one that the other commands take.
        self.assertEqual(set(text) - {"rostopic", "update_rate"}, {f"{s}_{n}" for s in ("gyroscope", "accelerometer") for n in ("noise_density", "random_walk")})
        self.assertTrue(all(isinstance(v, (int, float)) for k, v in text.items() if k != "rostopic"), text)

    def test_a_rest_within_motion(self):
        values = samples(130, 3, density=(1e-4, 2e-3), walk=(0, 0))
        t = np.arange(len(values)) / RATE
        values[t < 40, 1] += 0.5 * np.sin(2 * t[t < 40])
        self.put(values)
        found, _ = self.result()
        self.assertLess(abs(found["start_s"] - 40), 1)
        self.assertLess(abs(found["gyro"]["density"] / 1e-4 - 1), 0.08)

    def test_refusals(self):
        still = samples(90, 4, density=(1e-4, 2e-3), walk=(0, 0))
        self.put(still[:3000])
        self.refused("too short: 30.0 s")
        t = np.arange(len(still)) / RATE
        self.put(still + 0.3 * np.sin(t)[:, None])
        self.refused("not at rest")
        stamps = np.round(t * 1e9).astype(np.int64)
        stamps[4000:] += 5_000_000_000
        self.put(still, stamps)
        self.refused("samples are missing")
        self.put(0 * still)
        self.refused("no noise")

    def test_real_recording(self):
        """euroc_mh01 rests for some 20 s after 16 s of motion: too short, and said so with its length."""
        data = Path(os.environ.get("SEGCAL_DATA") or SOURCE.parent / "shared" / "data") / "euroc_mh01"
        if not data.is_dir():
            self.skipTest(f"no {data}")
        done = segcal("allan", data, "--out", self.folder / "noise")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"not at rest: the longest rest takes \d\d\.\d s")


if __name__ == "__main__":
    main()
