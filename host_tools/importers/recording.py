"""Writes a recording folder. It appears whole: everything goes to a folder beside it, which gets its name at the end."""

import os
import shutil
import signal
from pathlib import Path

import fsspec
import numpy as np
import output_run
from PIL import Image as Png

from image_files import size_of
from streams import InputError

IMU_HEADER = "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],a_z [m s^-2]"
NOISE_NAMES = ("gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density", "accelerometer_random_walk")
NOISE_UNITS = ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", "m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")
# Several times a consumer IMU's data sheet (BMI160: 1.2e-4 rad/s/sqrt(Hz), 1.8e-3 m/s^2/sqrt(Hz)), for vibration and clocks.
ASSUMED_NOISE = (5e-4, 5e-5, 5e-3, 5e-4)


def yaml_number(value):
    """YAML 1.1 (PyYAML, so Kalibr) takes 2e-05 for a word: 2.0e-05."""
    text = repr(float(value))
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def yaml_list(values):
    return "[" + ", ".join(map(yaml_number, values)) + "]"


def interrupted(*_):
    raise KeyboardInterrupt


class NewFolder:
    """`with NewFolder(out) as part:` fills `part`; it becomes `out` if nothing was raised, and else goes away."""

    def __init__(self, out):
        self.out = Path(out)
        self.part = self.out.resolve().parent / f".{self.out.resolve().name}.{os.getpid()}.part"

    def __enter__(self):
        if self.out.exists() and (not self.out.is_dir() or any(self.out.iterdir())):
            raise InputError(f"{self.out}: expected a new or empty folder for the recording")
        try:
            self.part.mkdir(parents=True)
        except OSError as error:
            raise InputError(f"{self.out}: cannot be written: {error.strerror}") from None
        signal.signal(signal.SIGTERM, interrupted)
        return self.part

    def __exit__(self, kind, error, trace):
        if kind is None:
            self.write_manifest()
            if self.out.exists():
                self.out.rmdir()
            os.replace(self.part, self.out)
            return False
        shutil.rmtree(self.part, ignore_errors=True)
        if isinstance(error, OSError):
            raise InputError(f"{self.out}: cannot be written: {error.strerror}") from None
        return False


    def write_manifest(self):
        """Of all files but images, which data.csv names."""
        names = sorted(str(f.relative_to(self.part)) for f in self.part.rglob("*") if f.is_file() and f.parent.name != "data")
        entries = [output_run.entry_of(fsspec.filesystem("file"), str(self.part), name) for name in names]
        (self.part / output_run.NAME).write_bytes(output_run.text_of([output_run.run_entry("import", entries)]))


def write_imu(folder, imu):
    """All digits: values read back to the same bits."""
    folder.mkdir(parents=True)
    with_temperature = imu.temperature is not None
    with (folder / "data.csv").open("w") as file:
        file.write(IMU_HEADER + (",temperature [degC]\n" if with_temperature else "\n"))
        columns = [imu.gyro, imu.accel] + ([imu.temperature[:, None]] if with_temperature else [])
        values = np.concatenate(columns, axis=1).tolist()
        for t_ns, row in zip(imu.t_ns.tolist(), values):
            file.write(f"{t_ns}," + ",".join(map(repr, row)) + "\n")


def write_noise(folder, rate_hz, noise, origin):
    lines = [f"# {origin}", "sensor_type: imu", f"rate_hz: {rate_hz:.10g}  # Hz"]
    lines += [f"{name}: {yaml_number(value)}  # {unit}" for name, value, unit in zip(NOISE_NAMES, noise, NOISE_UNITS)]
    (folder / "sensor.yaml").write_text("\n".join(lines) + "\n")


class CameraWriter:
    """Images of one camera, in stamp order; one whose stamp was there already is dropped."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "data").mkdir(parents=True)
        self.names = {}
        self.exposures = {}
        self.dropped = 0
        self.size = None

    def add(self, t_ns, image):
        if t_ns in self.names:
            self.dropped += 1
            return
        name = f"{t_ns}{image.suffix}"
        file = self.folder / "data" / name
        if image.encoded is not None:
            size = size_of(image.encoded, name)
            file.write_bytes(image.encoded)
        else:
            # Lossless; level 1 takes a tenth of the time of the default and makes files a tenth larger.
            Png.fromarray(np.ascontiguousarray(image.pixels)).save(file, compress_level=1)
            size = (image.pixels.shape[1], image.pixels.shape[0])
        if size != (self.size or size):
            raise InputError(f"expected images of one size, found {self.size[0]} x {self.size[1]} and, at {t_ns}, {size[0]} x {size[1]}")
        self.size = size
        self.names[t_ns] = name
        if image.exposure_ns > 0:
            self.exposures[t_ns] = image.exposure_ns

    def finish(self):
        rows = "".join(f"{t_ns},{self.names[t_ns]}\n" for t_ns in sorted(self.names))
        (self.folder / "data.csv").write_text("#timestamp [ns],filename\n" + rows)
        if self.exposures:
            rows = "".join(f"{t_ns},{self.exposures[t_ns]}\n" for t_ns in sorted(self.exposures))
            (self.folder / "exposure.csv").write_text("#timestamp [ns],exposure [ns]\n" + rows)


def camchain_text(cameras):
    """Kalibr's camchain-imucam.yaml of [(Camera, T_CI, timeshift in s, origin of T_CI)]."""
    text = ""
    for i, (camera, T_CI, timeshift_s, origin) in enumerate(cameras):
        text += f"cam{i}:\n  # p_cam = T_cam_imu p_imu, m; {origin}\n  T_cam_imu:\n"
        text += "".join(f"  - {yaml_list(row)}\n" for row in T_CI)
        text += f"  camera_model: pinhole\n  intrinsics: {yaml_list(camera.intrinsics)}  # fx fy cx cy, px\n"
        text += f"  distortion_model: {camera.distortion_model}\n  distortion_coeffs: {yaml_list(camera.distortion)}\n"
        text += "  readout: columns\n" if camera.readout == "columns" else ""  # of a rolling shutter
        text += f"  resolution: {[camera.width, camera.height]}\n  timeshift_cam_imu: {yaml_number(timeshift_s)}  # s, t_imu = t_cam + shift\n"
    return text


def imu_model_text(model, rate_hz, noise):
    """imu.yaml of T_g, T_a, R_AI: measurement = M C x + bias, x in I."""
    text = f"update_rate: {yaml_number(rate_hz)}  # Hz\n"
    text += "".join(f"{name}: {yaml_number(value)}  # {unit}\n" for name, value, unit in zip(NOISE_NAMES, noise, NOISE_UNITS))
    text += "model: scale-misalignment\n"
    for group, matrices in (("gyroscopes", (("M", model.T_g), ("C_gyro_i", np.eye(3)))), ("accelerometers", (("M", model.T_a), ("C_accel_i", model.R_AI)))):
        text += f"{group}:\n"
        for name, matrix in matrices:
            text += f"  {name}:\n" + "".join(f"    - {yaml_list(row)}\n" for row in matrix)
    return text
