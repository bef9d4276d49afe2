"""Logs that are known and not read, so that the answer is a reason and a way on (docs/formats.md, "Logs that are not read")."""

from streams import InputError

GOPRO = ("GoPro's telemetry inside of a video is not read: images that the camera stabilised do not follow its gyroscope, and the file does not say how late they are "
         "against it. With stabilisation off, write a table of the IMU and one of the frames' stamps (docs/formats.md, 'Logs that are not read')")
MOST_HEADER = 64 << 20  # bytes: a moov box that describes an hour has some 10 MB


def moov_of(path):
    """The box of an MP4 file that describes its tracks (ISO/IEC 14496-12); empty if there is none."""
    end, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at + 8 <= end:
            file.seek(at)
            head = file.read(16)
            size, kind = int.from_bytes(head[:4], "big"), head[4:8]
            size = int.from_bytes(head[8:16], "big") if size == 1 else size or end - at
            if kind == b"moov":
                return head + file.read(min(size, MOST_HEADER) - len(head))
            if size < 8:
                return b""
            at += size
    return b""


def has_gopro_telemetry(path):
    return path.suffix.lower() in (".mp4", ".360", ".lrv") and b"gpmd" in moov_of(path)


def probe(paths):
    for path in (p for p in paths if p.is_file()):
        # With tables of one's own beside it, it is a video like others.
        if has_gopro_telemetry(path) and len(paths) == 1 and not any(path.with_suffix(s).exists() for s in (".csv", ".txt")):
            raise InputError(f"{path}: {GOPRO}")
    return None
