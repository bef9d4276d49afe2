"""Reads a folder with a calibration, as `segcal replay --out` writes it: camchain-imucam.yaml and imu.yaml.

    w_m = T_g w_I + b_g,   a_m = T_a R_AI a_I + b_a,   p_C = R_CI p_I + p_CI

T_g and T_a are upper triangular; I is the gyroscope's frame."""

from dataclasses import dataclass

import numpy as np

from input_error import InputError
from yaml_file import read_yaml


@dataclass
class Camera:
    T_CI: np.ndarray  # 4 x 4
    model: str  # radtan, equidistant, fov
    intrinsics: list  # fx fy cx cy, px
    distortion: list
    size: list  # width, height, px
    timeshift_s: float  # t_imu = t_cam + shift


@dataclass
class Calibration:
    cameras: list
    T_g: np.ndarray
    T_a: np.ndarray
    R_AI: np.ndarray
    rate_hz: float
    noise: dict  # Kalibr's four names


BY_REPLAY = "file is missing; `segcal replay --out` writes it"
NOISE = ("accelerometer_noise_density", "accelerometer_random_walk", "gyroscope_noise_density", "gyroscope_random_walk")


def numbers(file, node, name, shape):
    try:
        values = np.array(node[name], float)
    except KeyError:
        raise InputError(f"{file}: expected an entry '{name}'") from None
    except (TypeError, ValueError):
        raise InputError(f"{file}: expected numbers in '{name}'") from None
    if values.shape != shape or not np.isfinite(values).all():
        raise InputError(f"{file}: expected {' x '.join(map(str, shape))} finite numbers in '{name}'")
    return values


COEFFICIENTS = {"radtan": 4, "equidistant": 4, "fov": 1}
OTHER_NAMES = {"radial-tangential": "radtan", "equi": "equidistant"}


def camera_of(file, name, node):
    model = str(node.get("distortion_model")) if isinstance(node, dict) else None
    model = OTHER_NAMES.get(model, model)
    if model not in COEFFICIENTS:
        raise InputError(f"{file}: {name}: expected a distortion_model of {', '.join(COEFFICIENTS)}")
    size = numbers(file, node, "resolution", (2,)).astype(int).tolist() if "resolution" in node else [0, 0]
    return Camera(numbers(file, node, "T_cam_imu", (4, 4)), model, numbers(file, node, "intrinsics", (4,)).tolist(),
                  numbers(file, node, "distortion_coeffs", (COEFFICIENTS[model],)).tolist(), size, float(node.get("timeshift_cam_imu", 0)))


def read_chain(file, missing="file is missing"):
    """Cameras of Kalibr's camchain-imucam.yaml; `size` is [0, 0] where it does not say."""
    cameras, content = [], read_yaml(file, missing)
    while f"cam{len(cameras)}" in content:
        name = f"cam{len(cameras)}"
        cameras.append(camera_of(file, name, content[name]))
    if not cameras:
        raise InputError(f"{file}: expected an entry 'cam0'")
    return cameras


def noise_figures(file, node):
    """The four of NOISE, as they stand."""
    return {name: float(numbers(file, node, name, ())) for name in NOISE}


def read_calibration(folder):
    chain, imu_file = folder / "camchain-imucam.yaml", folder / "imu.yaml"
    cameras = read_chain(chain, BY_REPLAY)
    if any(camera.size[0] < 1 for camera in cameras):
        raise InputError(f"{chain}: expected 'resolution' for each camera; a device log does not know it, --calib does")
    imu = read_yaml(imu_file, BY_REPLAY)
    gyro, accel = imu.get("gyroscopes", {}), imu.get("accelerometers", {})
    return Calibration(cameras, numbers(imu_file, gyro, "M", (3, 3)), numbers(imu_file, accel, "M", (3, 3)),
                       numbers(imu_file, accel, "C_accel_i", (3, 3)), float(numbers(imu_file, imu, "update_rate", ())),
                       noise_figures(imu_file, imu))
