"""`segcal import` of ROS bags, against the samples and images that were written into them."""

import io
import shutil

import numpy as np
import yaml
from PIL import Image

from bags import KINDS, Bag
from support import Case, imu_of, images_of, main, pixels, segcal, tree_bytes, tumbling

IMAGE_STEP = 10  # an image every 10 IMU samples
SIZE = (24, 16)


def random_images(n, seed=3):
    rng = np.random.default_rng(seed)
    return [rng.integers(0, 256, (SIZE[1], SIZE[0]), np.uint8) for _ in range(n)]


def filled(bag, seconds=2, imu="/imu0", camera="/cam0/image_raw"):
    """A bag of a device that tumbles; its stamps, values and images."""
    stamps, gyro, accel = tumbling(seconds)
    images = random_images(len(stamps) // IMAGE_STEP)
    for k, t_ns in enumerate(stamps.tolist()):
        bag.imu(imu, t_ns, gyro[k], accel[k])
        if k % IMAGE_STEP == 0:
            bag.image(camera, t_ns, images[k // IMAGE_STEP], "mono8")
    return stamps, np.concatenate((gyro, accel), axis=1), images


class RoundTrip(Case):
    def check(self, source, stamps, values, images):
        self.converted(source)
        t_ns, read = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, stamps)
        np.testing.assert_array_equal(read, values)  # to the bit
        listed = images_of(self.rec)
        self.assertEqual([t for t, _ in listed], stamps[::IMAGE_STEP].tolist())
        for (_, file), image in zip(listed, images):
            np.testing.assert_array_equal(pixels(file), image)
        first = tree_bytes(self.rec)
        shutil.rmtree(self.rec)
        self.converted(source)
        self.assertEqual(tree_bytes(self.rec), first)

    def test_bags(self):
        for kind in KINDS:
            with self.subTest(kind):
                with Bag(self.folder, kind) as bag:
                    truth = filled(bag)
                self.check(bag.path, *truth)
                shutil.rmtree(self.rec)

    def test_single_files(self):
        for kind in ("mcap", "sqlite3"):
            with self.subTest(kind):
                with Bag(self.folder, kind) as bag:
                    truth = filled(bag)
                self.check(bag.storage, *truth)
                shutil.rmtree(self.rec)


class Images(Case):
    def imported(self, encoding, image):
        shutil.rmtree(self.rec, ignore_errors=True)
        shutil.rmtree(self.folder / "run_mcap", ignore_errors=True)
        with Bag(self.folder, "mcap") as bag:
            stamps, *_ = filled(bag, camera="/other")
            bag.image("/cam0/image_raw", int(stamps[5]), image, encoding)
        self.converted(bag.path, "--camera", "/cam0/image_raw")
        return pixels(images_of(self.rec)[0][1])

    def test_encodings(self):
        rng = np.random.default_rng(7)
        wide = rng.integers(0, 65536, (16, 24), np.uint16)
        colour = rng.integers(0, 256, (16, 24, 3), np.uint8)
        two = rng.integers(0, 256, (16, 24, 2), np.uint8)
        np.testing.assert_array_equal(self.imported("mono16", wide), wide)
        np.testing.assert_array_equal(self.imported("rgb8", colour), colour)
        np.testing.assert_array_equal(self.imported("bgr8", colour), colour[:, :, ::-1])
        np.testing.assert_array_equal(self.imported("yuv422", two), two[:, :, 1])
        np.testing.assert_array_equal(self.imported("yuv422_yuy2", two), two[:, :, 0])

    def test_mosaic_becomes_grey(self):
        # A scene of one colour: R 200, G 100, B 40 must give R/4 + G/2 + B/4 everywhere, to rounding.
        mosaic = np.zeros((16, 24), np.uint8)
        mosaic[0::2, 0::2], mosaic[0::2, 1::2], mosaic[1::2, 0::2], mosaic[1::2, 1::2] = 200, 100, 100, 40
        np.testing.assert_array_equal(self.imported("bayer_rggb8", mosaic), np.full((16, 24), 110))

    def test_compressed_images_keep_their_bytes(self):
        buffer = io.BytesIO()
        Image.fromarray(random_images(1)[0]).save(buffer, "JPEG")
        with Bag(self.folder, "ros1") as bag:
            stamps, *_ = filled(bag, camera="/other")
            bag.compressed("/cam0/image_raw/compressed", int(stamps[5]), buffer.getvalue(), "mono8; jpeg compressed mono8")
        self.converted(bag.path, "--camera", "/cam0/image_raw/compressed")
        (_, file), = images_of(self.rec)
        self.assertEqual(file.read_bytes(), buffer.getvalue())
        self.assertEqual(file.suffix, ".jpg")


# A point p_I is at p_I + (0.1, 0, 0) in base, and p_C = R_z(90 deg)' (p_base - (0, 0.3, 0)): the origin of I is at (-0.3, -0.1, 0).
T_CAM_IMU = [[0, 1, 0, -0.3], [-1, 0, 0, -0.1], [0, 0, 1, 0], [0, 0, 0, 1]]


class Calibration(Case):
    def chain(self, D, model, *options):
        with Bag(self.folder, "mcap") as bag:
            stamps, *_ = filled(bag)
            t_ns = int(stamps[0])
            bag.camera_info("/cam0/camera_info", t_ns, SIZE, [20, 0, 12, 0, 21, 8, 0, 0, 1], D, model)
            # base -> imu: 0.1 m along x; base -> camera: turned by 90 deg about z, 0.3 m along y.
            bag.fixed_transform(t_ns, "base", "imu", (1, 0, 0, 0), (0.1, 0, 0))
            bag.fixed_transform(t_ns, "base", "camera", (np.sqrt(0.5), 0, 0, np.sqrt(0.5)), (0, 0.3, 0))
        self.said = self.converted(bag.path, *options).stderr
        return yaml.safe_load((self.rec / "camchain-imucam.yaml").read_text())["cam0"]

    def test_camera_info_and_tf(self):
        camera = self.chain([-0.2, 0.05, 1e-3, -2e-3, 0], "plumb_bob")
        self.assertEqual(camera["intrinsics"], [20, 21, 12, 8])
        self.assertEqual(camera["distortion_coeffs"], [-0.2, 0.05, 1e-3, -2e-3])
        np.testing.assert_allclose(camera["T_cam_imu"], T_CAM_IMU, atol=1e-12)
        self.assertNotIn("T_cam_imu is of", self.said)

    def test_other_axes_are_not_those_of_the_calibration(self):
        """The samples are turned, /tf_static is not: it may be of the axes that are right, or of those that were recorded."""
        camera = self.chain([-0.2, 0.05, 1e-3, -2e-3, 0], "plumb_bob", "--gyro-axes=y,-x,z", "--accel-axes=y,-x,z")
        self.assertIn("warning: T_cam_imu is of the gyroscope's axes as recorded, not of --gyro-axes", self.said)
        np.testing.assert_allclose(camera["T_cam_imu"], T_CAM_IMU, atol=1e-12)

    def test_a_fifth_coefficient_is_fitted(self):
        D = [-0.25, 0.08, 1e-3, -5e-4, -0.02]
        camera = self.chain(D, "plumb_bob")
        self.assertIn("replaced by the nearest", (self.rec / "import.json").read_text())
        # The image's corner, x = 0.6, y = 0.4: both lenses put it within 0.02 px, the truth being 5 px off the undistorted place.
        x, y = 0.55, 0.33
        r2 = x * x + y * y
        self.assertEqual(camera["distortion_model"], "radtan")
        k1, k2, p1, p2 = camera["distortion_coeffs"]
        fitted = x * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        true = x * (1 + D[0] * r2 + D[1] * r2**2 + D[4] * r2**3) + 2 * D[2] * x * y + D[3] * (r2 + 2 * x * x)
        self.assertLess(abs(fitted - true) * 20, 0.02)


class Choices(Case):
    def test_separate_streams_with_zeros(self):
        """As RealSense drivers log them: two Imu topics, each with zeros for the other sensor."""
        stamps, gyro, accel = tumbling(2)
        with Bag(self.folder, "sqlite3") as bag:
            for k, t_ns in enumerate(stamps.tolist()):
                bag.imu("/gyro/sample", t_ns, gyro[k], (0, 0, 0))
                bag.imu("/accel/sample", t_ns + 1_000_000, (0, 0, 0), accel[k])
        self.converted(bag.path)
        t_ns, values = imu_of(self.rec)
        np.testing.assert_array_equal(t_ns, stamps[1:])  # nothing before the first acceleration
        np.testing.assert_array_equal(values[:, :3], gyro[1:])
        # Linear interpolation of 1.2 rad/s x 9.81 m/s^2 over 5 ms: curvature a'' h^2 / 8 < 20 x 9.81 x 25e-6 / 8 = 6e-4.
        between = accel[:-1] + 0.8 * (accel[1:] - accel[:-1])
        np.testing.assert_allclose(values[:, 3:], between, atol=1e-9)

    def test_two_imus_are_a_question(self):
        with Bag(self.folder, "mcap") as bag:
            filled(bag)
            filled(bag, imu="/imu1", camera="/cam1/image_raw")
        self.refused("choose with --imu NAME; found /imu0, /imu1", bag.path, "--out", self.rec)
        self.converted(bag.path, "--imu", "/imu1", "--camera", "/cam1/image_raw")

    def test_copies_and_distances_are_no_second_camera(self):
        """The compressed copy of a raw stream, and a depth camera's distances, would pass for the right camera of a pair."""
        buffer = io.BytesIO()
        Image.fromarray(random_images(1)[0]).save(buffer, "PNG")
        with Bag(self.folder, "mcap") as bag:
            stamps, _, images = filled(bag)
            for t_ns in stamps.tolist()[::IMAGE_STEP]:
                bag.compressed("/cam0/image_raw/compressed", t_ns, buffer.getvalue(), "png")
                bag.image("/depth/image_rect_raw", t_ns, images[0].astype(np.uint16), "16UC1")
        done = self.converted(bag.path)
        self.assertIn("note: /cam0/image_raw/compressed: not taken, the same images as /cam0/image_raw", done.stderr)
        self.assertIn("note: /depth/image_rect_raw: not taken", done.stderr)
        np.testing.assert_array_equal(pixels(images_of(self.rec)[0][1]), images[0])
        self.assertFalse((self.rec / "mav0/cam1").exists())
        shutil.rmtree(self.rec)
        self.converted(bag.path, "--camera", "/cam0/image_raw/compressed", "--camera", "/depth/image_rect_raw")
        self.assertEqual(images_of(self.rec)[0][1].read_bytes(), buffer.getvalue())
        for names in (("/cam0/image_raw",) * 2, ("/cam0/image_raw", "/depth/image_rect_raw", "/cam0/image_raw/compressed")):
            self.refused("expected one stream or two different ones", bag.path, "--out", self.folder / "none", *(x for n in names for x in ("--camera", n)))

    def test_no_stamps_in_the_headers(self):
        stamps, gyro, accel = tumbling(2)
        with Bag(self.folder, "ros1") as bag:
            for k, t_ns in enumerate(stamps.tolist()):
                bag.imu("/imu0", t_ns, gyro[k], accel[k], stamp_ns=0)
        done = self.converted(bag.path)
        self.assertIn("time of logging", done.stderr)
        np.testing.assert_array_equal(imu_of(self.rec)[0], stamps + 3_000_000)


class Damage(Case):
    def test_cut_files(self):
        for kind in KINDS:
            with Bag(self.folder, kind) as bag:
                filled(bag, seconds=1)
            data = bag.storage.read_bytes()
            for share in (0.001, 0.3, 0.999):
                with self.subTest(kind=kind, share=share):
                    bag.storage.write_bytes(data[: int(share * len(data))])
                    self.refused("", bag.storage if share == 0.3 else bag.path, "--out", self.rec)

    def test_overwritten_middle(self):
        for kind in KINDS:
            with self.subTest(kind):
                with Bag(self.folder, kind) as bag:
                    filled(bag, seconds=1)
                data = bytearray(bag.storage.read_bytes())
                data[len(data) // 3 : 2 * len(data) // 3] = b"\xa5" * (2 * len(data) // 3 - len(data) // 3)
                bag.storage.write_bytes(data)
                self.refused(str(bag.path), bag.path, "--out", self.rec)

    def test_an_image_that_is_none(self):
        """Not the first one: each is looked into as far as its size."""
        pictures = []
        for size in (SIZE, (SIZE[0] + 8, SIZE[1])):
            buffer = io.BytesIO()
            Image.new("L", size).save(buffer, "PNG")
            pictures.append(buffer.getvalue())
        for second, words in ((b"no image", "/cam: an image that cannot be decoded"), (pictures[1], "/cam: expected images of one size, found 24 x 16 and")):
            with Bag(self.folder, "ros1") as bag:
                stamps, *_ = filled(bag, camera="/other")
                bag.compressed("/cam", int(stamps[5]), pictures[0], "png")
                bag.compressed("/cam", int(stamps[15]), second, "png")
            self.refused(words, bag.path, "--camera", "/cam", "--out", self.rec)
            bag.path.unlink()

    def test_an_image_that_was_cut_short(self):
        """Its header is whole. Cut in the middle or at its very end: the card was full, or the message's buffer too small. Padding harms nobody."""
        for kind, how, left in (("png", {}, -1), ("png", {}, 200), ("jpeg", {"progressive": True}, -1), ("webp", {}, -1), ("bmp", {}, -1)):
            buffer = io.BytesIO()
            Image.fromarray(random_images(1)[0]).save(buffer, kind.upper(), **how)
            whole = buffer.getvalue()
            with self.subTest(kind=kind, left=left), Bag(self.folder, "ros1") as bag:
                stamps, *_ = filled(bag, seconds=0.5, camera="/other")
                bag.compressed("/cam", int(stamps[5]), whole + bytes(16), kind)
                bag.compressed("/cam", int(stamps[15]), whole[:left], kind)
            self.refused(f"/cam: an image that cannot be decoded, damaged or cut short ({stamps[15]}.", bag.path, "--camera", "/cam", "--out", self.rec)
            bag.path.unlink()

    def test_unknown_and_occupied(self):
        strange = self.folder / "notes.bin"
        strange.write_bytes(b"\x00\x01\x02 nothing that anybody knows" * 50)
        self.refused("notes.bin: not a log", strange, "--out", self.rec)
        self.refused("none.bag: no such file", self.folder / "none.bag", "--out", self.rec)
        with Bag(self.folder, "ros1") as bag:
            filled(bag)
        self.rec.mkdir()
        (self.rec / "mine.txt").write_text("keep")
        self.refused("expected a new or empty folder", bag.path, "--out", self.rec)

    def test_list(self):
        with Bag(self.folder, "mcap") as bag:
            stamps, *_ = filled(bag)
            bag.fixed_transform(int(stamps[0]), "base", "imu", (1, 0, 0, 0), (0, 0, 0))
        done = segcal("import", bag.path, "--list")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"imu +/imu0 +400 ")
        self.assertRegex(done.stdout, r"camera +/cam0/image_raw +40 ")
        self.assertRegex(done.stdout, r"other +/tf_static +1 +tf2_msgs/msg/TFMessage\n")  # what is not used, with its type


if __name__ == "__main__":
    main()
