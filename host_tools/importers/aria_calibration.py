"""Aria's factory calibration (the file tag calib_json of its VRS recordings) in segcal's terms.

Frames: the file places each camera and IMU in one device frame, p_device = T_Device_X p_X, metres. An IMU's reading is
raw = M rectified + bias with M a full matrix for the gyroscope; segcal's I is the frame in which that matrix is upper triangular, so that the
rotation that is left goes into T_CI and R_AI and nothing is lost.

Times: a reading's stamp is late by the delay of the sensor's filter, t_device = stamp - TimeOffsetSec_Device_X. The sign was measured, as
the two IMUs of one device sit on one rigid body: in two recordings of Gen 1 the stamps of the same rotation lie 2.35 +- 0.07 and 2.24 +- 0.32 ms
apart, and the offsets differ by 2.29 and 2.32 ms."""

import json
from dataclasses import dataclass

import numpy as np

from streams import Camera, InputError
from transforms import rotation, transform

# Streams by device: the type's number in VRS and the place; names as in calib_json.
LABELS = {
    "Aria": {"1201-1": "camera-slam-left", "1201-2": "camera-slam-right", "214-1": "camera-rgb", "211-1": "camera-et", "1202-1": "imu-right", "1202-2": "imu-left"},
    "Oatmeal": {"1201-1": "slam-front-left", "1201-2": "slam-front-right", "1201-3": "slam-side-left", "1201-4": "slam-side-right", "214-1": "camera-rgb",
                "211-1": "camera-et-left", "211-2": "camera-et-right", "1202-1": "imu-left", "1202-2": "imu-right"},
}
# Width, height of the calibrated image and the radius up to which its lens was measured, px, where the file has no ConfigData.
SENSORS = {
    "Aria": {"camera-slam-left": (640, 480, 330), "camera-slam-right": (640, 480, 330), "camera-rgb": (2880, 2880, 1415)},
    "Oatmeal": {"slam-front-left": (512, 512, 300), "slam-front-right": (512, 512, 300), "slam-side-left": (512, 512, 300),
                "slam-side-right": (512, 512, 300), "camera-rgb": (4032, 3024, 2202)},
}
# How the RGB camera's image of another size came out of the calibrated one: first cut by (x, y) px, then scaled.
CUTS = {(2880, 2880, 1408, 1408): (32, 32, 0.5), (2880, 2880, 704, 704): (32, 32, 0.25), (4032, 3024, 2016, 1512): (0, 0, 0.5),
        (4032, 3024, 2560, 3024): (640, 0, 1.0), (4032, 3024, 2560, 1920): (0, 0, 0.635)}
WIDEST = 1.4  # rad; beyond, x / z of a pinhole camera's ray grows without bound


@dataclass
class ImuModel:
    """w_m = T_g w_I + b, a_m = T_a R_AI a_I + b; T_g and T_a upper triangular, x_I = R_I_imu x_imu."""

    T_g: np.ndarray
    T_a: np.ndarray
    R_AI: np.ndarray
    R_I_imu: np.ndarray
    late_gyro_s: float  # stamp minus time of the motion
    late_accel_s: float


def scale_and_rotation(A):
    """A = T R with T upper triangular, its diagonal positive, and R a rotation."""
    P = np.eye(3)[::-1]
    Q, U = np.linalg.qr((P @ A).T)
    T, R = P @ U.T @ P, P @ Q.T
    signs = np.sign(np.diag(T))
    return np.triu(T * signs), signs[:, None] * R


def fisheye624(params, x, y):
    """Pixels of the rays (x, y, 1) under f cx cy k0..k5 p0 p1 s0..s3: a polynomial in the angle, tangential and thin-prism terms."""
    f, cx, cy, k, p, s = params[0], params[1], params[2], params[3:9], params[9:11], params[11:15]
    r = np.maximum(np.hypot(x, y), 1e-12)
    theta = np.arctan(r)
    radial = theta * (1 + sum(k_i * theta ** (2 * i + 2) for i, k_i in enumerate(k))) / r
    u, v = radial * x, radial * y
    q = u * u + v * v
    mixed = 2 * (u * p[0] + v * p[1])
    return f * (u + mixed * u + q * p[0] + q * (s[0] + s[1] * q)) + cx, f * (v + mixed * v + q * p[1] + q * (s[2] + s[3] * q)) + cy


def rays(n=40):
    """x, y of rays that lie evenly over the image of an equidistant lens, up to WIDEST."""
    theta, phi = np.meshgrid(WIDEST * np.sqrt((np.arange(n) + 0.5) / n), 2 * np.pi * np.arange(3 * n) / (3 * n))
    return (np.tan(theta) * np.cos(phi)).ravel(), (np.tan(theta) * np.sin(phi)).ravel()


def nearest_equidistant(params, width, height, radius):
    """f, cx, cy, k1..k4 of the equidistant lens nearest to a Fisheye624 over the image within `radius` of the principal point, and how near
    (RMS, px). All are linear: u = cx + f (x / r) (theta + k1 theta^3 + ...)."""
    x, y = rays()
    u, v = fisheye624(params, x, y)
    seen = (u > -0.5) & (u < width - 0.5) & (v > -0.5) & (v < height - 0.5) & (np.hypot(u - params[1], v - params[2]) < radius)
    if np.count_nonzero(seen) < 20:
        raise ValueError("none of the rays is in the image")
    x, y, u, v = x[seen], y[seen], u[seen], v[seen]
    r = np.hypot(x, y)
    theta, one, none = np.arctan(r), np.ones_like(r), np.zeros_like(r)
    columns = [np.concatenate((x / r * theta**i, y / r * theta**i)) for i in (1, 3, 5, 7, 9)]
    A = np.stack([np.concatenate((one, none)), np.concatenate((none, one)), *columns], axis=1)
    target = np.concatenate((u, v))
    (cx, cy, f, *fk), *_ = np.linalg.lstsq(A, target, rcond=None)
    away = float(np.sqrt(2 * np.mean((A @ np.array([cx, cy, f, *fk]) - target) ** 2)))
    return float(f), float(cx), float(cy), [float(c / f) for c in fk], away


