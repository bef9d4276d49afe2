"""ROS: camN.yaml as camera_calibration_parsers reads it (sensor_msgs/CameraInfo), and the poses for static transforms (/tf_static)."""

import numpy as np

from basalt import quaternion
from lenses import without_fov
from yaml_text import row


def matrix_block(name, values):
    values = np.atleast_2d(values)
    return f"{name}:\n  rows: {values.shape[0]}\n  cols: {values.shape[1]}\n  data: {row(values.ravel())}\n"


def files_of(calibration):
    lenses, notes = without_fov(calibration.cameras)
    files = {}
    transforms = "# Pose of each camera (x right, y down, z forward) in the IMU's frame: p_parent = R p_child + translation, m\ntransforms:\n"
    for i, (camera, (model, distortion, intrinsics)) in enumerate(zip(calibration.cameras, lenses)):
        fx, fy, cx, cy = intrinsics
        K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        plumb_bob = model == "radtan"
        text = f"image_width: {camera.size[0]}\nimage_height: {camera.size[1]}\ncamera_name: cam{i}\n" + matrix_block("camera_matrix", K)
        text += f"distortion_model: {'plumb_bob' if plumb_bob else 'equidistant'}\n"
        text += matrix_block("distortion_coefficients", [*distortion, 0.0] if plumb_bob else distortion)
        text += matrix_block("rectification_matrix", np.eye(3)) + matrix_block("projection_matrix", np.hstack([K, np.zeros((3, 1))]))
        files[f"cam{i}.yaml"] = text
        T_IC = np.linalg.inv(camera.T_CI)
        x, y, z, w = quaternion(T_IC[:3, :3])
        tx, ty, tz = T_IC[:3, 3].tolist()
        transforms += f"- parent: imu\n  child: cam{i}\n  translation: {row((tx, ty, tz))}\n  rotation_xyzw: {row((x, y, z, w))}\n"
        transforms += (f"  # ros2 run tf2_ros static_transform_publisher --x {tx!r} --y {ty!r} --z {tz!r} --qx {x!r} --qy {y!r} --qz {z!r} --qw {w!r}"
                       f" --frame-id imu --child-frame-id cam{i}\n")
    files["transforms.yaml"] = transforms
    if any(camera.timeshift_s for camera in calibration.cameras):
        notes.append("CameraInfo has no place for the time shift between camera and IMU; the other formats have")
    return files, notes
