"""EuRoC's and TUM-VI's folders. The other commands read them as they are; importing one checks it, keeps image files as they
are, and turns TUM-VI's dso/camchain.yaml or EuRoC's sensor.yaml into camchain-imucam.yaml."""

import numpy as np

from recording import NOISE_NAMES
from calibration_folder import COEFFICIENTS, OTHER_NAMES
from streams import Camera, Image, Imu, InputError, StreamInfo
from yaml_file import read_yaml

from . import tables

IMU_COLUMNS = 7


def probe(paths):
    if len(paths) != 1 or not paths[0].is_dir():
        return None
    root = next((r for r in (paths[0], paths[0].parent) if (r / "mav0/imu0/data.csv").is_file()), None)
    return Source(paths[0]) if root == paths[0] else None


def rows(file, columns):
    return list(tables.rows_of(file, tables.Layout(0, 0, "ns", {}, None, columns)))


class Source:
    title = "EuRoC or TUM-VI folder"

    def __init__(self, root):
        self.root, self.where = root, str(root)
        self.mav0 = root / "mav0"
        self.imu_file = self.mav0 / "imu0/data.csv"

    def columns(self):
        lines = [line for line in self.imu_file.read_text(errors="replace").splitlines() if line.strip() and not line.startswith("#")]
        return len(tables.split(lines[0])) if lines else IMU_COLUMNS

    def streams(self):
        out = [StreamInfo("imu0", "imu", len(rows(self.imu_file, self.columns())))]
        for file in sorted(self.mav0.glob("cam*/data.csv")):
            out.append(StreamInfo(file.parent.name, "camera", len(rows(file, 2))))
        return out

    def imu(self, name):
        lines = rows(self.imu_file, self.columns())
        try:
            t_ns = np.array([int(fields[0]) for _, fields in lines], np.int64)
            values = np.array([[float(x) for x in fields[1:]] for _, fields in lines]).reshape(len(lines), -1)
        except ValueError:
            raise InputError(f"{self.imu_file}: expected a stamp in ns and numbers in each row") from None
        if values.shape[1] < IMU_COLUMNS - 1:
            raise InputError(f"{self.imu_file}: expected stamp, w_x, w_y, w_z, a_x, a_y, a_z, found {values.shape[1] + 1} columns")
        temperature = values[:, 6] if values.shape[1] == IMU_COLUMNS else None
        return Imu(name, t_ns, t_ns, values[:, :3], values[:, 3:6], temperature, "rad/s", "m/s^2")

    def exposures(self, name):
        """{stamp: ns}; empty without exposure.csv, which TUM-VI's folders have."""
        file = self.mav0 / name / "exposure.csv"
        if not file.is_file():
            return {}
        return {stamp: tables.exposure_of(text, "ns", f"{file}:{number}") for number, (stamp, text) in rows(file, 2)}

    def frames(self, name):
        file = self.mav0 / name / "data.csv"
        exposures = self.exposures(name)
        for number, (stamp, image) in rows(file, 2):
            path = file.parent / "data" / image
            if not path.is_file():
                raise InputError(f"{file}:{number}: expected an image that exists, found {image}")
            yield Image(int(stamp), int(stamp), None, path.read_bytes(), path.suffix.lower(), exposures.get(stamp, 0))

    def chain(self, name):
        """The entry of a camera in Kalibr's layout, if the folder has one."""
        for file in (self.root / "camchain-imucam.yaml", self.root / "dso/camchain.yaml"):
            if file.is_file():
                return read_yaml(file).get(name), file
        return None, None

    def calib(self, name):
        entry, file = self.chain(name)
        if entry is None:
            file = self.mav0 / name / "sensor.yaml"
            entry = read_yaml(file) if file.is_file() else None
        if entry is None:
            return None
        model = OTHER_NAMES.get(entry.get("distortion_model"), entry.get("distortion_model"))
        if model not in COEFFICIENTS:
            raise InputError(f"{file}: expected a distortion_model of {', '.join(COEFFICIENTS)}")
        if entry.get("readout", "rows") not in ("rows", "columns"):
            raise InputError(f"{file}: expected readout rows or columns")
        distortion = entry.get("distortion_coeffs", entry.get("distortion_coefficients"))
        return Camera(*entry["resolution"], entry["intrinsics"], model, distortion[:1] if model == "fov" else distortion, readout=entry.get("readout", "rows"))

    def extrinsics(self, camera, imu):
        """T_cam_imu, or the inverse of EuRoC's T_BS, with the IMU's own T_BS."""
        entry, _ = self.chain(camera)
        if entry is not None:
            return np.array(entry["T_cam_imu"]) if "T_cam_imu" in entry else None
        poses = [self.body_pose(self.mav0 / part / "sensor.yaml") for part in (camera, imu)]
        return None if poses[0] is None else np.linalg.inv(poses[0]) @ (np.eye(4) if poses[1] is None else poses[1])

    def body_pose(self, file):
        if not file.is_file() or "T_BS" not in (content := read_yaml(file)):
            return None
        values = content["T_BS"]["data"] if isinstance(content["T_BS"], dict) else content["T_BS"]
        return np.array(values, float).reshape(4, 4)

    def noise(self):
        """(four figures, origin) or None."""
        for file in (self.mav0 / "imu0/sensor.yaml", self.root / "imu.yaml", self.root / "dso/imu_config.yaml"):
            if file.is_file():
                content = read_yaml(file)
                if all(name in content for name in NOISE_NAMES):
                    return tuple(float(content[name]) for name in NOISE_NAMES), f"of {file.name}"
        return None
