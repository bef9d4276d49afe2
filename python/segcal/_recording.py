"""Recordings in EuRoC's ASL layout with tracks, and the configuration that goes with them (docs/formats.md)."""

from __future__ import annotations

import dataclasses
import io
import pathlib
import warnings

import numpy as np
import yaml

from . import _core
from ._manifest import check_folder

LENSES = {"fov": (0, 1), "radtan": (1, 4), "radial-tangential": (1, 4), "equidistant": (2, 4), "equi": (2, 4)}  # model, coefficients


@dataclasses.dataclass
class Frame:
    """All corners of one moment."""
    t_ns: int
    track_id: np.ndarray   # (n)
    uv: np.ndarray         # (n, 2), px
    camera: np.ndarray     # (n)


@dataclasses.dataclass
class Recording:
    t_ns: np.ndarray       # (n) of the IMU's samples
    gyro: np.ndarray       # (n, 3), rad/s
    accel: np.ndarray      # (n, 3), m/s^2
    temperature: np.ndarray | None
    frames: list[Frame]
    config: _core.Config   # defaults of `segcal replay`, and the recording's calibration and noise


def load(file, columns):
    """Rows of a table. A last line that does not end may be cut inside a number: it is left out, with a warning."""
    if not file.exists():
        raise FileNotFoundError(f"{file}: missing")
    if not file.is_file():
        raise ValueError(f"{file}: expected a regular file")
    text = file.read_text(encoding="utf-8")
    if not text.endswith("\n"):
        warnings.warn(f"{file}: the last line does not end, so that it may be cut: it is left out", stacklevel=3)
        text = text[:text.rfind("\n") + 1]
    try:
        return np.atleast_1d(np.loadtxt(io.StringIO(text), delimiter=",", comments="#", dtype=columns))
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


def read_imu(file):
    columns = [("t", "i8"), *((name, "f8") for name in ("wx", "wy", "wz", "ax", "ay", "az"))]
    with open(file, encoding="utf-8") as lines:
        first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    if first.count(",") == 7:
        columns.append(("celsius", "f8"))
    rows = load(file, columns)
    gyro, accel = (np.column_stack([rows[f"{s}{axis}"] for axis in "xyz"]) for s in "wa")
    return rows["t"], gyro, accel, rows["celsius"] if first.count(",") == 7 else None


def frames_of(file, camera):
    """Rows of one stamp are one image; an id that comes again begins another one, which the core then refuses and counts."""
    rows = load(file, [("t", "i8"), ("id", "u4"), ("u", "f8"), ("v", "f8")])
    frames, begin, seen = [], 0, set()
    for i in range(len(rows) + 1):
        if i < len(rows) and rows["t"][i] == rows["t"][begin] and rows["id"][i] not in seen:
            seen.add(rows["id"][i])
            continue
        part = rows[begin:min(i, begin + _core.MAX_TRACKS)]
        frames.append(Frame(int(part["t"][0]), part["id"], np.column_stack([part["u"], part["v"]]), np.full(len(part), camera, np.int32)))
        begin, seen = i, {rows["id"][i]} if i < len(rows) else set()
    return frames


def together(cameras):
    """Images of one stamp are one frame; cam0's order is the log's."""
    frames = list(cameras[0])
    for others in cameras[1:]:
        at = {frame.t_ns: i for i, frame in enumerate(frames)}
        for frame in others:
            if frame.t_ns in at:
                first = frames[at[frame.t_ns]]
                frames[at[frame.t_ns]] = Frame(first.t_ns, np.concatenate([first.track_id, frame.track_id]), np.concatenate([first.uv, frame.uv]),
                                               np.concatenate([first.camera, frame.camera]))
            else:
                frames.append(frame)
        frames.sort(key=lambda frame: frame.t_ns)
    return frames


def quaternion(R):
    """w x y z of a rotation matrix."""
    w, x, y, z = (np.sqrt(max(0.0, 1 + s @ np.diag(R))) / 2 for s in np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]))
    largest = np.argmax([w, x, y, z])
    d = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    s = [R[1, 0] + R[0, 1], R[0, 2] + R[2, 0], R[2, 1] + R[1, 2]]
    q = [[4 * w * w, d[0], d[1], d[2]], [d[0], 4 * x * x, s[0], s[1]], [d[1], s[0], 4 * y * y, s[2]], [d[2], s[1], s[2], 4 * z * z]][largest]
    return list(np.array(q) / np.linalg.norm(q))


