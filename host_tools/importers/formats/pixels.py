"""Raw image buffers to arrays that a PNG keeps bit for bit: grey or RGB, 8 or 16 bit."""

import numpy as np

from streams import InputError

GREY = {"mono8": np.uint8, "8UC1": np.uint8, "mono16": np.uint16, "16UC1": np.uint16}
COLOUR = {"rgb8": [0, 1, 2], "bgr8": [2, 1, 0], "8UC3": [2, 1, 0], "rgba8": [0, 1, 2], "bgra8": [2, 1, 0]}
LUMA_OFFSET = {"yuv422": 1, "uyvy": 1, "yuv422_yuy2": 0, "yuyv": 0}  # of each pixel's two bytes
PLANAR = {"nv12", "nv21", "nv24", "i420"}  # the brightness comes first
KNOWN = sorted([*GREY, *COLOUR, *LUMA_OFFSET, *PLANAR, "bayer_*8"])


def from_buffer(data, width, height, step, encoding, big_endian):
    """The image of a message, rows of `step` bytes. Raises InputError for an encoding that is not known."""
    if width < 1 or height < 1 or len(data) < step * height:
        raise InputError(f"an image of {width} x {height} px with {len(data)} bytes, fewer than its {height} rows of {step}")
    if encoding in PLANAR:
        return np.frombuffer(data, np.uint8, step * height).reshape(height, step)[:, :width]
    rows = np.frombuffer(data, np.uint8, step * height).reshape(height, step)
    try:
        if encoding in GREY:
            values = np.ascontiguousarray(rows[:, : width * np.dtype(GREY[encoding]).itemsize]).view(GREY[encoding])
            return values.byteswap() if big_endian and values.itemsize > 1 else values
        if encoding in COLOUR:
            n = 4 if encoding.endswith("a8") else 3
            return rows[:, : width * n].reshape(height, width, n)[:, :, COLOUR[encoding]]
        if encoding in LUMA_OFFSET:
            return rows[:, LUMA_OFFSET[encoding] : 2 * width : 2]
        if encoding.startswith("bayer_") and encoding.endswith("8"):
            return grey_of_mosaic(rows[:, :width])
    except ValueError:
        raise InputError(f"an image of {width} x {height} px in {encoding} with rows of {step} bytes only") from None
    raise InputError(f"images in '{encoding}'; known: {', '.join(KNOWN)}")


def grey_of_mosaic(mosaic):
    """Grey from a Bayer mosaic of any order: the binomial filter [1 2 1]'[1 2 1]/16 weighs the colours R/4 + G/2 + B/4 at
    each pixel, and leaves no trace of the pattern that a tracker could follow."""
    wide = np.pad(mosaic.astype(np.uint16), 1, mode="reflect")  # reflect keeps the order of the colours
    rows = wide[:-2] + 2 * wide[1:-1] + wide[2:]
    return ((rows[:, :-2] + 2 * rows[:, 1:-1] + rows[:, 2:] + 8) >> 4).astype(np.uint8)
