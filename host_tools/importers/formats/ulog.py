"""PX4's flight logs (ULog, docs.px4.io "ULog File Format"), by the package pyulog. They hold no images: for `segcal allan`, or
together with images that are stamped by the same clock."""

import contextlib
import io
import struct

import numpy as np

from streams import Imu, InputError, StreamInfo

MAGIC = b"ULog\x01\x12\x35"
HEADER_BYTES = 16
MESSAGES = b"FBIMPQARDLCSO"
TOPICS = {"sensor_combined": "imu", "sensor_gyro": "gyro", "sensor_accel": "accel"}


def probe(paths):
    if len(paths) != 1 or not paths[0].is_file():
        return None
    with paths[0].open("rb") as file:
        return Source(paths[0]) if file.read(len(MAGIC)) == MAGIC else None


def left_at_the_end(path):
    """Bytes of a last message that is not whole: the log was cut off when the vehicle lost its power. The format has no
    checksums; a type of message that it does not know is what damage looks like, and is refused."""
    data = path.read_bytes()
    at = HEADER_BYTES
    while at + 3 <= len(data):
        size, kind = struct.unpack_from("<HB", data, at)
        if kind not in MESSAGES:
            raise InputError(f"{path}: damaged PX4 log: byte {at}: expected a message, found one of type {kind}")
        at += 3 + size
    return len(data) - at if at < len(data) else int(at > len(data))


class Source:
    title = "PX4 log (ULog)"

    def __init__(self, path):
        from pyulog import ULog

        self.where = str(path)
        self.notes = []
        left = left_at_the_end(path)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                log = ULog(self.where, list(TOPICS))
        except Exception as error:  # whatever its parser stumbles over
            raise InputError(f"{path}: damaged PX4 log: {error or type(error).__name__}") from None
        if log.file_corruption:
            raise InputError(f"{path}: damaged PX4 log: what follows in it cannot be trusted")
        if left:
            self.notes.append(f"{path.name}: the log ends within a message, which is left out")
        if log.dropouts:
            lost_s = sum(d.duration for d in log.dropouts) * 1e-3
            self.notes.append(f"{path.name}: {len(log.dropouts)} dropouts, {lost_s:.2f} s in all, while the card was slow")
        self.topics = {f"{d.name}.{d.multi_id}": d for d in log.data_list if d.name in TOPICS and len(d.data["timestamp"])}

    def streams(self):
        out = []
        for name, topic in sorted(self.topics.items()):
            t = topic.data["timestamp"]
            seconds = float(t[-1] - t[0]) * 1e-6
            out.append(StreamInfo(name, TOPICS[topic.name], len(t), f"{(len(t) - 1) / seconds:.1f} Hz" if seconds > 0 else ""))
        return out

    def imu(self, name):
        topic = self.topics[name]
        data = topic.data
        logged = data["timestamp"].astype(np.int64) * 1000
        sampled = data.get("timestamp_sample", data["timestamp"]).astype(np.int64) * 1000
        if not np.any(sampled):
            sampled = logged
        if topic.name == "sensor_combined":
            # PX4's accelerometer_timestamp_relative is below one period; the two are given as one sample.
            return Imu(name, logged, logged, columns(data, "gyro_rad[{}]"), columns(data, "accelerometer_m_s2[{}]"), None, "rad/s", "m/s^2")
        values = columns(data, "{}")
        gyro = topic.name == "sensor_gyro"
        return Imu(name, sampled, logged, values if gyro else None, None if gyro else values, None, "rad/s", "m/s^2")

    def frames(self, name):
        return iter(())

    def calib(self, name):
        return None

    def extrinsics(self, camera, imu):
        return None


def columns(data, pattern):
    names = [pattern.format(axis) for axis in ("012" if "[" in pattern else "xyz")]
    return np.stack([data[name].astype(float) for name in names], axis=1)
