"""`segcal import` of Aria's recordings (VRS): what the test's own writer put in must come out, and damage must be seen."""

import importlib.util
import io
import re
import shutil
import unittest

import numpy as np
from aria_case import NEEDED, SIZE, Aria, calibration, needs_vrs
from PIL import Image
from support import SOURCE, imu_of, images_of, main, pixels, segcal
from vrs_files import VrsFile


@needs_vrs
class Content(Aria):
    def test_samples_and_images(self):
        """To the bit; of each kind of sensor the first of the device, and both SLAM cameras as images of one moment."""
        self.put()
        done = self.converted(self.file)
        t_ns, values = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, self.stamps)
        np.testing.assert_array_equal(values, np.concatenate((self.gyro, self.accel), axis=1).astype(float))
        for camera in (0, 1):
            listed = images_of(self.rec, camera)
            self.assertEqual([t for t, _ in listed], self.image_stamps.tolist())
            for (_, file), image in zip(listed, self.images, strict=True):
                np.testing.assert_array_equal(pixels(file), image)
        self.assertFalse((self.rec / "mav0/cam2").exists())
        for words in ("imu-left: not taken", "camera-rgb: not taken", f"camera-slam-right: {len(self.images)} images have the stamps of camera-slam-left's"):
            self.assertIn(f"note: {words}", done.stderr)
        self.assertFalse((self.rec / "imu.yaml").exists())

    def test_named_streams(self):
        self.put()
        listed = segcal("import", self.file, "--list").stdout
        self.assertRegex(listed, r"imu +imu-left +1000 +stream 1202-2\n")
        self.assertRegex(listed, r"other +camera-et +10 ")
        self.assertNotIn("1-0", listed)  # the file's own index
        self.converted(self.file, "--imu", "imu-left", "--camera", "camera-rgb")
        np.testing.assert_array_equal(imu_of(self.rec)[0], self.stamps + 77)
        self.assertEqual([t for t, _ in images_of(self.rec)], self.image_stamps[::3].tolist())

    def test_time_of_logging(self):
        self.put(late_ns=5_000_000)
        self.converted(self.file, "--stamps", "log")
        np.testing.assert_array_equal(imu_of(self.rec)[0], self.stamps + 5_000_000)
        self.assertEqual(images_of(self.rec)[0][0], self.image_stamps[0] + 9_000_000)

    def test_times_of_logging_that_were_not_written(self):
        vrs = VrsFile()
        vrs.imu("1202-1", self.stamps, self.gyro, self.accel, logged_ns=0)
        vrs.camera("1201-1", self.image_stamps, self.images, SIZE)
        vrs.write(self.file)
        self.converted(self.file)
        shutil.rmtree(self.rec)
        self.refused("expected times of logging, found none that grow; --stamps sensor", self.file, "--stamps", "log", "--out", self.rec)

    def test_invalid_samples(self):
        valid = ~np.isin(np.arange(len(self.stamps)), (13, 14, 500))
        self.put(valid=valid)
        self.assertIn("3 samples that the device calls invalid left out", self.converted(self.file).stderr)
        np.testing.assert_array_equal(imu_of(self.rec)[0], self.stamps[valid])

    def test_jpeg_files_stay_as_they_are(self):
        buffers = []
        for image in self.images:
            buffers.append(io.BytesIO())
            Image.fromarray(image).save(buffers[-1], "JPEG")
        vrs = VrsFile()
        vrs.imu("1202-1", self.stamps, self.gyro, self.accel)
        vrs.camera("1201-1", self.image_stamps, [b.getvalue() for b in buffers], SIZE, "jpg")
        vrs.write(self.file)
        self.converted(self.file)
        self.assertEqual([file.read_bytes() for _, file in images_of(self.rec)], [b.getvalue() for b in buffers])

    @unittest.skipUnless(importlib.util.find_spec("av"), f"no package av: .venv/bin/pip install -r {NEEDED}")
    def test_video(self):
        """Gen 2's H.265, encoded without loss here: each picture under its own stamp."""
        import av
        codec = av.CodecContext.create("libx265", "w")
        codec.width, codec.height, codec.pix_fmt, codec.framerate = *SIZE, "gray", 30
        codec.options = {"x265-params": "lossless=1:bframes=0:keyint=4:log-level=none"}
        packets = [p for image in self.images for p in codec.encode(av.VideoFrame.from_ndarray(image, format="gray"))] + codec.encode(None)
        vrs = VrsFile(None, {"device_type": "Oatmeal"})
        vrs.imu("1202-1", self.stamps, self.gyro, self.accel)
        vrs.camera("1201-1", self.image_stamps, [bytes(p) for p in packets], SIZE, "video/codec=H.265")
        vrs.write(self.file)
        self.converted(self.file)
        listed = images_of(self.rec)
        self.assertEqual([t for t, _ in listed], self.image_stamps.tolist())
        for (_, file), image in zip(listed, self.images, strict=True):
            np.testing.assert_array_equal(pixels(file), image)
        self.assertIn("slam-front-left", (self.rec / "import.json").read_text())


