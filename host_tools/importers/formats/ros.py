"""ROS 1 bags, ROS 2 bags (folder with metadata.yaml, SQLite or MCAP), and single .mcap and .db3 files, by the package rosbags."""

import numpy as np

from camera_models import from_camera_info
from streams import Image, Imu, InputError, StreamInfo

from .pixels import from_buffer

KINDS = {
    "sensor_msgs/msg/Imu": "imu",
    "sensor_msgs/msg/Image": "camera",
    "sensor_msgs/msg/CompressedImage": "camera",
}
MAGIC = {b"#ROSBAG V2.0": "ROS 1 bag", b"\x89MCAP0\r\n": "MCAP file", b"SQLite format 3\0": "ROS 2 bag (SQLite)"}
SUFFIX_OF = {"jpeg": ".jpg", "jpg": ".jpg", "png": ".png", "webp": ".webp", "tiff": ".tif", "bmp": ".bmp"}


def probe(paths):
    """A Source if the one path is a bag, or all of them are ROS 1 bags (a bag that was split)."""
    titles = [title_of(path) for path in paths]
    if not titles or None in titles or (len(paths) > 1 and set(titles) != {"ROS 1 bag"}):
        return None
    return Source(paths, titles[0])


def title_of(path):
    if path.is_dir():
        return "ROS 2 bag" if (path / "metadata.yaml").exists() else None
    with path.open("rb") as file:
        head = file.read(16)
    return next((title for magic, title in MAGIC.items() if head.startswith(magic)), None)


def nanoseconds(stamp):
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def xyz(vector):
    return (vector.x, vector.y, vector.z)


def check_sqlite_size(path):
    """A database that was cut reads well as far as it goes; its header says how long it is (SQLite file format, section 1.3)."""
    files = ([path] if path.suffix == ".db3" else []) if path.is_file() else sorted(path.glob("*.db3"))
    for file in files:
        with file.open("rb") as stream:
            head = stream.read(32)
        page = int.from_bytes(head[16:18], "big")
        size = (65536 if page == 1 else page) * int.from_bytes(head[28:32], "big")
        if file.stat().st_size < size:
            raise InputError(f"{file}: damaged ROS 2 bag: {file.stat().st_size} bytes where its header says {size}")


class Source:
    def __init__(self, paths, title):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

        self.paths, self.title = paths, title
        self.where = str(paths[0])
        with self.damage():
            readable = [path if path.is_dir() or path.suffix in (".bag", ".mcap", ".db3") else self.refuse_suffix(path) for path in paths]
            for path in paths:
                check_sqlite_size(path)
            # Messages of sensors have the same layout in all ROS 2 releases; the store serves bags without definitions.
            self.reader = AnyReader(readable, default_typestore=get_typestore(Stores.ROS2_HUMBLE))
            self.reader.open()
        self.cameras_by_folder = {}

    def refuse_suffix(self, path):
        raise InputError(f"{path}: expected a name that ends with .bag, .mcap or .db3 ({self.title})")

    def damage(self):
        """What the library throws on a damaged file is told in one line."""
        return Damage(self.where, self.title)

    def connections(self, *types):
        return [c for c in self.reader.connections if c.msgtype in types]

    def streams(self):
        counts, types = {}, {}
        for connection in self.reader.connections:
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
            types[connection.topic] = connection.msgtype
        seconds = self.reader.duration * 1e-9
        return [StreamInfo(topic, KINDS.get(types[topic], "other"), count, types[topic] + (f", {count / seconds:.1f} Hz" if count > 1 and seconds > 0 else ""))
                for topic, count in sorted(counts.items())]

    def messages(self, topic, *types):
        chosen = [c for c in self.connections(*(types or KINDS)) if topic is None or c.topic == topic]
        if not chosen:
            return
        with self.damage():
            for connection, log_ns, raw in self.reader.messages(connections=chosen):
                yield connection, log_ns, self.reader.deserialize(raw, connection.msgtype)

    def imu(self, name):
        stamps, logged, gyro, accel = [], [], [], []
        lacks_gyro = lacks_accel = False
        for _, log_ns, message in self.messages(name):
            stamps.append(nanoseconds(message.header.stamp))
            logged.append(log_ns)
            gyro.append(xyz(message.angular_velocity))
            accel.append(xyz(message.linear_acceleration))
            # sensor_msgs/Imu: -1 in the first place of a covariance means that there is no such measurement.
            lacks_gyro = lacks_gyro or message.angular_velocity_covariance[0] == -1
            lacks_accel = lacks_accel or message.linear_acceleration_covariance[0] == -1
        gyro, accel = np.array(gyro, float).reshape(-1, 3), np.array(accel, float).reshape(-1, 3)
        return Imu(name, np.array(stamps, np.int64), np.array(logged, np.int64),
                   None if lacks_gyro or not gyro.any() else gyro, None if lacks_accel or not accel.any() else accel,
                   None, "rad/s", "m/s^2")  # REP 103, and the message's own definition

    def frames(self, name):
        for connection, log_ns, message in self.messages(name):
            t_ns = nanoseconds(message.header.stamp)
            if connection.msgtype.endswith("CompressedImage"):
                yield Image(t_ns, log_ns, None, bytes(message.data), suffix_of(message.format, self.where, name))
                continue
            try:
                pixels = from_buffer(message.data, message.width, message.height, message.step, message.encoding,
                                     bool(message.is_bigendian))
            except InputError as error:
                raise InputError(f"{self.where}: {name}: {error}") from None
            yield Image(t_ns, log_ns, pixels)

    def calib(self, name):
        """camera_info lies beside the images: /cam0/image_raw and /cam0/camera_info."""
        base = name.rsplit("/compressed", 1)[0].rsplit("/", 1)[0]
        for _, _, message in self.messages(f"{base}/camera_info", "sensor_msgs/msg/CameraInfo"):
            return from_camera_info(message, f"{self.where}: {base}/camera_info")
        return None

    def frame_id(self, name):
        for _, _, message in self.messages(name):
            return message.header.frame_id.lstrip("/")
        return ""

    def extrinsics(self, camera, imu):
        """By the fixed transforms of /tf_static, from the IMU's frame to the camera's."""
        from transforms import TransformTree

        tree = TransformTree()
        for _, _, message in self.messages("/tf_static", "tf2_msgs/msg/TFMessage"):
            for transform in message.transforms:
                q = transform.transform.rotation
                tree.add(transform.header.frame_id, transform.child_frame_id, (q.w, q.x, q.y, q.z), xyz(transform.transform.translation))
        return tree.between(self.frame_id(camera), self.frame_id(imu))


def suffix_of(text, where, name):
    """The format field: "jpeg", "png", or "bgr8; jpeg compressed bgr8"."""
    words = text.lower().replace(";", " ").split()
    for word in words:
        if word in SUFFIX_OF:
            return SUFFIX_OF[word]
    raise InputError(f"{where}: {name}: images in '{text}'; known: {', '.join(sorted(SUFFIX_OF))}. Video in a bag needs decoding first")


class Damage:
    def __init__(self, where, title):
        self.where, self.title = where, title

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if error is None or not isinstance(error, Exception) or isinstance(error, (InputError, ImportError)):
            return False
        words = " ".join(str(error).split()) or kind.__name__
        raise InputError(f"{self.where}: damaged {self.title}, or one that cannot be read: {words}") from None
