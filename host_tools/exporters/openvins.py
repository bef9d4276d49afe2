"""OpenVINS' kalibr_imucam_chain.yaml and kalibr_imu_chain.yaml, as in its config/ (docs, "IMU intrinsic models").

Its model rpng is segcal's: upper triangular scales, the gyroscope's frame as the IMU's, R_IMUtoACC = R_AI."""

import numpy as np

from calibration_folder import NOISE
from lenses import without_fov
from yaml_text import matrix, number, row

HEAD = "%YAML:1.0\n\n"


def files_of(calibration):
    lenses, notes = without_fov(calibration.cameras)
    chain = HEAD
    n = len(calibration.cameras)
    for i, (camera, (model, distortion, intrinsics)) in enumerate(zip(calibration.cameras, lenses)):
        chain += f"cam{i}:\n" + block("T_imu_cam", np.linalg.inv(camera.T_CI))
        chain += f"  cam_overlaps: {[k for k in range(n) if k != i]}\n  camera_model: pinhole\n"
        chain += f"  distortion_coeffs: {row(distortion)}\n  distortion_model: {model}\n  intrinsics: {row(intrinsics)}\n"
        chain += f"  resolution: {camera.size}\n  rostopic: /cam{i}/image_raw\n  timeshift_cam_imu: {number(camera.timeshift_s)}\n"
    imu = HEAD + "imu0:\n" + block("T_i_b", np.eye(4)) + "".join(f"  {name}: {number(calibration.noise[name])}\n" for name in NOISE)
    imu += f"  rostopic: /imu0\n  time_offset: 0.0\n  update_rate: {number(calibration.rate_hz)}\n  model: \"rpng\"\n"
    for name, values in (("Tw", calibration.T_g), ("R_IMUtoGYRO", np.eye(3)), ("Ta", calibration.T_a), ("R_IMUtoACC", calibration.R_AI),
                         ("Tg", np.zeros((3, 3)))):
        imu += block(name, values)
    return {"kalibr_imucam_chain.yaml": chain, "kalibr_imu_chain.yaml": imu}, notes


def block(name, values):
    return matrix(name, values).replace("\n  -", "\n    -")
