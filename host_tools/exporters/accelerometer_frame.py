"""The same IMU model in the frame of the accelerometer, with lower triangular scales, as Kalibr and Basalt have it."""

import numpy as np


def lower_times_rotation(A):
    """A = L R with L lower triangular, its diagonal positive, and R a rotation (QR of the transpose)."""
    Q, U = np.linalg.qr(A.T)
    signs = np.diag(np.sign(np.diag(U)))
    return (signs @ U).T, (Q @ signs).T


def in_accelerometer_frame(calibration):
    """(M_a, M_g, C_g, R_BI): a_m = M_a a_B, w_m = M_g C_g w_B in the body frame B = R_BI I, M_a and M_g lower triangular.

    T_a R_AI = M_a R_BI defines B; the rates are w_m = T_g R_BI' w_B."""
    M_a, R_BI = lower_times_rotation(calibration.T_a @ calibration.R_AI)
    M_g, C_g = lower_times_rotation(calibration.T_g @ R_BI.T)
    return M_a, M_g, C_g, R_BI


def cameras_from(calibration, R_BI):
    """T_CB of each camera: B turns with R_BI and has I's origin."""
    T_IB = np.eye(4)
    T_IB[:3, :3] = R_BI.T
    return [camera.T_CI @ T_IB for camera in calibration.cameras]
