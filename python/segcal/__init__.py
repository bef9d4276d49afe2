"""segcal from Python: the core that runs in firmware, with numpy in and out.

    rec = segcal.read("rec")                  # a recording in EuRoC's folder layout, with tracks
    device = segcal.Device(rec.config)
    device.run(rec)                           # as a device would live it; then device.result()

Frames, units and meanings are those of lib/include/segcal/segcal.h."""

from ._core import MAX_TRACKS, STORAGE_BYTES, Camera, Config, ImuCalibration
from ._recording import Frame, Recording, read
from ._device import Device

__all__ = ["MAX_TRACKS", "STORAGE_BYTES", "Camera", "Config", "Device", "Frame", "ImuCalibration", "Recording", "read"]
__version__ = "1.0.0"
