"""Basalt's calibration.json (basalt-headers: calibration.hpp, calib_bias.hpp, serialization/headers_serialization.h).

    a_B = (1 + S_a) a_m - b_a, S_a lower triangular;   w_B = (1 + S_g) w_m - b_g, S_g full, column by column
    p_B = T_imu_cam p_C;   t_imu = t_cam + cam_time_offset_ns;   noise as continuous densities"""

import json

import numpy as np

from accelerometer_frame import cameras_from, in_accelerometer_frame
from lenses import without_fov


def quaternion(R):
    """x y z w of a rotation, from its largest component (Shepperd 1978)."""
    t = np.array([R[0, 0], R[1, 1], R[2, 2], np.trace(R)])
    i = int(np.argmax(t))
    if i == 3:
        q = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1 + t[3]]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q = [0.0] * 4
        q[i], q[j], q[k], q[3] = 1 + 2 * t[i] - t[3], R[i, j] + R[j, i], R[i, k] + R[k, i], R[k, j] - R[j, k]
    q = np.array(q)
    return (q / np.linalg.norm(q) * (1 if q[3] >= 0 else -1)).tolist()


def pose(T):
    values = [*T[:3, 3].tolist(), *quaternion(T[:3, :3])]
    return dict(zip(("px", "py", "pz", "qx", "qy", "qz", "qw"), values))


def lens(model, distortion, intrinsics):
    values = dict(zip(("fx", "fy", "cx", "cy"), intrinsics))
    if model == "equidistant":
        return {"camera_type": "kb4", "intrinsics": {**values, **dict(zip(("k1", "k2", "k3", "k4"), distortion))}}
    more = dict(zip(("k1", "k2", "p1", "p2"), distortion)) | {"k3": 0.0, "k4": 0.0, "k5": 0.0, "k6": 0.0, "rpmax": 0.0}
    return {"camera_type": "pinhole-radtan8", "intrinsics": {**values, **more}}


def files_of(calibration):
    M_a, M_g, C_g, R_BI = in_accelerometer_frame(calibration)
    lenses, notes = without_fov(calibration.cameras)
    S_a = np.linalg.inv(M_a) - np.eye(3)
    S_g = np.linalg.inv(M_g @ C_g) - np.eye(3)
    shifts = {camera.timeshift_s for camera in calibration.cameras}
    if len(shifts) > 1:
        notes.append("Basalt has one time offset for all cameras: cam0's is written")
    noise = calibration.noise
    value = {
        "T_imu_cam": [pose(np.linalg.inv(T)) for T in cameras_from(calibration, R_BI)],
        "intrinsics": [lens(*of) for of in lenses],
        "resolution": [camera.size for camera in calibration.cameras],
        "calib_accel_bias": [0.0, 0.0, 0.0, S_a[0, 0], S_a[1, 0], S_a[2, 0], S_a[1, 1], S_a[2, 1], S_a[2, 2]],
        "calib_gyro_bias": [0.0, 0.0, 0.0, *S_g.T.ravel().tolist()],
        "imu_update_rate": calibration.rate_hz,
        "accel_noise_std": [noise["accelerometer_noise_density"]] * 3,
        "gyro_noise_std": [noise["gyroscope_noise_density"]] * 3,
        "accel_bias_std": [noise["accelerometer_random_walk"]] * 3,
        "gyro_bias_std": [noise["gyroscope_random_walk"]] * 3,
        "cam_time_offset_ns": round(calibration.cameras[0].timeshift_s * 1e9),
        "vignette": [],
    }
    return {"calibration.json": json.dumps({"value0": value}, indent=2) + "\n"}, notes
