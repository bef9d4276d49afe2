"""A session as MCAP with Foxglove's messages: calibration, path, map, the recording's images, corner tracks and IMU, and the verdict as
log messages, for Foxglove and Lichtblick.

Topics: /tf (world to imu, imu to each camera), /path, /map, /camN/{calibration,image,tracks}, /imu (JSON), /log."""

import json

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

import session_files
from basalt import quaternion
from lenses import without_fov

VECTOR = {"type": "object", "properties": {axis: {"type": "number"} for axis in "xyz"}}
IMU = {"title": "segcal.Imu", "type": "object", "properties": {"gyro_rad_per_s": VECTOR, "accel_m_per_s2": VECTOR}}
MODELS = {"radtan": "plumb_bob", "equidistant": "kannala_brandt"}  # as Foxglove names them


def stamped(message, t_ns):
    message.timestamp.FromNanoseconds(t_ns)
    return message


def set_pose(position, rotation, p, q_xyzw):
    position.x, position.y, position.z = p
    rotation.x, rotation.y, rotation.z, rotation.w = q_xyzw


def transform(t_ns, parent, child, p, q_xyzw):
    message = stamped(FrameTransform(parent_frame_id=parent, child_frame_id=child), t_ns)
    set_pose(message.translation, message.rotation, p, q_xyzw)
    return t_ns, "/tf", message


def of_path(poses):
    for t, p, q in poses:
        yield transform(t, "world", "imu", p, q)
    message = stamped(PosesInFrame(frame_id="world"), poses[0][0])
    for _, p, q in poses:
        pose = message.poses.add()
        set_pose(pose.position, pose.orientation, p, q)
    yield poses[0][0], "/path", message


def of_cameras(calibration, start):
    for i, (camera, (model, distortion, (fx, fy, cx, cy))) in enumerate(zip(calibration.cameras, without_fov(calibration.cameras)[0])):
        T_IC = np.linalg.inv(camera.T_CI)
        yield transform(start, "imu", f"cam{i}", T_IC[:3, 3].tolist(), quaternion(T_IC[:3, :3]))
        message = CameraCalibration(frame_id=f"cam{i}", width=camera.size[0], height=camera.size[1], distortion_model=MODELS[model],
                                    D=[*distortion, 0.0] if model == "radtan" else distortion, K=[fx, 0, cx, 0, fy, cy, 0, 0, 1],
                                    R=np.eye(3).ravel().tolist(), P=[fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0])
        yield start, f"/cam{i}/calibration", stamped(message, start)


def of_map(file):
    for t, points in session_files.landmarks(file):
        message = stamped(PointCloud(frame_id="world", point_stride=12, data=points.astype("<f4").tobytes()), t)
        set_pose(message.pose.position, message.pose.orientation, (0, 0, 0), (0, 0, 0, 1))
        for axis, offset in zip("xyz", (0, 4, 8)):
            message.fields.add(name=axis, offset=offset, type=PackedElementField.FLOAT32)
        yield t, "/map", message


def of_log(folder, t):
    levels = {"calibrated": Log.INFO, "insufficient": Log.WARNING}
    status, sentences = session_files.sentences(folder)
    for sentence in sentences:
        yield t, "/log", stamped(Log(level=levels.get(status, Log.ERROR), message=sentence, name="segcal"), t)


def of_images(folder, camera):
    for t, file in session_files.images(folder):
        yield t, f"/cam{camera}/image", stamped(CompressedImage(frame_id=f"cam{camera}", data=file.read_bytes(), format=file.suffix[1:].lower()), t)


def of_tracks(folder, camera):
    for t, points in session_files.tracks(folder):
        message = ImageAnnotations()
        marks = stamped(message.points.add(type=PointsAnnotation.POINTS, thickness=4), t)
        marks.outline_color.g = marks.outline_color.a = 1.0
        for u, v in points:
            marks.points.add(x=u, y=v)
        yield t, f"/cam{camera}/tracks", message


def of_imu(recording):
    for t, w, a in session_files.imu(recording):
        yield t, "/imu", {"gyro_rad_per_s": dict(zip("xyz", w)), "accel_m_per_s2": dict(zip("xyz", a))}


def of_recording(recording, cameras, images):
    for i in range(cameras):
        folder = recording / "mav0" / f"cam{i}"
        if images:
            yield from of_images(folder, i)
        yield from of_tracks(folder, i)
    yield from of_imu(recording)


def messages(folder, calibration, recording, images):
    poses = session_files.trajectory(folder / "trajectory.tum")
    yield from of_cameras(calibration, poses[0][0])
    yield from of_path(poses)
    yield from of_map(folder / "kept_segments.json")
    yield from of_log(folder, poses[-1][0])
    if recording:
        yield from of_recording(recording, len(calibration.cameras), images)


class Session:
    """A file with one channel per topic."""

    def __init__(self, stream):
        self.writer, self.channels = Writer(stream), {}

    def channel(self, topic, message):
        if isinstance(message, dict):
            schema = self.writer.register_schema(IMU["title"], "jsonschema", json.dumps(IMU).encode())
            return self.writer.register_channel(topic, "json", schema)
        return self.writer.register_channel(topic, "protobuf", register_schema(self.writer, type(message)))

    def add(self, t_ns, topic, message):
        if topic not in self.channels:
            self.channels[topic] = self.channel(topic, message)
        data = json.dumps(message).encode() if isinstance(message, dict) else message.SerializeToString()
        self.writer.add_message(self.channels[topic], log_time=t_ns, publish_time=t_ns, data=data)


def write(file, folder, calibration, recording, images):
    """In the order of the topics; MCAP's index gives readers the order of time."""
    with open(file, "wb") as stream:
        session = Session(stream)
        session.writer.start(library="segcal")
        for entry in messages(folder, calibration, recording, images):
            session.add(*entry)
        session.writer.finish()
