"""`segcal export`: each written file is read back by its own tool's equations, and must predict what the calibration predicts.

The measure is physical: rotation rate and specific force as the sensors report them, a point's place in camera coordinates, a
pixel. Frames may differ between tools, so a body frame is found from the file itself, never from the code under test."""

import json

import numpy as np
import yaml
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from session_case import SessionCase
from support import Case, main, segcal

RNG = np.random.default_rng(11)


def rotation(phi):
    angle = np.linalg.norm(phi)
    k = np.array(phi) / angle
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose(phi, p):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(phi), p
    return T


T_G = np.array([[1.01, 0.004, -0.003], [0, 0.99, 0.002], [0, 0, 1.005]])
T_A = np.array([[0.98, -0.006, 0.005], [0, 1.02, 0.003], [0, 0, 1.01]])
R_AI = rotation([0.02, -0.01, 0.03])
POSES = [pose([1.2, -1.1, 0.9], [0.05, -0.02, 0.01]), pose([1.21, -1.12, 0.88], [-0.06, -0.02, 0.01])]
RADTAN, FOV, EQUI = [-0.28, 0.07, 2e-4, 1e-5], [0.92], [0.01, -0.02, 0.003, 0.001]
INTRINSICS = [458.6, 457.3, 367.2, 248.4]
NOISE = {"accelerometer_noise_density": 2e-3, "accelerometer_random_walk": 3e-4, "gyroscope_noise_density": 1.7e-4, "gyroscope_random_walk": 2e-5}


def camera_text(i, model, D):
    rows = [[float(x) for x in row] for row in POSES[i]]
    return {f"cam{i}": {"T_cam_imu": rows, "camera_model": "pinhole", "intrinsics": INTRINSICS, "distortion_model": model,
                        "distortion_coeffs": D, "resolution": [752, 480], "timeshift_cam_imu": 0.0025}}


def distort(model, D, x, y):
    r = np.hypot(x, y)
    if model == "radtan":
        k1, k2, p1, p2 = D[:4]
        radial = 1 + k1 * r**2 + k2 * r**4
        return x * radial + 2 * p1 * x * y + p2 * (r * r + 2 * x * x), y * radial + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y
    theta = np.arctan(r)
    rd = np.arctan(2 * r * np.tan(D[0] / 2)) / D[0] if model == "fov" else theta * (1 + sum(k * theta ** (2 * n + 2) for n, k in enumerate(D)))
    return x * rd / r, y * rd / r


