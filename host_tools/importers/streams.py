"""What a log holds, whatever its format: streams of IMU samples and of images, and what is known of a camera.

A format is a module of formats/ with `probe(paths)`, which returns a Source or None. A Source has

    title                      what the log is, in words
    streams() -> [StreamInfo]  what is inside, without decoding images
    imu(name) -> Imu           all samples of one stream
    frames(name) -> iterator of Image, in the order of the log
    calib(name) -> Camera or None, of a stream of images
    extrinsics(camera, imu) -> T_CI (4 x 4, p_C = T_CI p_I, m) or None

and, where the log states more than that,

    noise() -> (four figures, origin) or None
    imu_model(imu) -> T_g, T_a, R_AI (docs/formats.md, imu.yaml) of the frame I of `extrinsics`, or None
    timeshift(camera, imu) -> s, t_imu = t_cam + shift

and raises InputError where the file is damaged.
"""

from dataclasses import dataclass, field

import numpy as np

from input_error import InputError  # noqa: F401  formats raise it


@dataclass
class StreamInfo:
    name: str
    kind: str  # "imu", "gyro", "accel", "camera"; "other": not used, shown by --list
    count: int
    note: str = ""  # for --list: type of the messages, rate
    aside: str = ""  # why it is taken only where it is named, or where there is no other; empty: it is a first choice


@dataclass
class Imu:
    """Samples of one stream. `gyro` and `accel` are n x 3, or None where the stream has not the sensor."""

    name: str
    t_ns: np.ndarray  # int64, stamped by the sensor or its driver
    log_ns: np.ndarray  # int64, when it was written; the same as t_ns where the format has one stamp only
    gyro: np.ndarray | None = None
    accel: np.ndarray | None = None
    temperature: np.ndarray | None = None  # degC
    gyro_unit: str = ""  # "rad/s", "deg/s"; empty: the format does not say
    accel_unit: str = ""  # "m/s^2", "g"; empty: the format does not say

    def chosen(self, rows):
        """The same with these rows only."""

        def part(values):
            return None if values is None else values[rows]

        return Imu(self.name, self.t_ns[rows], self.log_ns[rows], part(self.gyro), part(self.accel), part(self.temperature),
                   self.gyro_unit, self.accel_unit)


@dataclass
class Image:
    """One image: `pixels` (h x w grey or h x w x 3 RGB, 8 or 16 bit), or a file's bytes that are kept as they are."""

    t_ns: int
    log_ns: int
    pixels: np.ndarray | None = None
    encoded: bytes | None = None
    suffix: str = ".png"
    exposure_ns: int = 0  # 0: nobody says


@dataclass
class Camera:
    """A pinhole camera with one of the lenses that segcal knows, in Kalibr's terms."""

    width: int
    height: int
    intrinsics: list  # fx fy cx cy, px
    distortion_model: str  # "radtan", "equidistant", "fov"
    distortion: list
    notes: list = field(default_factory=list)  # what was changed on the way, in words
    readout: str = "rows"  # or "columns": what a rolling shutter exposes one after another
