import os
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_TRACKS: int
STORAGE_BYTES: int
__version__: str

class Camera:
    model: int
    height: int
    q_CI: list[float]
    p_CI: list[float]
    intrinsics: list[float]
    distortion: list[float]
    def __init__(self) -> None: ...

class ImuCalibration:
    gyro_scale: list[float]
    gyro_misalignment: list[float]
    accel_scale: list[float]
    accel_misalignment: list[float]
    q_AI: list[float]
    def __init__(self) -> None: ...

class Config:
    imu: ImuCalibration
    imu_rate_hz: float
    gyro_noise_density: float
    gyro_random_walk: float
    accel_noise_density: float
    accel_random_walk: float
    pixel_sigma: float
    segment_s: float
    keep_segments: int
    metric: int
    strategy: int
    seed: int
    outdated_level: float
    trigger_fraction: float
    filter_share: float
    estimate_effects: int
    has_temperature: int
    def __init__(self) -> None: ...
    def set_cameras(self, cameras: list[Camera]) -> None: ...

class Parameter(TypedDict):
    name: str
    value: float
    sigma: float
    unit: str
    initial: float
    prior_sigma: float
    verdict: str

class Result(TypedDict):
    status: str
    parameters: list[Parameter]
    segments: int
    chi2: float
    dof: float
    noise_scale: float
    reprojection_rms_px: float
    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]

@dataclass
class Frame:
    t_ns: int
    track_id: NDArray[Any]
    uv: NDArray[np.float64]
    camera: NDArray[np.int32]

@dataclass
class Recording:
    t_ns: NDArray[np.int64]
    gyro: NDArray[np.float64]
    accel: NDArray[np.float64]
    temperature: NDArray[np.float64] | None
    frames: list[Frame]
    config: Config

def read(path: str | os.PathLike[str], cameras: int = 1, calib: str | os.PathLike[str] | None = None) -> Recording: ...

class Device:
    def __init__(self, config: Config) -> None: ...
    def push_imu(self, t_ns: ArrayLike, gyro: ArrayLike, accel: ArrayLike, temperature: ArrayLike | None = None) -> int: ...
    def push_tracks(self, t_ns: int, track_id: ArrayLike, uv: ArrayLike, camera: ArrayLike | None = None) -> int: ...
    def background(self, slices: int = ...) -> int: ...
    def flush(self) -> int: ...
    def new_session(self) -> int: ...
    def calibrate(self) -> bool: ...
    def run(self, recording: Recording) -> bool: ...
    def result(self) -> Result | None: ...
    def pose(self) -> NDArray[np.float64] | None: ...
    def result_hash(self) -> str: ...