class Export(Case):
    def setUp(self):
        super().setUp()
        self.dir, self.out = self.folder / "out", self.folder / "files"
        self.dir.mkdir()
        self.put([("radtan", RADTAN), ("equidistant", EQUI)])
        imu = {**NOISE, "update_rate": 200.0, "gyroscopes": {"M": T_G.tolist(), "C_gyro_i": np.eye(3).tolist()},
               "accelerometers": {"M": T_A.tolist(), "C_accel_i": R_AI.tolist()}}
        (self.dir / "imu.yaml").write_text(yaml.safe_dump(imu))
        self.w, self.a, self.p = RNG.normal(size=3), RNG.normal(size=3), RNG.normal(size=3)
        self.w_m, self.a_m = T_G @ self.w, T_A @ R_AI @ self.a

    def put(self, lenses):
        self.lenses = lenses
        chain = {}
        for i, (model, D) in enumerate(lenses):
            chain |= camera_text(i, model, D)
        (self.dir / "camchain-imucam.yaml").write_text(yaml.safe_dump(chain))

    def exported(self, to):
        done = segcal("export", self.dir, "--to", to, "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def check(self, w_m, a_m, body_to_camera, R_BI):
        """Rounding of printed digits only: 1e-12."""
        np.testing.assert_allclose(w_m(R_BI @ self.w), self.w_m, atol=1e-12)
        np.testing.assert_allclose(a_m(R_BI @ self.a), self.a_m, atol=1e-12)
        for T_CB, T_CI in zip(body_to_camera, POSES):
            np.testing.assert_allclose(T_CB[:3, :3] @ R_BI @ self.p + T_CB[:3, 3], T_CI[:3, :3] @ self.p + T_CI[:3, 3], atol=1e-12)

    def test_kalibr(self):
        self.exported("kalibr")
        chain, imu = (yaml.safe_load((self.out / name).read_text()) for name in ("camchain-imucam.yaml", "imu.yaml"))
        imu = imu["imu0"]
        M_a, M_g, C_g = (np.array(imu[group][name]) for group, name in (("accelerometers", "M"), ("gyroscopes", "M"), ("gyroscopes", "C_gyro_i")))
        self.assertEqual(np.abs(np.triu(M_a, 1)).max() + np.abs(np.triu(M_g, 1)).max(), 0)  # Kalibr keeps the lower triangle
        R_BI = np.linalg.inv(M_a) @ T_A @ R_AI
        np.testing.assert_allclose(R_BI @ R_BI.T, np.eye(3), atol=1e-12)
        transforms = [np.array(chain[f"cam{i}"]["T_cam_imu"]) for i in (0, 1)]
        self.check(lambda w: M_g @ C_g @ w, lambda a: M_a @ a, transforms, R_BI)
        np.testing.assert_allclose(np.array(chain["cam1"]["T_cn_cnm1"]) @ transforms[0], transforms[1], atol=1e-12)
        self.assertEqual(chain["cam0"]["timeshift_cam_imu"], 0.0025)
        self.assertEqual({name: imu[name] for name in NOISE}, NOISE)

    def test_openvins(self):
        self.exported("openvins")
        chain, imu = (yaml.safe_load((self.out / name).read_text().split("\n", 1)[1]) for name in ("kalibr_imucam_chain.yaml", "kalibr_imu_chain.yaml"))
        imu = imu["imu0"]
        self.assertEqual(imu["model"], "rpng")
        Tw, Rw, Ta, Ra = (np.array(imu[name]) for name in ("Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC"))
        transforms = [np.linalg.inv(np.array(chain[f"cam{i}"]["T_imu_cam"])) for i in (0, 1)]
        self.check(lambda w: Tw @ Rw @ w, lambda a: Ta @ Ra @ a, transforms, np.eye(3))
        self.assertEqual(chain["cam1"]["distortion_model"], "equidistant")

    def test_basalt(self):
        self.exported("basalt")
        value = json.loads((self.out / "calibration.json").read_text())["value0"]
        b = value["calib_accel_bias"]
        accel = np.linalg.inv(np.eye(3) + np.array([[b[3], 0, 0], [b[4], b[6], 0], [b[5], b[7], b[8]]]))
        gyro = np.linalg.inv(np.eye(3) + np.array(value["calib_gyro_bias"][3:]).reshape(3, 3).T)
        transforms = []
        for q in value["T_imu_cam"]:
            x, y, z, w = (q[name] for name in ("qx", "qy", "qz", "qw"))
            self.assertAlmostEqual(x * x + y * y + z * z + w * w, 1, 12)
            half = np.arctan2(np.linalg.norm((x, y, z)), w)
            T = pose(2 * half * np.array([x, y, z]) / np.linalg.norm((x, y, z)), [q["px"], q["py"], q["pz"]])
            transforms.append(np.linalg.inv(T))
        self.check(lambda w: gyro @ w, lambda a: accel @ a, transforms, np.linalg.inv(accel) @ T_A @ R_AI)
        self.assertEqual([c["camera_type"] for c in value["intrinsics"]], ["pinhole-radtan8", "kb4"])
        self.assertEqual(value["cam_time_offset_ns"], 2_500_000)

    def test_ros(self):
        done = self.exported("ros")
        self.assertIn("no place for the time shift", done.stderr)
        info = yaml.safe_load((self.out / "cam0.yaml").read_text())
        self.assertEqual(np.array(info["camera_matrix"]["data"]).reshape(3, 3)[[0, 1, 0, 1], [0, 1, 2, 2]].tolist(), INTRINSICS)
        self.assertEqual(info["distortion_coefficients"]["data"], [*RADTAN, 0.0])
        self.assertEqual((info["image_width"], info["image_height"], info["distortion_model"]), (752, 480, "plumb_bob"))
        self.assertEqual(yaml.safe_load((self.out / "transforms.yaml").read_text())["transforms"][1]["child"], "cam1")

    def test_a_lens_that_others_lack(self):
        """fov as the nearest equidistant lens: within 0.05 px over the image, which the note states."""
        self.put([("fov", FOV)])
        done = self.exported("openvins")
        self.assertIn("replaced by the nearest equidistant", done.stderr)
        camera = yaml.safe_load((self.out / "kalibr_imucam_chain.yaml").read_text().split("\n", 1)[1])["cam0"]
        D, f = camera["distortion_coeffs"], np.array(camera["intrinsics"][:2])
        for x, y in ((0.05, 0.02), (0.4, -0.3), (-0.75, 0.45)):
            difference = distort("fov", FOV, x, y) * np.array(INTRINSICS[:2]) - distort("equidistant", D, x, y) * f
            self.assertLess(np.linalg.norm(difference), 0.05)

    def test_refusals(self):
        for spoil, words in (("camchain-imucam.yaml", "camchain-imucam.yaml: file is missing"), ("imu.yaml", "imu.yaml: file is missing")):
            text = (self.dir / spoil).read_text()
            (self.dir / spoil).unlink()
            done = segcal("export", self.dir, "--to", "basalt", "--out", self.out)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(words, done.stderr)
            (self.dir / spoil).write_text(text)
        self.assertFalse(self.out.exists())
        (self.dir / "imu.yaml").write_text("update_rate: [1, 2\n")
        done = segcal("export", self.dir, "--to", "kalibr", "--out", self.out)
        self.assertEqual((done.returncode, done.stderr.count("\n"), self.out.exists()), (2, 1, False), done.stderr)


class Session(SessionCase):
    """`--to mcap`, read back by MCAP's and protobuf's own libraries: what went in comes out, number by number."""

    def exported(self, *more):
        done = segcal("export", self.out, "--to", "mcap", "--out", self.folder / "view", *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        topics = {}
        with open(self.folder / "view/session.mcap", "rb") as stream:
            for _, channel, message, content in make_reader(stream, decoder_factories=[DecoderFactory(), Json()]).iter_decoded_messages():
                topics.setdefault(channel.topic, []).append((message.log_time, content))
        return topics

    def test_session(self):
        topics = self.exported("--rec", self.rec)
        table = np.loadtxt(self.rec / "mav0/imu0/data.csv", delimiter=",")
        imu = [[*(v["gyro_rad_per_s"][a] for a in "xyz"), *(v["accel_m_per_s2"][a] for a in "xyz")] for _, v in topics["/imu"]]
        np.testing.assert_array_equal(imu, table[:, 1:7])
        self.assertEqual([(t, m.data, m.format) for t, m in topics["/cam0/image"]], [(self.stamp, self.picture, "png")])
        tracks = np.loadtxt(self.rec / "mav0/cam0/tracks.csv", delimiter=",", dtype=str, skiprows=1)
        points = [(t, p.x, p.y) for t, m in topics["/cam0/tracks"] for p in m.points[0].points]
        self.assertEqual(points, [(int(t), float(u), float(v)) for t, _, u, v in tracks])
        poses = np.loadtxt(self.out / "trajectory.tum")
        moved = [m.translation for _, m in topics["/tf"] if m.child_frame_id == "imu"]
        np.testing.assert_array_equal([[p.x, p.y, p.z] for p in moved], poses[:, 1:4])
        self.assertEqual(len(topics["/path"][0][1].poses), len(poses))
        camera = yaml.safe_load((self.out / "camchain-imucam.yaml").read_text())["cam0"]
        mount = next(m for _, m in topics["/tf"] if m.child_frame_id == "cam0")
        np.testing.assert_allclose([mount.translation.x, mount.translation.y, mount.translation.z], np.array(camera["T_imu_cam"])[:3, 3], atol=1e-12)
        self.assertEqual(list(topics["/cam0/calibration"][0][1].K)[2::3][:2], camera["intrinsics"][2:])
        result = json.loads((self.out / "result.json").read_text())
        self.assertIn("parameters observed", topics["/log"][0][1].message)
        self.assertEqual(len(topics["/map"]), sum(s["kept"] for s in result["segments"]))
        self.assertGreater(len(topics["/map"][0][1].data), 12 * 20)

    def test_without_recording_and_images(self):
        self.assertEqual(set(self.exported()), {"/tf", "/path", "/map", "/log", "/cam0/calibration"})
        self.assertNotIn("/cam0/image", self.exported("--rec", self.rec, "--no-images"))

    def test_refusals(self):
        for more, words in ((("--rec", self.folder / "none"), "none"), (("--to", "ros", "--no-images"), "for --to mcap")):
            to = () if "--to" in more else ("--to", "mcap")
            done = segcal("export", self.out, *to, "--out", self.folder / "view", *more)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse((self.folder / "view/session.mcap").exists())
        self.assertEqual(list(self.folder.glob("view/*")), [])  # as if it had not begun: the manifest too


class Json:
    def decoder_for(self, encoding, _):
        return json.loads if encoding == "json" else None


if __name__ == "__main__":
    main()