def matrix(value, rows):
    return np.array(value, float).reshape(rows, rows)


def camera_of(entry, file):
    T = matrix(entry["T_cam_imu"], 4) if "T_cam_imu" in entry else np.linalg.inv(matrix(entry["T_imu_cam"], 4))
    U, _, Vt = np.linalg.svd(T[:3, :3])  # printed digits are no rotation: the nearest one
    lens = entry["distortion_model"]
    if lens not in LENSES or entry["camera_model"] != "pinhole":
        raise ValueError(f"{file}: expected camera_model pinhole and distortion_model fov, radtan or equidistant, found {lens}")
    camera = _core.Camera()
    camera.model = LENSES[lens][0]
    camera.q_CI, camera.p_CI = quaternion(U @ Vt), list(T[:3, 3])
    camera.intrinsics = [float(v) for v in entry["intrinsics"]]
    camera.distortion = [float(v) for v in entry["distortion_coeffs"][:LENSES[lens][1]]]
    readout, size = entry.get("readout", "rows"), entry.get("resolution", [0, 0])  # of a rolling shutter
    if readout not in ("rows", "columns"):
        raise ValueError(f"{file}: expected readout rows or columns, found {readout}")
    camera.height = int(size[1]) if readout == "rows" else -max(1, int(size[0] or 2 * camera.intrinsics[2]))
    return camera


def imu_of(file):
    """T_g, T_a and R_AI as segcal writes them."""
    imu = _core.ImuCalibration()
    content = yaml.safe_load(file.read_text()) if file.exists() else {}
    content = content.get("imu0", content)
    for sensor, group in (("gyro", "gyroscopes"), ("accel", "accelerometers")):
        M = matrix(content.get(group, {}).get("M", np.eye(3)), 3)
        if np.tril(M, -1).any():
            raise ValueError(f"{file}: expected {group}.M upper triangular; segcal replay reads the other forms")
        setattr(imu, f"{sensor}_scale", list(np.diag(M)))
        setattr(imu, f"{sensor}_misalignment", [M[0, 1], M[0, 2], M[1, 2]])
    if "C_accel_i" in content.get("accelerometers", {}):
        imu.q_AI = quaternion(matrix(content["accelerometers"]["C_accel_i"], 3))
    return imu


def config_of(camchain, noise_file, cameras):
    """What `segcal replay` gives the core when no option is set."""
    config, chain = _core.Config(), yaml.safe_load(camchain.read_text())
    config.set_cameras([camera_of(chain[f"cam{i}"], camchain) for i in range(cameras)])
    config.imu = imu_of(camchain.parent / "imu.yaml")
    noise = yaml.safe_load(noise_file.read_text())
    config.imu_rate_hz = float(noise["rate_hz"])
    for ours, theirs in (("gyro_noise_density", "gyroscope_noise_density"), ("gyro_random_walk", "gyroscope_random_walk"),
                         ("accel_noise_density", "accelerometer_noise_density"), ("accel_random_walk", "accelerometer_random_walk")):
        setattr(config, ours, float(noise[theirs]))
    config.pixel_sigma, config.segment_s, config.keep_segments, config.seed = 0.5, 4.0, 8, 1
    config.outdated_level, config.trigger_fraction, config.filter_share = 1e-3, -1.0, 1.0
    return config


def read(path, cameras=1, calib=None):
    """A recording with tracks (`segcal track` makes them from images). `calib`: another camchain-imucam.yaml than its own. Raises
    FileNotFoundError, KeyError or ValueError with the file and what was expected there."""
    root = pathlib.Path(path)
    check_folder(root)
    t_ns, gyro, accel, temperature = read_imu(root / "mav0" / "imu0" / "data.csv")
    frames = together([frames_of(root / "mav0" / f"cam{i}" / "tracks.csv", i) for i in range(cameras)])
    camchain = pathlib.Path(calib) if calib else root / "camchain-imucam.yaml"
    config = config_of(camchain, root / "mav0" / "imu0" / "sensor.yaml", cameras)
    config.has_temperature = int(temperature is not None)
    return Recording(t_ns, gyro, accel, temperature, frames, config)
