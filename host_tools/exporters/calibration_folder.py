"""Reads what `segcal replay --out` wrote: camchain-imucam.yaml and imu.yaml.

    w_m = T_g w_I + b_g,   a_m = T_a R_AI a_I + b_a,   p_C = R_CI p_I + p_CI

T_g and T_a are upper triangular; I is the gyroscope's frame."""

from dataclasses import dataclass

import numpy as np
import yaml


class InputError(Exception):
    """What is wrong with which file, in one line."""


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


NOISE = ("accelerometer_noise_density", "accelerometer_random_walk", "gyroscope_noise_density", "gyroscope_random_walk")


def load(file):
    try:
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{file}: file is missing; `segcal replay --out` writes it") from None
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        raise InputError(f"{file}:{mark.line + 1 if mark else 1}: expected YAML") from None
    if not isinstance(content, dict):
        raise InputError(f"{file}:1: expected a YAML map")
    return content


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


def camera_of(file, name, node):
    if not isinstance(node, dict) or node.get("distortion_model") not in COEFFICIENTS:
        raise InputError(f"{file}: {name}: expected a distortion_model of {', '.join(COEFFICIENTS)}")
    model = node["distortion_model"]
    size = numbers(file, node, "resolution", (2,)).astype(int).tolist() if "resolution" in node else [0, 0]
    return Camera(numbers(file, node, "T_cam_imu", (4, 4)), model, numbers(file, node, "intrinsics", (4,)).tolist(),
                  numbers(file, node, "distortion_coeffs", (COEFFICIENTS[model],)).tolist(), size, float(node.get("timeshift_cam_imu", 0)))


def read_calibration(folder):
    chain, imu_file = folder / "camchain-imucam.yaml", folder / "imu.yaml"
    cameras, content = [], load(chain)
    while f"cam{len(cameras)}" in content:
        name = f"cam{len(cameras)}"
        cameras.append(camera_of(chain, name, content[name]))
    if not cameras:
        raise InputError(f"{chain}: expected an entry 'cam0'")
    if any(camera.size[0] < 1 for camera in cameras):
        raise InputError(f"{chain}: expected 'resolution' for each camera; a device log does not know it, --calib does")
    imu = load(imu_file)
    gyro, accel = imu.get("gyroscopes", {}), imu.get("accelerometers", {})
    figures = {name: float(numbers(imu_file, imu, name, ())) for name in NOISE}
    return Calibration(cameras, numbers(imu_file, gyro, "M", (3, 3)), numbers(imu_file, accel, "M", (3, 3)),
                       numbers(imu_file, accel, "C_accel_i", (3, 3)), float(numbers(imu_file, imu, "update_rate", ())), figures)
