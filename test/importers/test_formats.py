"""`segcal import` of PX4 logs, EuRoC and TUM-VI folders, and video."""

import importlib.util
import shutil
import struct
import unittest

import numpy as np
import yaml
from PIL import Image
from pyulog import ULog

from support import Case, imu_of, images_of, main, pixels, tumbling


def ulog(stamps_us, gyro, accel):
    """A log with one topic, sensor_combined, byte by byte as docs.px4.io "ULog File Format" has it."""
    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    fields = b"uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;"
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", int(stamps_us[0]))
    data += message("B", bytes(40)) + message("F", b"sensor_combined:" + fields) + message("A", struct.pack("<BH", 0, 7) + b"sensor_combined")
    for t, w, a in zip(stamps_us.tolist(), gyro, accel):
        data += message("D", struct.pack("<HQ3fi3f", 7, t, *w, 0, *a))
    return data


class Px4(Case):
    def setUp(self):
        super().setUp()
        stamps, gyro, accel = tumbling(5)
        self.stamps_us = stamps // 1000 - stamps[0] // 1000 + 10_000_000
        self.data = ulog(self.stamps_us, gyro.astype(np.float32), accel.astype(np.float32))
        self.file = self.folder / "flight.ulg"
        self.file.write_bytes(self.data)

    def test_against_pyulog(self):
        """As pyulog reads it, and as it reads what it wrote itself."""
        again = self.folder / "again.ulg"
        ULog(str(self.file)).write_ulog(str(again))
        for file in (self.file, again):
            self.converted(file)
            t_ns, values = imu_of(self.rec)
            topic = ULog(str(file)).get_dataset("sensor_combined").data
            np.testing.assert_array_equal(t_ns, topic["timestamp"].astype(np.int64) * 1000)
            np.testing.assert_array_equal(t_ns, self.stamps_us * 1000)
            for i in range(3):
                np.testing.assert_array_equal(values[:, i], topic[f"gyro_rad[{i}]"].astype(float))
                np.testing.assert_array_equal(values[:, 3 + i], topic[f"accelerometer_m_s2[{i}]"].astype(float))
            shutil.rmtree(self.rec)

    def test_damage(self):
        self.file.write_bytes(self.data[:-10])  # the vehicle lost its power
        done = self.converted(self.file)
        self.assertIn("ends within a message", done.stderr)
        self.assertEqual(len(imu_of(self.rec)[0]), len(self.stamps_us) - 1)
        for data in (self.data[:12], self.data[:400] + bytes(range(256)) * 8 + self.data[2448:]):
            self.file.write_bytes(data)
            self.refused("flight.ulg", self.file, "--out", self.folder / "none")


