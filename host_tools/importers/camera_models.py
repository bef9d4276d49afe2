"""Cameras of other tools to segcal's: a pinhole with radtan (k1 k2 p1 p2), equidistant (k1..k4) or fov (w)."""

import numpy as np

from streams import Camera, InputError

FIT_LIMIT_PX = 0.5  # a start that is off by less is far inside what a calibration corrects


def from_camera_info(message, where):
    """sensor_msgs/CameraInfo, of ROS 1 or 2. Raises InputError where it holds no calibration or an unknown lens."""
    K = getattr(message, "K", None) if hasattr(message, "K") else message.k
    D = list(message.D if hasattr(message, "D") else message.d)
    width, height = int(message.width), int(message.height)
    if len(K) != 9 or not (K[0] > 0 and K[4] > 0):
        return None  # the camera's driver was not calibrated: it publishes zeros
    intrinsics = [float(K[0]), float(K[4]), float(K[2]), float(K[5])]
    return from_opencv(width, height, intrinsics, message.distortion_model, [float(d) for d in D], where)


def from_opencv(width, height, intrinsics, model, D, where):
    """`model` is a name of ROS: plumb_bob, rational_polynomial, equidistant, fisheye, or empty for none."""
    if model in ("equidistant", "fisheye"):
        return Camera(width, height, intrinsics, "equidistant", (D + [0.0] * 4)[:4])
    if model not in ("plumb_bob", "rational_polynomial", "radtan", "radial-tangential", ""):
        raise InputError(f"{where}: expected distortion_model plumb_bob, rational_polynomial or equidistant, found '{model}'")
    D = D + [0.0] * (8 - len(D))
    if not any(D[4:]):
        return Camera(width, height, intrinsics, "radtan", D[:4])
    return nearest_lens(width, height, intrinsics, D, model)


def rational(D, x, y):
    """OpenCV's lens with k1 k2 p1 p2 k3 k4 k5 k6, normalised coordinates."""
    k1, k2, p1, p2, k3, k4, k5, k6 = D[:8]
    r2 = x * x + y * y
    radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)


def rays_of_image(width, height, intrinsics, D, n=25):
    """Undistorted normalised coordinates of a grid over the image, by fixed-point iteration; those that settle."""
    fx, fy, cx, cy = intrinsics
    u, v = np.meshgrid(np.linspace(0, width - 1, n), np.linspace(0, height - 1, n))
    xd, yd = ((u - cx) / fx).ravel(), ((v - cy) / fy).ravel()
    x, y = xd.copy(), yd.copy()
    with np.errstate(all="ignore"):
        for _ in range(200):
            ex, ey = rational(D, x, y)
            x, y = x - 0.7 * (ex - xd), y - 0.7 * (ey - yd)
        ex, ey = rational(D, x, y)
        good = np.hypot(ex - xd, ey - yd) < 1e-9
    return x[good], y[good], xd[good], yd[good]


def nearest_lens(width, height, intrinsics, D, model):
    """The lens of four coefficients that is nearest over the image; both kinds are linear in their coefficients."""
    x, y, xd, yd = rays_of_image(width, height, intrinsics, D)
    fits = {"radtan": fit_radtan(x, y, xd, yd), "equidistant": fit_equidistant(x, y, xd, yd)}
    name = min(fits, key=lambda lens: fits[lens][1])
    distortion, rms = fits[name]
    rms_px = rms * 0.5 * (intrinsics[0] + intrinsics[1])
    verdict = "" if rms_px < FIT_LIMIT_PX else ", too far for a start to be trusted: check it"
    note = f"lens {model} with {np.count_nonzero(D)} coefficients replaced by the nearest {name}, {rms_px:.2f} px away (RMS){verdict}"
    return Camera(width, height, intrinsics, name, distortion, [note])


def solve(columns, target):
    A = np.stack(columns, axis=1)
    solution, *_ = np.linalg.lstsq(A, target, rcond=None)
    return [float(s) for s in solution], float(np.sqrt(2 * np.mean((A @ solution - target) ** 2)))


def fit_radtan(x, y, xd, yd):
    r2 = x * x + y * y
    columns = [np.concatenate(c) for c in ((x * r2, y * r2), (x * r2 * r2, y * r2 * r2), (2 * x * y, r2 + 2 * y * y), (r2 + 2 * x * x, 2 * x * y))]
    return solve(columns, np.concatenate((xd - x, yd - y)))


def fit_equidistant(x, y, xd, yd):
    r = np.maximum(np.hypot(x, y), 1e-12)
    theta = np.arctan(r)
    columns = [np.concatenate((x / r * theta**n, y / r * theta**n)) for n in (3, 5, 7, 9)]
    return solve(columns, np.concatenate((xd - x / r * theta, yd - y / r * theta)))
