"""A lens that another tool lacks, replaced by the nearest one it has."""

import numpy as np


def rays(camera, n=25):
    """Normalised coordinates over the image, undistorted (x, y) and distorted, for a fov lens:
    r_d = atan(2 r tan(w/2)) / w (Devernay and Faugeras, Machine Vision and Applications 13, 2001)."""
    fx, fy, cx, cy = camera.intrinsics
    w = camera.distortion[0]
    u, v = np.meshgrid(np.linspace(0, camera.size[0] - 1, n), np.linspace(0, camera.size[1] - 1, n))
    xd, yd = ((u - cx) / fx).ravel(), ((v - cy) / fy).ravel()
    rd = np.maximum(np.hypot(xd, yd), 1e-12)
    inside = rd * w < 1.55  # beyond, the ray is at right angles to the axis or behind the camera
    xd, yd, rd = xd[inside], yd[inside], rd[inside]
    r = np.tan(rd * w) / (2 * np.tan(w / 2)) if abs(w) > 1e-6 else rd
    return xd * r / rd, yd * r / rd, xd, yd


def fov_as_equidistant(camera, name):
    """(coefficients k1..k4, intrinsics, note). In the middle of the image a fov lens magnifies by c = 2 tan(w/2) / w, an
    equidistant one by 1: the focal lengths take c. r_d / c = theta + k1 theta^3 + ... is linear in the coefficients."""
    w = camera.distortion[0]
    c = 2 * np.tan(w / 2) / w if abs(w) > 1e-6 else 1.0
    x, y, xd, yd = rays(camera)
    theta, rd = np.arctan(np.hypot(x, y)), np.hypot(xd, yd) / c
    A = np.stack([theta**n for n in (3, 5, 7, 9)], axis=1)
    k, *_ = np.linalg.lstsq(A, rd - theta, rcond=None)
    fx, fy, cx, cy = camera.intrinsics
    rms_px = float(np.sqrt(np.mean((A @ k - rd + theta) ** 2))) * c * 0.5 * (fx + fy)
    note = f"{name}: lens fov replaced by the nearest equidistant one, {rms_px:.2g} px away (RMS over the image)"
    return [float(v) for v in k], [float(fx * c), float(fy * c), cx, cy], note


def without_fov(cameras):
    """[(model, coefficients, intrinsics)] with fov replaced, and notes."""
    out, notes = [], []
    for i, camera in enumerate(cameras):
        if camera.model != "fov":
            out.append((camera.model, camera.distortion, camera.intrinsics))
            continue
        k, intrinsics, note = fov_as_equidistant(camera, f"cam{i}")
        out.append(("equidistant", k, intrinsics))
        notes.append(note)
    return out, notes
