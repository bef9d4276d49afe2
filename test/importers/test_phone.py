"""`segcal import` of phone logs: tables and JSON lines, merging, stamps, units, axes."""

import json
import os
import shutil
from pathlib import Path

import numpy as np
from PIL import Image

from support import SOURCE, Case, imu_of, images_of, main, tumbling


def table(file, heading, stamps, values):
    rows = [",".join([str(t), *map(repr, row)]) for t, row in zip(stamps, values.tolist())]
    file.write_text("\n".join(([heading] if heading else []) + rows) + "\n")


class Tables(Case):
    def setUp(self):
        super().setUp()
        self.log = self.folder / "log"
        self.log.mkdir()
        self.stamps, self.gyro, self.accel = tumbling(10)

    def put(self, gyro_heading, accel_heading, gyro=None, accel=None, stamps=None, names=("gyro.csv", "accel.csv")):
        stamps = self.stamps if stamps is None else stamps
        table(self.log / names[0], gyro_heading, stamps, self.gyro if gyro is None else gyro)
        table(self.log / names[1], accel_heading, stamps, self.accel if accel is None else accel)

    def check(self, rtol=0.0):
        t_ns, values = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, self.stamps)
        np.testing.assert_allclose(values[:, :3], self.gyro, rtol=rtol, atol=0)
        np.testing.assert_allclose(values[:, 3:], self.accel, rtol=rtol, atol=0)

    def test_same_stamps_come_through_to_the_bit(self):
        self.put("#timestamp [ns],x [rad/s],y [rad/s],z [rad/s]", "#timestamp [ns],x [m/s^2],y [m/s^2],z [m/s^2]")
        self.converted(self.log)
        self.check()

    def test_stamps_from_zero(self):
        """A log that counts from its first sample. One stamp of zero among those of an epoch was never set."""
        self.stamps = self.stamps - self.stamps[0]
        self.put("#timestamp [ns],x [rad/s],y [rad/s],z [rad/s]", "#timestamp [ns],x [m/s^2],y [m/s^2],z [m/s^2]")
        self.converted(self.log)
        self.check()
        self.stamps = self.stamps + 1_700_000_000_000_000_000
        self.stamps[0] = 0
        self.put("#timestamp [ns],x [rad/s],y [rad/s],z [rad/s]", "#timestamp [ns],x [m/s^2],y [m/s^2],z [m/s^2]")
        self.refused("expected times of logging, found none that grow", self.log, "--out", self.folder / "other")

    def test_images_of_a_table(self):
        self.put("time,x,y,z", "time,x,y,z")
        folder = self.log / "camera" / "data"
        folder.mkdir(parents=True)
        names = []
        for k in range(0, 2000, 200):
            names.append((int(self.stamps[k]), f"{k}.png"))
            Image.fromarray(np.full((8, 12), k % 251, np.uint8)).save(folder / f"{k}.png")
        (self.log / "camera" / "frames.csv").write_text("timestamp [ns],filename\n" + "".join(f"{t},{n}\n" for t, n in names))
        self.converted(self.log, "--focal", 100, "--mount", "phone-back")
        listed = images_of(self.rec)
        self.assertEqual([t for t, _ in listed], [t for t, _ in names])
        for (_, file), (_, name) in zip(listed, names):
            self.assertEqual(file.read_bytes(), (folder / name).read_bytes())
        (folder / "400.png").unlink()
        self.refused("frames.csv:4: expected an image that exists", self.log, "--out", self.folder / "again")

    def test_exposures_of_a_table(self):
        """By a heading with a unit, as phones write it; without one they are left out, with a word."""
        self.put("time,x,y,z", "time,x,y,z")
        stamps = [int(t) for t in self.stamps[0:2000:200]]
        for k in range(len(stamps)):
            Image.fromarray(np.full((8, 12), k, np.uint8)).save(self.log / f"{k}.png")
        exposures = self.folder / "rec/mav0/cam0/exposure.csv"
        for heading, text, ns in (("Exposure time [nanosec]", "9999000", 9999000), ("exposure [ms]", "3.25", 3250000), ("exposure_us", "125", 125000)):
            with self.subTest(heading):
                (self.log / "frames.csv").write_text(f"timestamp [ns],filename,{heading}\n" + "".join(f"{t},{k}.png,{text}\n" for k, t in enumerate(stamps)))
                self.converted(self.log, "--focal", 100, "--mount", "phone-back")
                self.assertEqual(exposures.read_text(), "#timestamp [ns],exposure [ns]\n" + "".join(f"{t},{ns}\n" for t in stamps))
                shutil.rmtree(self.rec)
        (self.log / "frames.csv").write_text("timestamp [ns],filename,exposure\n" + "".join(f"{t},{k}.png,5\n" for k, t in enumerate(stamps)))
        self.assertIn("the exposure's unit is not in its heading", self.converted(self.log, "--focal", 100, "--mount", "phone-back").stderr)
        self.assertFalse(exposures.exists())
        (self.log / "frames.csv").write_text("timestamp [ns],filename,exposure [s]\n" + "".join(f"{t},{k}.png,{k}\n" for k, t in enumerate(stamps)))
        self.refused("frames.csv:4: expected an exposure of 0 (not known) to 1 s, found 2", self.log, "--focal", 100, "--mount", "phone-back", "--out", self.folder / "again")

    def test_headings_order_and_units(self):
        """Sensor Logger's order z, y, x; degrees and g by their headings; seconds with nine decimals stay exact."""
        seconds = [f"{t // 10**9}.{t % 10**9:09d}" for t in self.stamps.tolist()]
        self.put("time (s),z (deg/s),y (deg/s),x (deg/s)", "time (s),z (g),y (g),x (g)",
                 np.degrees(self.gyro)[:, ::-1], self.accel[:, ::-1] / 9.80665, seconds, ("Gyroscope.csv", "TotalAcceleration.csv"))
        self.converted(self.log)
        self.check(rtol=1e-15 * 4)  # two roundings

    def test_headings_of_one_table(self):
        both = np.concatenate((self.gyro, self.accel), axis=1)
        for heading in ("timestamp [ns],gx,gy,gz,ax,ay,az", "t_ns,wx,wy,wz,ax,ay,az", "t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z",
                        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"):
            with self.subTest(heading):
                table(self.log / "imu.csv", heading, self.stamps, both)
                self.converted(self.log)
                self.check()
                shutil.rmtree(self.rec)

    def test_no_heading(self):
        """Four columns have their meaning from the file's name; seven may be in either order."""
        self.put("", "")
        self.converted(self.log)
        self.check()
        for file in self.log.iterdir():
            file.unlink()
        table(self.log / "imu.csv", "", self.stamps, np.concatenate((self.gyro, self.accel), axis=1))
        self.refused("imu.csv has no heading: give it one that names time and axes", self.log, "--out", self.folder / "none")

    def test_units_by_gravity(self):
        self.put("t_ns,x,y,z", "t_ns,x,y,z", np.degrees(self.gyro), self.accel / 9.80665)
        done = self.converted(self.log)
        self.assertIn("rotation rates taken as deg/s", done.stderr)
        self.assertIn("accelerations taken as g", done.stderr)
        self.check(rtol=1e-15 * 4)

    def test_declared_units_that_are_wrong(self):
        self.put("timestamp [ns],x [rad/s],y [rad/s],z [rad/s]", "timestamp [ns],x,y,z", np.degrees(self.gyro))
        self.refused("--gyro-unit deg/s", self.log, "--out", self.rec)

    def test_axes_that_disagree(self):
        self.put("time,x,y,z", "time,x,y,z", self.gyro[:, [1, 0, 2]] * [1, 1, -1])
        done = self.converted(self.log)
        self.assertIn("--gyro-axes=y,x,-z", done.stderr)
        done = segcal_again(self, "--gyro-axes=y,x,-z")
        self.assertNotIn("--gyro-axes", done.stderr)

    def test_acceleration_without_gravity(self):
        linear = self.accel - self.accel.mean(axis=0) - 9.81 * self.accel / np.linalg.norm(self.accel, axis=1)[:, None] + 0.05
        self.put("time,x,y,z", "time,x,y,z", None, linear * 0.01)
        self.refused("accelerations", self.log, "--out", self.rec)

    def test_interpolation_between_streams(self):
        """The accelerometer at half the rate, 1.3 ms late: a line in time must come out as that line."""
        line = (self.stamps - self.stamps[0])[:, None] * 1e-9 * np.array([0.3, -0.2, 0.1]) + [0, 0, 9.81]
        table(self.log / "gyro.csv", "time,x,y,z", self.stamps, self.gyro)
        slow = self.stamps[::2] + 1_300_000
        at_slow = (slow - self.stamps[0])[:, None] * 1e-9 * np.array([0.3, -0.2, 0.1]) + [0, 0, 9.81]
        keep = np.ones(len(slow), bool)
        keep[300:340] = False  # a gap of 0.4 s is not bridged
        table(self.log / "accel.csv", "time,x,y,z", slow[keep], at_slow[keep])
        self.converted(self.log)
        t_ns, values = imu_of(self.rec)
        inside = np.isin(self.stamps, t_ns)
        np.testing.assert_allclose(values[:, 3:], line[inside], atol=1e-12)
        np.testing.assert_array_equal(values[:, :3], self.gyro[inside])
        # Missing: one sample before the first acceleration, the last after the last one, and 82 within the gap.
        lost = np.flatnonzero(~inside)
        self.assertEqual(lost[0], 0)
        self.assertTrue(np.all(np.diff(lost[1:83]) == 1), lost)
        self.assertLessEqual(len(lost), 84)

    def test_stamps_of_callbacks(self):
        """Delays of 1.5 ms on average, exponential, and 3 samples lost: the stamps follow the true ones but for a constant."""
        delay = np.random.default_rng(5).exponential(1.5e6, len(self.stamps)).astype(np.int64)
        late = np.maximum.accumulate(self.stamps + delay)
        kept = np.ones(len(late), bool)
        kept[700:703] = False
        for name, values in (("gyro.csv", self.gyro), ("accel.csv", self.accel)):
            table(self.log / name, "timestamp [ns],x,y,z", late[kept], values[kept])
        done = self.converted(self.log)
        self.assertIn("made regular", done.stderr)
        t_ns, values = imu_of(self.rec)
        error = t_ns - self.stamps[kept][: len(t_ns)]
        # A median of 200 delays of 1.5 ms has a standard error of 0.11 ms; beside the gap windows mix two levels.
        self.assertLess(np.quantile(np.abs(error - np.median(error)), 0.98), 0.5e6)
        self.assertLess(np.max(np.abs(error - np.median(error))), 2.5e6)
        done = segcal_again(self, "--imu-stamps", "recorded")
        self.assertNotIn("made regular", done.stderr)

    def test_broken_tables(self):
        self.put("time,x,y,z", "time,x,y,z")
        text = (self.log / "gyro.csv").read_text().splitlines()
        for line, words in (("1,2,3", "gyro.csv:9: expected 4 columns"), (f"{self.stamps[7]},a,b,c", "gyro.csv:9: expected numbers")):
            (self.log / "gyro.csv").write_text("\n".join(text[:8] + [line] + text[9:]) + "\n")
            self.refused(words, self.log, "--out", self.rec)
        for cut in ("17000000", text[-1][:-2]):  # the phone died while writing; a row cut inside its last number looks whole
            (self.log / "gyro.csv").write_text("\n".join(text) + "\n" + cut)
            self.assertIn(f"gyro.csv:{len(text) + 1}: the last line does not end", self.converted(self.log).stderr)
            shutil.rmtree(self.rec)
        (self.log / "gyro.csv").write_text("\n".join(text) + "\n")
        (self.log / "accel.csv").unlink()
        self.refused("no gyroscope and accelerometer", self.log, "--out", self.folder / "again")


def segcal_again(case, *more):
    shutil.rmtree(case.rec)
    return case.converted(case.log, *more)


class JsonLines(Case):
    def check(self, lines):
        file = self.folder / "log.jsonl"
        file.write_text("".join(json.dumps(line) + "\n" for line in lines))
        stamps, gyro, accel = tumbling(3)
        self.converted(file)
        t_ns, values = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, stamps)
        np.testing.assert_array_equal(values, np.concatenate((gyro, accel), axis=1))

    def test_one_sensor_a_line(self):
        stamps, gyro, accel = tumbling(3)
        self.check([line for t, w, a in zip(stamps.tolist(), gyro.tolist(), accel.tolist())
                    for line in ({"sensor": "gyroscope", "timestamp": t, **dict(zip("xyz", w))}, {"sensor": "accelerometer", "timestamp": t, **dict(zip("xyz", a))})])

    def test_nested_values(self):
        stamps, gyro, accel = tumbling(3)
        self.check([line for t, w, a in zip(stamps.tolist(), gyro.tolist(), accel.tolist())
                    for line in ({"sensor": {"type": "gyroscope", "values": w}, "time": t}, {"sensor": {"type": "accelerometer", "values": a}, "time": t})])

    def test_both_in_a_line(self):
        stamps, gyro, accel = tumbling(3)
        self.check([{"t_ns": t, "gyro": w, "accel": a} for t, w, a in zip(stamps.tolist(), gyro.tolist(), accel.tolist())])