class Factory:
    """The cameras and IMUs of one device, by their labels."""

    def __init__(self, text, where):
        self.where = where
        try:
            content = json.loads(text) if text else {}
            self.cameras = {entry["Label"]: entry for entry in content.get("CameraCalibrations", [])}
            self.imus = {entry["Label"]: entry for entry in content.get("ImuCalibrations", [])}
            self.device = content.get("DeviceClassInfo", {}).get("DeviceClass", "")
        except (ValueError, TypeError, KeyError, AttributeError):
            raise InputError(f"{where}: damaged VRS file: expected JSON with CameraCalibrations in its tag calib_json") from None

    def pose(self, entry, name):
        try:
            w, xyz = entry[name]["UnitQuaternion"]
            q, p = np.array([w, *xyz], float), np.array(entry[name]["Translation"], float)
            if q.shape != (4,) or p.shape != (3,) or not abs(np.linalg.norm(q) - 1) < 1e-3 or not np.isfinite(p).all():
                raise ValueError
            return transform(rotation(q), p)
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{self.where}: calib_json: expected a pose '{name}' of {entry.get('Label')}") from None

    def imu(self, label):
        """ImuModel, or None where the file has none of that IMU."""
        entry = self.imus.get(label)
        if entry is None:
            return None
        try:
            M_g, M_a = (np.array(entry[s]["Model"]["RectificationMatrix"], float).reshape(3, 3) for s in ("Gyroscope", "Accelerometer"))
            late = [float(entry[s][f"TimeOffsetSec_Device_{short}"]) for s, short in (("Gyroscope", "Gyro"), ("Accelerometer", "Accel"))]
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{self.where}: calib_json: expected matrices and time offsets of {label}") from None
        if not all(np.linalg.det(M) > 0 for M in (M_g, M_a)) or not np.isfinite([*M_g.ravel(), *M_a.ravel(), *late]).all():
            raise InputError(f"{self.where}: calib_json: expected matrices and time offsets of {label}")
        T_g, R = scale_and_rotation(M_g)
        return ImuModel(T_g, *scale_and_rotation(M_a @ R.T), R, *late)

    def extrinsics(self, camera, imu):
        """T_CI, 4 x 4, p_C = T_CI p_I, with I of ImuModel; None where one of the two is not calibrated."""
        if camera not in self.cameras or (model := self.imu(imu)) is None:
            return None
        T_device_I = self.pose(self.imus[imu], "T_Device_Imu") @ transform(model.R_I_imu.T, np.zeros(3))
        return np.linalg.inv(self.pose(self.cameras[camera], "T_Device_Camera")) @ T_device_I

    def timeshift(self, camera, imu):
        """s, t_imu = t_cam + shift, of the gyroscope's stamps; 0 where nothing is stated."""
        model, entry = self.imu(imu), self.cameras.get(camera, {})
        try:
            return model.late_gyro_s - float(entry.get("TimeOffsetSec_Device_Camera", 0)) if model else 0.0
        except (TypeError, ValueError):
            raise InputError(f"{self.where}: calib_json: expected a time offset of {camera}") from None

    def camera(self, label, width, height):
        """Camera with the nearest equidistant lens for images of this size, or None. The note says how near it is."""
        try:
            return self.nearest(label, width, height)
        except (KeyError, TypeError, ValueError, AttributeError, ZeroDivisionError, np.linalg.LinAlgError):
            raise InputError(f"{self.where}: calib_json: expected the lens and the size of the images of {label}") from None

    def nearest(self, label, width, height):
        entry = self.cameras.get(label)
        projection = entry.get("Projection", {}) if entry else {}
        params = [float(value) for value in projection.get("Params", [])]
        size = self.calibrated_size(entry, label)
        if projection.get("Name") != "FisheyeRadTanThinPrism" or len(params) != 15 or size is None:
            return None
        wide, high, radius = size
        if (wide, high) != (width, height):
            if (wide, high, width, height) not in CUTS:
                return None
            left, top, scale = CUTS[wide, high, width, height]
            # Pixel centres are whole numbers: the image's edge, which scaling keeps, lies half a pixel before the first.
            params = [params[0] * scale, (params[1] - left + 0.5) * scale - 0.5, (params[2] - top + 0.5) * scale - 0.5, *params[3:]]
            radius *= scale
        f, cx, cy, k, away = nearest_equidistant(params, width, height, radius)
        return Camera(width, height, [f, f, cx, cy], "equidistant", k,
                      [f"factory lens Fisheye624 replaced by the nearest equidistant, {away:.2f} px away (RMS), which stays in the residuals"])

    def calibrated_size(self, entry, label):
        """(width, height, radius up to which the lens was measured), px; None where it is not known."""
        config = entry.get("ConfigData") if entry else None
        if config:
            return int(config["ImageWidth"]), int(config["ImageHeight"]), float(config.get("ValidRadius", config["ImageWidth"] / 2))
        return SENSORS.get(self.device, {}).get(label)
