"""Recordings of Project Aria's glasses (VRS), by the package vrs, which is an extra.

Stamps are capture_timestamp_ns, ns of the device's one clock; an image's is the middle of its exposure (projectaria-tools,
ImageSensorMetadata). --stamps log takes arrival_timestamp_ns. Values are rad/s and m/s^2 in the IMU's own axes as the sensor gave them: the
factory's matrices and delays go into the calibration, not into the samples. JPEG images stay the files that they are; Gen 2's H.265 is decoded by
the package av, in whose images SLAM cameras are bit for bit those of projectaria-tools; of colour in it the brightness plane is taken."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from aria_calibration import LABELS, Factory
from streams import Image, Imu, InputError, StreamInfo

from .pixels import from_buffer
from .vrs_records import begins_like_vrs, data_records

SLAM, RGB, IMU = "1201", "214", "1202"
ENCODING = {"grey8": "mono8", "grey16": "mono16", "rgb8": "rgb8", "bgr8": "bgr8"}
SECOND = {IMU: "the device's other IMU", RGB: "a colour camera with a rolling shutter", SLAM: "a camera to the side"}
FIRST = {f"{SLAM}-1", f"{SLAM}-2", f"{IMU}-1"}


def probe(paths):
    return Source(paths[0]) if len(paths) == 1 and paths[0].is_file() and begins_like_vrs(paths[0]) else None


@contextlib.contextmanager
def quiet():
    """The library writes its log to file descriptor 2, past Python."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def ends_by_signal(file):
    """True where the library does not survive a file: 2 of 100 damaged ones end it with SIGSEGV, and would leave half a recording behind."""
    command = [sys.executable, "-B", "-P", str(Path(__file__).with_name("vrs_rehearsal.py")), file]
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode < 0


