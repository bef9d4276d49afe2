"""Image files that are kept as they are: their size, and whether they are whole."""

import io
import struct

from PIL import Image

from streams import InputError

JPEG_SCAN = 0xDA
PNG_END = b"\0\0\0\0IEND\xaeB`\x82"
# What Pillow raises on damaged files of one format or another.
DAMAGE = (OSError, SyntaxError, ValueError, EOFError, struct.error, Image.DecompressionBombError)


def png_ends(data):
    """The last chunk is an empty IEND (PNG specification, section 5.6); some writers pad the file after it."""
    return PNG_END in data


def jpeg_ends(data):
    """An end marker, FF D9, after the first scan's begin; a thumbnail, which has its own, comes before (ITU-T T.81, B.1.1)."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != JPEG_SCAN:
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return data.find(b"\xff\xd9", at) >= 0


def webp_ends(data):
    """As long as its header says (WebP container specification: RIFF)."""
    return len(data) >= 8 + int.from_bytes(data[4:8], "little")


ENDS = {"PNG": png_ends, "JPEG": jpeg_ends, "WEBP": webp_ends}


def size_of(data, name):
    """(width, height) of a whole image file of these bytes. Where its end is not found, or the format has no mark for it, it is decoded, which
    takes ten times as long; but a PNG must have its end, as Pillow decodes one without and OpenCV's reader, which tracks, may not. Raises
    InputError."""
    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.format not in ENDS or not ENDS[image.format](data):
                if image.format == "PNG":
                    raise EOFError
                image.load()
            return image.size
    except DAMAGE:
        raise InputError(f"an image that cannot be decoded, damaged or cut short ({name}, {len(data)} bytes)") from None
