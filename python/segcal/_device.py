"""A device, with arrays of any number type."""

from __future__ import annotations

import numpy as np

from . import _core

NONE = np.zeros(0)


class Device:
    """All memory and state of one device. Not for two threads at a time."""

    def __init__(self, config):
        self._device = _core.Device(config)

    def push_imu(self, t_ns, gyro, accel, temperature=None):
        """Samples in order: stamps (n) in ns, gyro and accel (n, 3) in rad/s and m/s^2, temperature (n) in degC where the configuration
        has one. Returns how many the core refused: stamps that go back, numbers that are none."""
        warmth = NONE if temperature is None else np.ascontiguousarray(temperature, np.float64)
        return self._device.push_imu(np.ascontiguousarray(t_ns, np.int64), np.ascontiguousarray(gyro, np.float64),
                                     np.ascontiguousarray(accel, np.float64), warmth)

    def push_tracks(self, t_ns, track_id, uv, camera=None):
        """The points of one image: ids (n), raw pixels (n, 2), and with two cameras the camera of each (n). Returns the core's code:
        1 waiting, 2 skipped, 3 tracking, 4 lost, negative: refused."""
        of_camera = np.zeros(0, np.int32) if camera is None else np.ascontiguousarray(camera, np.int32)
        return self._device.push_tracks(int(t_ns), np.ascontiguousarray(track_id, np.uint32), np.ascontiguousarray(uv, np.float64), of_camera)

    def background(self, slices=2**31 - 1):
        """Pending work, at most so many slices; 1 while some is left."""
        return self._device.background(slices)

    def flush(self):
        """Ends and scores the open segment."""
        return self._device.flush()

    def new_session(self):
        return self._device.new_session()

    def calibrate(self):
        """True if something was released; the reasons are in result()."""
        return self._device.calibrate() == 0

    def run(self, recording):
        """Pushes a recording in the order of its stamps, as `segcal replay` does, and calibrates. True if something was released."""
        at, imu = 0, recording
        for frame in recording.frames:
            reached = np.flatnonzero(imu.t_ns[at:] >= frame.t_ns)
            end = at + int(reached[0]) + 1 if len(reached) else len(imu.t_ns)
            part = slice(at, end)
            self.push_imu(imu.t_ns[part], imu.gyro[part], imu.accel[part], None if imu.temperature is None else imu.temperature[part])
            at = end
            self.push_tracks(frame.t_ns, frame.track_id, frame.uv, frame.camera)
            self.background()
        self.flush()
        self.background()
        return self.calibrate()

    def result(self):
        """None before a calibration; else status, parameters (a list of rows: name, value, sigma, unit, initial, prior_sigma, verdict),
        fit, and `mean` (n) and `covariance` (n, n) of the fit with nothing held."""
        return self._device.result()

    def pose(self):
        """p_GI x y z [m] and q_GI w x y z, (7), of the newest frame; None before the filter runs."""
        return self._device.pose()

    def result_hash(self):
        """16 hexadecimal digits over all bits of what was found, as in result.json."""
        return f"{self._device.result_hash():016x}"
