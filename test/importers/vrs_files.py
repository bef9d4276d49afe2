"""Writes VRS files as Aria's glasses do: the package vrs on PyPI writes only streams that are compiled into it.

By the format's public description: a file header, a description record with the tags of the streams and of the file, records, an index; all
little-endian. What a record holds stands in its stream's tags (RF: blocks, DL: fields of a data layout). Each field's name, type and order is
that of a Gen 1 recording. Configuration records are compressed, as Aria's are."""

import json
import struct

import numpy as np
import zstandard

HEADER = struct.Struct("<8sQIIqqqQQQ4s4s")
RECORD = struct.Struct("<IIiIdHBBI")
INDEX, DESCRIPTION = 1, 2  # types of the two streams that the format keeps for itself
CONFIGURATION, DATA = 2, 3
ZSTD = 2
CODES = {"uint32_t": "I", "uint64_t": "Q", "int64_t": "q", "double": "d", "Bool": "?"}
VERSION = 2  # of Aria's data layouts
IMU_CONFIGURATION = {"stream_index": "uint32_t", "device_id": "uint64_t", "nominal_rate": "double", "has_accelerometer": "Bool", "has_gyroscope": "Bool",
                     "has_magnetometer": "Bool", "device_type": str, "sensor_model": str, "factory_calibration": str}
IMU_DATA = {"accelerometer_valid": "Bool", "gyroscope_valid": "Bool", "magnetometer_valid": "Bool", "temperature_deg_c": "double",
            "capture_timestamp_ns": "int64_t", "arrival_timestamp_ns": "int64_t", "accelerometer": np.float32, "gyroscope": np.float32,
            "magnetometer": np.float32}
IMAGE_CONFIGURATION = {"camera_id": "uint32_t", "nominal_rate": "double", "image_width": "uint32_t", "image_height": "uint32_t", "image_stride": "uint32_t",
                       "image_pixel_format": "uint32_t", "device_type": str, "sensor_model": str, "factory_calibration": str}
IMAGE_DATA = {"group_id": "uint64_t", "frame_number": "uint64_t", "exposure_duration_s": "double", "gain": "double", "capture_timestamp_ns": "int64_t",
              "arrival_timestamp_ns": "int64_t", "temperature_deg_c": "double"}
GREY8 = 1


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def table(entries):
    return struct.pack("<I", len(entries)) + b"".join(text(k) + text(v) for k, v in entries.items())


def layout_json(fields):
    pieces, offset, strings = [], 0, 0
    for name, kind in fields.items():
        if kind is str:
            pieces.append({"name": name, "type": "DataPieceString", "index": strings})
            strings += 1
        elif kind is np.float32:
            pieces.append({"name": name, "type": "DataPieceArray<float>", "offset": offset, "size": 3})
            offset += 12
        else:
            pieces.append({"name": name, "type": f"DataPieceValue<{kind}>", "offset": offset})
            offset += struct.calcsize("<" + CODES[kind])
    return json.dumps({"data_layout": pieces}), offset


def packed(fields, values):
    """Values of fixed size, then place and length of each text, then the texts."""
    fixed = index = texts = b""
    for name, kind in fields.items():
        if kind is str:
            data = values.get(name, "").encode()
            index += struct.pack("<II", len(texts), len(data))
            texts += data
        elif kind is np.float32:
            fixed += np.asarray(values.get(name, (0, 0, 0)), "<f4").tobytes()
        else:
            fixed += struct.pack("<" + CODES[kind], values.get(name, 0))
    return fixed + index + texts


