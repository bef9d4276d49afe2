"""A session as rerun's .rrd: what session_mcap.py writes, with rerun's own archetypes.

Entities: world (z up), world/map, world/path, world/imu (moves), world/imu/camN (pinhole), .../camN/image, .../camN/tracks,
gyro and accel (x, y, z over time), log, calibration (a table)."""

import numpy as np
import rerun as rr

import session_files
from basalt import quaternion

LEVELS = {"calibrated": "INFO", "insufficient": "WARN"}
TIME = "time"


def at(stream, t_ns):
    stream.set_time(TIME, timestamp=np.datetime64(t_ns, "ns"))


def log_path(stream, poses):
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    stream.log("world/path", rr.LineStrips3D([[p for _, p, _ in poses]]), static=True)
    for t, p, q in poses:
        at(stream, t)
        stream.log("world/imu", rr.Transform3D(translation=p, quaternion=q))


def log_cameras(stream, calibration):
    """rerun's pinhole knows no lens: points near the image's edge are off by what the lens bends."""
    for i, camera in enumerate(calibration.cameras):
        T_IC, (fx, fy, cx, cy) = np.linalg.inv(camera.T_CI), camera.intrinsics
        entity = f"world/imu/cam{i}"
        stream.log(entity, rr.Transform3D(translation=T_IC[:3, 3], quaternion=quaternion(T_IC[:3, :3])), static=True)
        stream.log(entity, rr.Pinhole(image_from_camera=[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], resolution=camera.size, camera_xyz=rr.ViewCoordinates.RDF), static=True)


def log_recording(stream, recording, cameras, with_images):
    for i in range(cameras):
        folder = recording / "mav0" / f"cam{i}"
        for t, file in session_files.images(folder) if with_images else ():
            at(stream, t)
            stream.log(f"world/imu/cam{i}/image", rr.EncodedImage(contents=file.read_bytes(), media_type=f"image/{file.suffix[1:].lower().replace('jpg', 'jpeg')}"))
        for t, points in session_files.tracks(folder):
            at(stream, t)
            stream.log(f"world/imu/cam{i}/tracks", rr.Points2D(points, radii=2, colors=[0, 255, 0]))
    samples = list(session_files.imu(recording))
    times = [rr.TimeColumn(TIME, timestamp=np.array([t for t, *_ in samples], "datetime64[ns]"))]
    for sensor, column in (("gyro", 1), ("accel", 2)):
        for k, axis in enumerate("xyz"):
            stream.send_columns(f"{sensor}/{axis}", indexes=times, columns=rr.Scalars.columns(scalars=[s[column][k] for s in samples]))


def log_words(stream, folder, t):
    status, sentences = session_files.sentences(folder)
    at(stream, t)
    for sentence in sentences:
        stream.log("log", rr.TextLog(sentence, level=LEVELS.get(status, "ERROR")))


def write(file, folder, calibration, recording, images):
    stream = rr.RecordingStream("segcal")
    stream.save(file)
    poses = session_files.trajectory(folder / "trajectory.tum")
    log_path(stream, poses)
    log_cameras(stream, calibration)
    for t, points in session_files.landmarks(folder / "kept_segments.json"):
        at(stream, t)
        stream.log("world/map", rr.Points3D(points))
    log_words(stream, folder, poses[-1][0])
    if recording:
        log_recording(stream, recording, len(calibration.cameras), images)
    stream.flush()
    stream.disconnect()