class Source:
    def __init__(self, path):
        """Raises InputError where the file is damaged."""
        from pyvrs import SyncVRSReader

        self.path, self.where, self.notes = path, str(path), []
        self.counts = data_records(path)
        if ends_by_signal(self.where):
            raise InputError(f"{path}: damaged VRS file: what it says about its streams cannot be read")
        with self.damage(), quiet():
            self.reader = SyncVRSReader(self.where)
            tags = dict(self.reader.file_tags)
        self.factory = Factory(tags.get("calib_json", ""), self.where)
        labels = LABELS.get(self.factory.device or tags.get("device_type"), {})
        self.title = "Aria recording (VRS)" if labels else "VRS file"
        self.ids = {labels.get(stream, stream): stream for stream in sorted(self.counts)}  # name -> stream

    @contextlib.contextmanager
    def damage(self):
        try:
            yield
        except KeyError as error:
            raise InputError(f"{self.where}: expected a field {error} in its records, as Aria's have") from None
        except IndexError:
            raise InputError(f"{self.where}: damaged VRS file: a record without the fields or the image that its stream has") from None
        except (RuntimeError, ValueError) as error:
            raise InputError(f"{self.where}: damaged VRS file: {error or type(error).__name__}") from None

    def streams(self):
        out = []
        for name, stream in self.ids.items():
            kind = stream.split("-")[0]
            aside = SECOND.get(kind, "") if stream not in FIRST else ""
            out.append(StreamInfo(name, {SLAM: "camera", RGB: "camera", IMU: "imu"}.get(kind, "other"), self.counts[stream], f"stream {stream}", aside))
        return out

    def records(self, name, kind="data"):
        """Records of one stream in the order of their time. Raises InputError where the library finds fewer than the file holds."""
        stream = self.ids[name]
        with self.damage(), quiet():
            found = self.reader.filtered_by_fields(stream_ids={stream}, record_types={kind})
            if kind == "data" and len(found) != self.counts[stream]:
                raise ValueError(f"{len(found)} records of {name} in its index, {self.counts[stream]} in the file")
        for k in range(len(found)):
            with self.damage(), quiet():
                record = found[k]
                content = dict(record.metadata_blocks[0])
            yield record, content

    def imu(self, name):
        t_ns, log_ns, gyro, accel, degrees, valid = [], [], [], [], [], []
        for _, sample in self.records(name):
            with self.damage():
                t_ns.append(sample["capture_timestamp_ns"])
                log_ns.append(sample["arrival_timestamp_ns"])
                gyro.append(sample["gyroscope"])
                accel.append(sample["accelerometer"])
                degrees.append(sample["temperature_deg_c"])
                valid.append(sample["gyroscope_valid"] and sample["accelerometer_valid"])
        with self.damage():
            gyro, accel = (np.array(values, float).reshape(len(t_ns), 3) for values in (gyro, accel))
            temperature = np.array(degrees, float)
        imu = Imu(name, np.array(t_ns, np.int64), np.array(log_ns, np.int64), gyro, accel, temperature if np.isfinite(temperature).all() else None, "rad/s", "m/s^2")
        if not all(valid):
            self.notes.append(f"{name}: {valid.count(False)} samples that the device calls invalid left out")
            imu = imu.chosen(np.array(valid, bool))
        return imu

    def frames(self, name):
        decoder = None
        for number, (record, content) in enumerate(self.records(name)):
            with self.damage(), quiet():
                stamps = int(content["capture_timestamp_ns"]), int(content["arrival_timestamp_ns"])
                spec, block = str(record.image_specs[0]), np.asarray(record.image_blocks[0])
            if spec in ("jpg", "png"):
                yield Image(*stamps, None, block.tobytes(), f".{spec}")
            elif "codec=H.265" in spec:
                decoder = decoder or Video(self.where, name)
                yield from decoder.decoded(number, stamps, block.tobytes())
            else:
                yield Image(*stamps, self.raw(name, spec, block))
        if decoder:
            yield from decoder.finished()

    def raw(self, name, spec, block):
        encoding = ENCODING.get(next((part[6:] for part in spec.split("/") if part.startswith("pixel=")), ""))
        if encoding is None or block.ndim < 2:
            raise InputError(f"{self.where}: {name}: images in '{spec}'; known: jpg, png, H.265, raw {', '.join(sorted(ENCODING))}")
        block = np.ascontiguousarray(block)
        return from_buffer(block.view(np.uint8).ravel(), block.shape[1], block.shape[0], block.strides[0], encoding, False)

    def calib(self, name):
        for _, content in self.records(name, "configuration"):
            with self.damage():
                size = int(content["image_width"]), int(content["image_height"])
            return self.factory.camera(name, *size)
        return None

    def extrinsics(self, camera, imu):
        return self.factory.extrinsics(camera, imu)

    def timeshift(self, camera, imu):
        return self.factory.timeshift(camera, imu)

    def imu_model(self, imu):
        return self.factory.imu(imu)


class Video:
    """One stream of H.265: records are pictures, each in its turn, and the decoder may hand them out later."""

    def __init__(self, where, name):
        import av

        self.av, self.where, self.name = av, where, name
        self.codec = av.CodecContext.create("hevc", "r")
        self.stamps = {}

    def decoded(self, number, stamps, data):
        packet = self.av.Packet(data)
        packet.pts = number
        self.stamps[number] = stamps
        yield from self.images(packet)

    def finished(self):
        yield from self.images(None)
        if self.stamps:
            raise InputError(f"{self.where}: {self.name}: {len(self.stamps)} images that cannot be decoded")

    def images(self, packet):
        try:
            frames = self.codec.decode(packet)
        except self.av.FFmpegError as error:
            raise InputError(f"{self.where}: {self.name}: an image that cannot be decoded: {error}") from None
        for frame in frames:
            plane = frame.planes[0]
            rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
            yield Image(*self.stamps.pop(frame.pts), rows[: frame.height, : frame.width].copy())
