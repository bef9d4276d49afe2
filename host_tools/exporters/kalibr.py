"""Kalibr's results: camchain-imucam.yaml and imu.yaml (kalibr/wiki, "yaml formats" and "Multi IMU and IMU intrinsic calibration").

Its model scale-misalignment: a_m = M_a a_B, w_m = M_g C_gyro_i w_B + A a_B, M lower triangular, B the accelerometer's frame."""

import numpy as np

from accelerometer_frame import cameras_from, in_accelerometer_frame
from calibration_folder import NOISE
from yaml_text import matrix, number, row


def files_of(calibration):
    M_a, M_g, C_g, R_BI = in_accelerometer_frame(calibration)
    transforms = cameras_from(calibration, R_BI)
    chain = ""
    for i, (camera, T_CB) in enumerate(zip(calibration.cameras, transforms)):
        chain += f"cam{i}:\n" + matrix("T_cam_imu", T_CB)
        if i > 0:
            chain += matrix("T_cn_cnm1", T_CB @ np.linalg.inv(transforms[i - 1]))
        chain += f"  cam_overlaps: {[k for k in range(len(transforms)) if k != i]}\n  camera_model: pinhole\n"
        chain += f"  distortion_coeffs: {row(camera.distortion)}\n  distortion_model: {camera.model}\n  intrinsics: {row(camera.intrinsics)}\n"
        chain += f"  resolution: {camera.size}\n  rostopic: /cam{i}/image_raw\n  timeshift_cam_imu: {number(camera.timeshift_s)}\n"
    imu = "imu0:\n" + matrix("T_i_b", np.eye(4)) + "".join(f"  {name}: {number(calibration.noise[name])}\n" for name in NOISE)
    imu += "  accelerometers:\n" + matrix("M", M_a, "    ")
    imu += "  gyroscopes:\n" + matrix("A", np.zeros((3, 3)), "    ") + matrix("C_gyro_i", C_g, "    ") + matrix("M", M_g, "    ")
    imu += f"  model: scale-misalignment\n  rostopic: /imu0\n  time_offset: 0.0\n  update_rate: {number(calibration.rate_hz)}\n"
    return {"camchain-imucam.yaml": chain, "imu.yaml": imu}, []