@needs_vrs
class Damage(Aria):
    def test_cut_files(self):
        self.put(calibration(SIZE))
        data = self.file.read_bytes()
        for end in (40, 85, 500, len(data) // 3, len(data) - 20_000, len(data) - 1):
            with self.subTest(end=end):
                self.file.write_bytes(data[:end])
                self.refused("run.vrs: damaged VRS file", self.file, "--out", self.rec)

    def test_overwritten(self):
        """The middle; the content of compressed records. An index that is damaged the library makes anew."""
        self.put(calibration(SIZE))
        data = self.file.read_bytes()
        frames = [m.start() + 20 for m in re.finditer(re.escape(b"\x28\xb5\x2f\xfd"), data)]  # Zstandard's magic number
        for places, n in (([len(data) // 3], len(data) // 3), (frames, 40)):
            damaged = bytearray(data)
            for begin in places:
                damaged[begin : begin + n] = b"\xa5" * n
            with self.subTest(places=places):
                self.file.write_bytes(damaged)
                self.refused("run.vrs: damaged VRS file", self.file, "--out", self.rec)

    def test_two_recordings(self):
        """Both have the same names of streams: the second was taken for the first."""
        self.put()
        other = self.folder / "other.vrs"
        other.write_bytes(self.file.read_bytes())
        self.refused("its stream camera-slam-left is in", self.file, other, "--imu", "imu-right", "--camera", "camera-slam-left", "--out", self.rec)

    def test_configuration_without_a_size(self):
        """A field's name in the description that is damaged. The library itself asks for it of raw images only."""
        buffer = io.BytesIO()
        Image.fromarray(self.images[0]).save(buffer, "JPEG")
        vrs = VrsFile(calibration(SIZE))
        vrs.imu("1202-1", self.stamps, self.gyro, self.accel)
        vrs.camera("1201-1", self.image_stamps, [buffer.getvalue()] * len(self.images), SIZE, "jpg")
        vrs.write(self.file)
        self.file.write_bytes(self.file.read_bytes().replace(b'"image_width"', b'"imaqe_width"'))
        self.refused("run.vrs: expected a field 'image_width' in its records", self.file, "--out", self.rec)

    def test_names_that_end_the_library(self):
        """It stops by SIGSEGV on these: still one line, and nothing is left behind."""
        self.put()
        data = self.file.read_bytes()
        self.assertIn(b'"image_height"', data)
        self.file.write_bytes(data.replace(b'"image_height"', b'"image_\xf6eight"'))
        self.refused("what it says about its streams cannot be read", self.file, "--out", self.rec)

    def test_another_maker(self):
        """A VRS file is a container: a stream of that type with other fields, and one without any that is of use."""
        self.put(fields={"when": "double", "gyroscope": np.float32})
        self.refused("expected a field 'capture_timestamp_ns' in its records, as Aria's have", self.file, "--out", self.rec)
        vrs = VrsFile()
        vrs.camera("1201-1", self.image_stamps, self.images, SIZE)
        vrs.write(self.file)
        self.refused("no gyroscope and accelerometer in it", self.file, "--out", self.rec)

    def test_a_calibration_that_is_none(self):
        vrs = self.put(calibration(SIZE))
        for text, words in (("{", "expected JSON"), ('{"CameraCalibrations": 3}', "expected JSON"),
                            (vrs.calibration.replace("RectificationMatrix", "Other"), "expected matrices and time offsets of imu-right"),
                            (vrs.calibration.replace("T_Device_Camera", "Other"), "expected a pose 'T_Device_Camera'")):
            with self.subTest(words):
                vrs.tags["calib_json"] = text
                vrs.write(self.file)
                self.refused(words, self.file, "--out", self.rec)


class Extra(Aria):
    def test_the_package_is_an_extra(self):
        """Where it is not installed, which a package that cannot be imported stands for, one line says the command."""
        self.put()
        (self.folder / "pyvrs.py").write_text("raise ImportError('none', name='pyvrs')\n")
        done = segcal("import", self.file, "--out", self.rec, environment={"PYTHONPATH": str(self.folder)})
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("the Python package 'vrs'", done.stderr)
        command = done.stderr.split("install it with: ")[1].split()
        self.assertEqual(command, [".venv/bin/pip", "install", "-r", NEEDED])
        self.assertIn("vrs==", (SOURCE / command[3]).read_text())
        self.assertFalse(self.rec.exists())


if __name__ == "__main__":
    main()
