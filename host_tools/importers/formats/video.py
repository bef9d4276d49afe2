"""A video and a table with the stamps of its frames, by the package av (FFmpeg), which is an extra.

The table lies beside the video: its name holds `frame` or `timestamp`, or is the video's own (clip.csv). One row a frame, with a
column of time. Frames become grey images, as FFmpeg's gray8 gives them: the brightness plane for all usual codecs."""

from streams import Image, InputError, StreamInfo

from . import tables

SUFFIXES = {".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v"}


def probe(paths):
    if len(paths) != 1 or not paths[0].is_file() or paths[0].suffix.lower() not in SUFFIXES:
        return None
    return Source(paths[0])


def stamps_beside(video):
    """The table of a video, or InputError."""
    near = sorted(f for f in video.parent.iterdir() if f.suffix.lower() in (".csv", ".txt"))
    own = [f for f in near if f.stem == video.stem]
    named = own + [f for f in near if f not in own and ("frame" in f.stem.lower() or "timestamp" in f.stem.lower())]
    if not named:
        raise InputError(f"{video}: expected a table of its frames' stamps beside it, {video.stem}.csv or frames.csv: a video alone does not know the IMU's clock")
    return named[0]


def read_stamps(file):
    text = file.read_text(encoding="utf-8-sig", errors="replace")
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise InputError(f"{file}: expected a stamp for each frame, found nothing")
    if text[-1] not in "\r\n":  # elsewhere such a line is left out; here each frame needs its own
        raise InputError(f"{file}:{len(text.splitlines())}: expected a line that ends: without it the last stamp may be cut inside its number")
    first = tables.split(lines[0].lstrip("#"))
    columns = [tables.Column.of(part) for part in first]
    if all(map(tables.is_number, first)):
        at, unit, body = 0, "", lines
    else:
        found = [i for i, c in enumerate(columns) if tables.TIME.match(c.name) or "timestamp" in c.name]
        if not found:
            raise InputError(f"{file}:1: expected a column of time, such as timestamp [ns]")
        at, unit, body = found[0], tables.time_unit(columns[found[0]]), lines[1:]
    try:
        texts = [tables.split(line)[at] for line in body]
    except IndexError:
        raise InputError(f"{file}: expected {at + 1} columns in each row") from None
    unit = "ns" if unit.startswith("nano") else unit
    return tables.to_nanoseconds(texts, unit, str(file), rates_hz=(1, 2_000))


class Source:
    title = "video"

    def __init__(self, path):
        self.path, self.where = path, str(path)
        self.table = stamps_beside(path)
        self.stamps = read_stamps(self.table)

    def opened(self):
        import av

        try:
            container = av.open(self.where)
            return container, container.streams.video[0]
        except (av.FFmpegError, IndexError, ValueError) as error:
            raise InputError(f"{self.path}: damaged video, or one that FFmpeg cannot read: {error}") from None

    def streams(self):
        container, stream = self.opened()
        container.close()
        return [StreamInfo(self.path.name, "camera", len(self.stamps), f"{stream.codec_context.name}, stamps of {self.table.name}")]

    def frames(self, name):
        import av

        container, stream = self.opened()
        n = 0
        try:
            with container:
                for frame in container.decode(stream):
                    if n < len(self.stamps):
                        t_ns = int(self.stamps[n])
                        yield Image(t_ns, t_ns, frame.to_ndarray(format="gray"))
                    n += 1
        except av.FFmpegError as error:
            raise InputError(f"{self.path}: damaged after {n} frames: {error}") from None
        if n != len(self.stamps):
            raise InputError(f"{self.path}: {n} frames, but {self.table} has {len(self.stamps)} stamps: expected one for each")

    def imu(self, name):
        raise InputError(f"{self.path}: no IMU in a video")

    def calib(self, name):
        return None

    def extrinsics(self, camera, imu):
        return None
