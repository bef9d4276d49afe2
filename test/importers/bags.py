"""Bags of all kinds, made by the library rosbags."""

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

KINDS = ("ros1", "sqlite3", "mcap")


class Bag:
    """`with Bag(folder, kind) as bag:` and then imu(), image(), ..., each at its stamp; logged 3 ms later."""

    def __init__(self, folder, kind, name="run"):
        self.kind = kind
        self.path = folder / (f"{name}.bag" if kind == "ros1" else f"{name}_{kind}")
        self.store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
        self.connections = {}

    def __enter__(self):
        plugin = {"sqlite3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}.get(self.kind)
        self.writer = Writer1(self.path) if plugin is None else Writer2(self.path, version=9, storage_plugin=plugin)
        self.writer.open()
        return self

    def __exit__(self, *_):
        self.writer.close()

    @property
    def storage(self):
        """The one file with the messages."""
        return self.path if self.kind == "ros1" else next(f for f in self.path.iterdir() if f.suffix in (".db3", ".mcap"))

    def make(self, name, **members):
        return self.store.types[name](**members)

    def header(self, t_ns, frame):
        stamp = self.make("builtin_interfaces/msg/Time", sec=t_ns // 10**9, nanosec=t_ns % 10**9)
        more = {"seq": 0} if self.kind == "ros1" else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **more)

    def vector(self, values):
        return self.make("geometry_msgs/msg/Vector3", **dict(zip("xyz", map(float, values))))

    def quaternion(self, wxyz=(1, 0, 0, 0)):
        return self.make("geometry_msgs/msg/Quaternion", **dict(zip("wxyz", map(float, wxyz))))

    def write(self, topic, message, log_ns):
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        raw = self.store.serialize_ros1(message, kind) if self.kind == "ros1" else self.store.serialize_cdr(message, kind)
        self.writer.write(self.connections[topic], log_ns, raw)

    def imu(self, topic, t_ns, gyro, accel, stamp_ns=None):
        none = np.zeros(9)
        message = self.make("sensor_msgs/msg/Imu", header=self.header(t_ns if stamp_ns is None else stamp_ns, "imu"),
                            orientation=self.quaternion(), orientation_covariance=none,
                            angular_velocity=self.vector(gyro), angular_velocity_covariance=none,
                            linear_acceleration=self.vector(accel), linear_acceleration_covariance=none)
        self.write(topic, message, t_ns + 3_000_000)

    def image(self, topic, t_ns, pixels, encoding, stamp_ns=None):
        raw = np.ascontiguousarray(pixels)
        message = self.make("sensor_msgs/msg/Image", header=self.header(t_ns if stamp_ns is None else stamp_ns, "camera"),
                            height=raw.shape[0], width=raw.shape[1], encoding=encoding, is_bigendian=0,
                            step=raw.strides[0], data=raw.view(np.uint8).ravel())
        self.write(topic, message, t_ns + 3_000_000)

    def compressed(self, topic, t_ns, data, text):
        message = self.make("sensor_msgs/msg/CompressedImage", header=self.header(t_ns, "camera"), format=text,
                            data=np.frombuffer(data, np.uint8))
        self.write(topic, message, t_ns + 3_000_000)

    def camera_info(self, topic, t_ns, size, K, D, model):
        names = "DKRP" if self.kind == "ros1" else "dkrp"
        matrices = dict(zip(names, (np.array(D, float), np.array(K, float), np.eye(3).ravel(), np.zeros(12))))
        region = self.make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        message = self.make("sensor_msgs/msg/CameraInfo", header=self.header(t_ns, "camera"), width=size[0], height=size[1],
                            distortion_model=model, binning_x=0, binning_y=0, roi=region, **matrices)
        self.write(topic, message, t_ns)

    def fixed_transform(self, t_ns, parent, child, wxyz, p):
        transform = self.make("geometry_msgs/msg/Transform", translation=self.vector(p), rotation=self.quaternion(wxyz))
        stamped = self.make("geometry_msgs/msg/TransformStamped", header=self.header(t_ns, parent), child_frame_id=child, transform=transform)
        self.write("/tf_static", self.make("tf2_msgs/msg/TFMessage", transforms=[stamped]), t_ns)