class RealPhone(Case):
    def test_phone_walk(self):
        data = Path(os.environ.get("SEGCAL_DATA") or SOURCE.parent / "shared" / "data") / "phone_walk"
        if not data.is_dir():
            self.skipTest(f"no {data}")
        self.converted(data, "--mount", "phone-back", "--focal", 480)
        t_ns, values = imu_of(self.rec)
        gyro = np.array([[float(x) for x in line.split(",")[1:]] for line in (data / "mav0/imu0/gyro.csv").read_text().splitlines() if line[0] != "#"])
        self.assertGreaterEqual(len(t_ns), len(gyro) - 2)  # one at each end may lie outside of the accelerations
        first = int(np.flatnonzero((gyro == values[0, :3]).all(axis=1))[0])
        np.testing.assert_array_equal(values[:, :3], gyro[first : first + len(t_ns)])
        listed = images_of(self.rec)
        self.assertEqual(len(listed), 1571)
        self.assertEqual(listed[7][1].read_bytes(), (data / "mav0/cam0/data" / listed[7][1].name).read_bytes())
        # The source's stamps scatter by milliseconds; the sensor's rate does not: 199.7 Hz within 2 %.
        self.assertLess(np.quantile(np.abs(np.diff(t_ns) / 5.0077e6 - 1), 0.99), 0.02)


if __name__ == "__main__":
    main()