class Folders(Case):
    def put(self, root):
        stamps, gyro, accel = tumbling(5)
        (root / "mav0/imu0").mkdir(parents=True)
        rows = "".join(f"{t}," + ",".join(map(repr, [*w, *a])) + "\n" for t, w, a in zip(stamps.tolist(), gyro.tolist(), accel.tolist()))
        (root / "mav0/imu0/data.csv").write_text("#timestamp [ns],w_RS_S_x [rad s^-1],...\n" + rows)
        (root / "mav0/cam0/data").mkdir(parents=True)
        image = np.random.default_rng(2).integers(0, 65536, (8, 12), np.uint16)
        Image.fromarray(image).save(root / "mav0/cam0/data/a.png")
        (root / "mav0/cam0/data.csv").write_text(f"#timestamp [ns],filename\n{stamps[9]},a.png\n")
        return stamps, np.concatenate((gyro, accel), axis=1), image

    def test_tum_vi(self):
        """16-bit images, dso/camchain.yaml, dso/imu_config.yaml."""
        root = self.folder / "room"
        stamps, values, image = self.put(root)
        T = [[0.0, -1, 0, 0.04], [-1, 0, 0, -0.07], [0, 0, -1, -0.05], [0, 0, 0, 1]]
        camera = {"T_cam_imu": T, "camera_model": "pinhole", "distortion_model": "equidistant", "distortion_coeffs": [0.01, 0.02, -0.01, 0.002],
                  "intrinsics": [190.0, 190, 254, 256], "resolution": [12, 8]}
        noise = {"accelerometer_noise_density": 0.0028, "accelerometer_random_walk": 0.00086, "gyroscope_noise_density": 0.00016,
                 "gyroscope_random_walk": 2.2e-05, "update_rate": 200.0}
        (root / "dso").mkdir()
        (root / "dso/camchain.yaml").write_text(yaml.safe_dump({"cam0": camera}))
        (root / "dso/imu_config.yaml").write_text(yaml.safe_dump(noise))
        self.converted(root)
        t_ns, read = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, stamps)
        np.testing.assert_array_equal(read, values)
        np.testing.assert_array_equal(pixels(images_of(self.rec)[0][1]), image)
        chain = yaml.safe_load((self.rec / "camchain-imucam.yaml").read_text())["cam0"]
        self.assertEqual({k: chain[k] for k in camera}, camera)
        sensor = yaml.safe_load((self.rec / "mav0/imu0/sensor.yaml").read_text())
        self.assertEqual(sensor["gyroscope_random_walk"], 2.2e-05)
        shutil.rmtree(self.rec)
        (root / "dso/camchain.yaml").write_text(yaml.safe_dump({"cam0": {**camera, "readout": "columns"}}))
        self.converted(root)
        self.assertEqual(yaml.safe_load((self.rec / "camchain-imucam.yaml").read_text())["cam0"]["readout"], "columns")
        (root / "dso/camchain.yaml").write_text(yaml.safe_dump({"cam0": {**camera, "readout": "left"}}))
        self.refused("dso/camchain.yaml: expected readout rows or columns", root, "--out", self.folder / "none")

    def test_exposures(self):
        root = self.folder / "room"
        stamps, _, _ = self.put(root)
        file = root / "mav0/cam0/exposure.csv"
        file.write_text(f"#timestamp [ns],exposure [ns]\n{stamps[9]},3999744\n")
        self.converted(root, "--focal", 100, "--mount", "phone-back")
        self.assertEqual((self.rec / "mav0/cam0/exposure.csv").read_text(), file.read_text())
        file.write_text(f"#timestamp [ns],exposure [ns]\n{stamps[9]},soon\n")
        self.refused("mav0/cam0/exposure.csv:2: expected an exposure", root, "--focal", 100, "--mount", "phone-back", "--out", self.folder / "none")

    def test_a_missing_image(self):
        root = self.folder / "room"
        self.put(root)
        (root / "mav0/cam0/data/a.png").unlink()
        self.refused("mav0/cam0/data.csv:2: expected an image that exists", root, "--out", self.rec)


class Video(Case):
    def put_tables(self):
        stamps, gyro, accel = tumbling(5)
        for name, values in (("gyro.csv", gyro), ("accel.csv", accel)):
            rows = "".join(f"{t}," + ",".join(map(repr, row)) + "\n" for t, row in zip(stamps.tolist(), values.tolist()))
            (self.folder / name).write_text("timestamp [ns],x,y,z\n" + rows)
        self.sources = [self.folder / "clip.mkv", self.folder / "gyro.csv", self.folder / "accel.csv"]
        return stamps[: 20 * 10 : 10]

    @unittest.skipUnless(importlib.util.find_spec("av"), "no package av: .venv/bin/pip install -r host_tools/importers/requirements-video.txt")
    def test_frames_against_the_library(self):
        """A lossless codec: the brightness that was put in comes out."""
        import av
        stamps = self.put_tables()
        images = [np.random.default_rng(k).integers(0, 256, (48, 64), np.uint8) for k in range(20)]
        with av.open(str(self.sources[0]), "w") as container:
            stream = container.add_stream("ffv1", rate=20)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "gray"
            for image in images:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
            container.mux(stream.encode())
        table = self.folder / "clip.csv"
        table.write_text("timestamp [ns],frame\n" + "".join(f"{t},{k}\n" for k, t in enumerate(stamps)))
        self.converted(*self.sources, "--focal", 60, "--mount", "phone-back")
        listed = images_of(self.rec)
        self.assertEqual([t for t, _ in listed], stamps.tolist())
        for (_, file), image in zip(listed, images):
            np.testing.assert_array_equal(pixels(file), image)
        table.write_text(table.read_text().rsplit("\n", 2)[0] + "\n")
        self.refused("20 frames, but", *self.sources, "--out", self.folder / "again")
        self.sources[0].write_bytes(self.sources[0].read_bytes()[:100])
        self.refused("clip.mkv: damaged", *self.sources, "--out", self.folder / "again")

    def test_a_video_without_stamps(self):
        self.put_tables()
        self.sources[0].write_bytes(b"\x1a\x45\xdf\xa3" + bytes(200))
        self.refused("expected a table of its frames' stamps", *self.sources, "--out", self.rec)


    def test_a_table_that_was_cut(self):
        """Inside its last number: a stamp years away, or, as here, a millisecond off, which nothing later would notice."""
        stamps = self.put_tables()
        self.sources[0].write_bytes(b"\x1a\x45\xdf\xa3" + bytes(200))
        for heading in ("timestamp [ns],frame\n", ""):
            (self.folder / "clip.csv").write_text(heading + "\n".join(str(t) for t in stamps.tolist())[:-1])
            self.refused("expected a line that ends", *self.sources, "--out", self.rec)