class VrsFile:
    """Collects records; `write` puts them into a file in the order of their times."""

    def __init__(self, calibration=None, tags=None):
        self.calibration = json.dumps(calibration) if calibration else ""
        self.tags = ({"calib_json": self.calibration} if calibration else {}) | (tags or {"device_type": "Aria"})
        self.streams, self.records = {}, []

    def stream(self, name, configuration, data, values, image=None):
        """`name` as "1202-1"; `image` is the block after the layout: "raw", "jpg" or None."""
        kind, instance = map(int, name.split("-"))
        (configuration_json, _), (data_json, size) = layout_json(configuration), layout_json(data)
        self.streams[kind, instance] = {
            f"DL:Configuration:{VERSION}:0": configuration_json, f"DL:Data:{VERSION}:0": data_json, f"RF:Configuration:{VERSION}": "data_layout",
            f"RF:Data:{VERSION}": f"data_layout/size={size}" + (f"+image/{image}" if image else ""), "VRS_Original_Recordable_Name": "test"}
        content = zstandard.compress(packed(configuration, values))
        self.records.append((0.0, kind, instance, CONFIGURATION, ZSTD, len(packed(configuration, values)), content))

    def add(self, name, t_ns, content):
        kind, instance = map(int, name.split("-"))
        self.records.append((t_ns * 1e-9, kind, instance, DATA, 0, 0, content))

    def imu(self, name, stamps, gyro, accel, valid=None, late_ns=5_000_000, logged_ns=None, fields=IMU_DATA):
        self.stream(name, IMU_CONFIGURATION, fields, {"nominal_rate": 1000.0, "has_accelerometer": True, "has_gyroscope": True, "device_type": "Aria",
                                                      "factory_calibration": self.calibration})
        for k, (t, w, a) in enumerate(zip(stamps.tolist(), gyro, accel)):
            good = valid is None or bool(valid[k])
            self.add(name, t, packed(fields, {"accelerometer_valid": good, "gyroscope_valid": good, "temperature_deg_c": float("nan"), "capture_timestamp_ns": t,
                                              "arrival_timestamp_ns": t + late_ns if logged_ns is None else logged_ns, "accelerometer": a, "gyroscope": w}))

    def camera(self, name, stamps, images, size, kind="raw"):
        """Grey images (h x w, 8 bit) for "raw", else the bytes of a file each."""
        self.stream(name, IMAGE_CONFIGURATION, IMAGE_DATA, {"nominal_rate": 30.0, "image_width": size[0], "image_height": size[1], "image_stride": size[0],
                                                            "image_pixel_format": GREY8, "device_type": "Aria"}, kind)
        for k, (t, image) in enumerate(zip(stamps, images)):
            values = {"frame_number": k, "exposure_duration_s": 0.005, "gain": 1.0, "capture_timestamp_ns": int(t), "arrival_timestamp_ns": int(t) + 9_000_000}
            self.add(name, int(t), packed(IMAGE_DATA, values) + (image if isinstance(image, bytes) else image.tobytes()))

    def write(self, path):
        streams = b"".join(struct.pack("<iH", *key) + table({}) + table(tags) for key, tags in self.streams.items())
        parts = [(DESCRIPTION, 0, DATA, 0, 0, 0.0, struct.pack("<I", len(self.streams)) + streams + table(self.tags))]
        ordered = sorted(self.records, key=lambda r: r[:3])
        parts += [(kind, instance, what, how, unpacked, t, content) for t, kind, instance, what, how, unpacked, content in ordered]
        index = struct.pack("<I", len(self.streams)) + b"".join(struct.pack("<iH", *key) for key in self.streams) + struct.pack("<I", len(ordered))
        index += b"".join(struct.pack("<dIBiH", t, RECORD.size + len(content), what, kind, instance) for t, kind, instance, what, _, _, content in ordered)
        parts.append((INDEX, 0, DATA, 0, 0, 0.0, index))
        out, before = bytearray(), 0
        for kind, instance, what, how, unpacked, t, content in parts:
            size = RECORD.size + len(content)
            version = 2 if kind in (INDEX, DESCRIPTION) else VERSION
            out += RECORD.pack(size, before, kind, version, t, instance, what, how, unpacked) + content
            before = size
        header = HEADER.pack(b"VisionRe", 1, HEADER.size, RECORD.size, HEADER.size + len(out) - before, HEADER.size, 0, 0, 0, 0, b"cord", b"VRS1")
        path.write_bytes(header + out)


def factory(size, cameras, imus):
    """calib_json: `cameras` {label: (params of FisheyeRadTanThinPrism, T_Device_Camera)}, `imus` {label: (M_gyro, M_accel, T_Device_Imu, late gyro s,
    late accel s)}; poses are (quaternion wxyz, translation in m)."""
    def pose(q, p):
        return {"UnitQuaternion": [q[0], list(q[1:])], "Translation": list(p)}

    def triad(M, late, short):
        return {"Bias": {"Name": "Constant", "Offset": [0.01, 0.02, 0.03]}, "Model": {"Name": "Linear", "RectificationMatrix": np.asarray(M).tolist()},
                f"TimeOffsetSec_Device_{short}": late}

    return {"DeviceClassInfo": {"BuildVersion": "DVT-S", "DeviceClass": "Aria"}, "OriginSpecification": {"ChildLabel": "camera-slam-left", "Type": "Custom"},
            "CameraCalibrations": [{"Calibrated": True, "Label": label, "SerialNumber": "", "T_Device_Camera": pose(*T),
                                    "Projection": {"Name": "FisheyeRadTanThinPrism", "Params": list(params)},
                                    "ConfigData": {"ImageWidth": size[0], "ImageHeight": size[1], "MaxSolidAngle": 1.4, "ValidRadius": 0.5 * float(np.hypot(*size))}}
                                   for label, (params, T) in cameras.items()],
            "ImuCalibrations": [{"Calibrated": True, "Label": label, "SerialNumber": "", "T_Device_Imu": pose(*T), "Gyroscope": triad(M_g, late_g, "Gyro"),
                                 "Accelerometer": triad(M_a, late_a, "Accel")} for label, (M_g, M_a, T, late_g, late_a) in imus.items()]}