class Unsupported(Case):
    def box(self, kind, content):
        return (8 + len(content)).to_bytes(4, "big") + kind + content

    def test_reasons(self):
        """Known, and not read: the reason, and a way on."""
        gopro = self.folder / "GX010001.MP4"
        handler = self.box(b"hdlr", bytes(8) + b"meta" + bytes(12) + b"GoPro MET") + self.box(b"stsd", bytes(8) + self.box(b"gpmd", bytes(8)))
        gopro.write_bytes(self.box(b"ftyp", b"mp41") + self.box(b"mdat", bytes(1000)) + self.box(b"moov", self.box(b"trak", handler)))
        self.refused("GoPro's telemetry inside of a video is not read", gopro, "--list")
        gopro.write_bytes(self.box(b"ftyp", b"mp41") + self.box(b"mdat", b"gpmd" + bytes(100)) + self.box(b"moov", bytes(40)))
        self.refused("expected a table of its frames' stamps", gopro, "--list")  # no telemetry: a video like others
        gopro.write_bytes(self.box(b"ftyp", b"mp41") + bytes(12))
        self.refused("expected a table of its frames' stamps", gopro, "--list")


class Calibrations(Case):
    CAMERA = "  distortion_model: {model}\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  intrinsics: {intrinsics}\n  resolution: [12, 8]\n" \
             "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"

    def test_files_that_are_given(self):
        """--calib and --imu-noise are read as any calibration: what segcal could not use is refused, not copied."""
        root, chain, noise = self.folder / "room", self.folder / "chain.yaml", self.folder / "noise.yaml"
        Folders.put(self, root)
        for model, intrinsics, says in (("radtan", "[200, 200, 4]", "4 finite numbers in 'intrinsics'"), ("omni", "[200, 200, 4, 3]", "expected a distortion_model"),
                                        ("radtan", "[200, .nan, 4, 3]", "finite numbers"), ("equi", "[200, 200, 4, 3]", "")):
            chain.write_text("cam0:\n" + self.CAMERA.format(model=model, intrinsics=intrinsics))
            if says:
                self.refused(says, root, "--out", self.rec, "--calib", chain)
        self.converted(root, "--calib", chain)
        self.assertEqual((self.rec / "camchain-imucam.yaml").read_text(), chain.read_text())
        shutil.rmtree(self.rec)
        chain.write_text("cam0: [\n")
        self.refused("chain.yaml:2: expected YAML", root, "--out", self.rec, "--calib", chain)
        noise.write_text("gyroscope_noise_density: 1.0e-4\n")
        self.refused("noise.yaml: expected an entry 'accelerometer_noise_density'", root, "--out", self.rec, "--imu-noise", noise)


if __name__ == "__main__":
    main()
