"""Logs of phone applications: a folder with a table per sensor (CSV), or JSON lines, and images that a table lists.

Sensors and units are known by the headings (`Gyroscope x (rad/s)`, `w_x [rad/s]`, `x`) and, where these are bare, by the
file's name (gyro.csv, Accelerometer.csv). Understood as exported by Sensor Logger, phyphox and the like."""

import functools
import json

import numpy as np

from streams import Image, Imu, InputError, StreamInfo

from . import tables

DEEPEST = 4  # folders
TEXT = {".csv", ".txt", ".tsv"}
JSON = {".jsonl", ".ndjson", ".json"}
IMAGE = {".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".pgm"}
HEAD_BYTES = 4096


def files_below(path):
    if path.is_file():
        return [path]
    files = [f for f in path.rglob("*") if len(f.relative_to(path).parts) <= DEEPEST and f.is_file()]
    return sorted(f for f in files if f.suffix.lower() in TEXT | JSON)


def head_of(file):
    with file.open("rb") as stream:
        return stream.read(HEAD_BYTES).decode("utf-8-sig", errors="replace").split("\n")


def probe(paths):
    """A Source if any table or JSON file below the paths holds a sensor's rows; several paths only where all are such files."""
    if any(p.is_file() and p.suffix.lower() not in TEXT | JSON for p in paths):
        return None
    source = Source(paths)
    return source if source.sensors or source.images else None


def table_without_heading(path):
    """Words about a table of numbers whose columns nothing names; empty where there is none."""
    for file in files_below(path):
        first = next((line for line in head_of(file) if line.strip()), "") if file.suffix.lower() in TEXT else ""
        if len(fields := tables.split(first)) > 3 and all(map(tables.is_number, fields)):
            return (f". {file.name} has no heading: give it one that names time and axes, such as timestamp [ns],gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z, "
                    "or, for t,x,y,z of one sensor, a name with gyro or acc")
    return ""


class Source:
    title = "phone log"

    def __init__(self, paths):
        self.where = str(paths[0])
        self.root = paths[0] if paths[0].is_dir() else paths[0].parent
        self.sensors = {}  # name -> function that reads it, and its kind
        self.notes = []
        self.images = {}  # name -> (file, layout)
        self.read = functools.cache(lambda name: self.sensors[name][1]())
        for path in paths:
            for file in files_below(path):
                (self.find_json if file.suffix.lower() in JSON else self.find_table)(file)

    def name_of(self, file):
        return str(file.relative_to(self.root)) if file.is_relative_to(self.root) else file.name

    def find_table(self, file):
        layout = tables.layout_of(file, head_of(file))
        if layout is None:
            return
        name = self.name_of(file)
        if layout.axes:
            kind = "imu" if len(layout.axes) == 2 else next(iter(layout.axes))
            self.sensors[name] = (kind, lambda: read_table(file, layout))
        elif layout.file_name is not None:
            self.images[name] = (file, layout)
            if layout.exposure is not None and not layout.exposure_unit:
                self.notes.append(f"{name}: the exposure's unit is not in its heading, such as exposure [ns]: exposures are left out")

    def find_json(self, file):
        sensors = {}
        for sensor in read_json(file, head_only=True).values():
            sensors[sensor.kind] = sensor
        for kind in sensors:
            self.sensors[f"{self.name_of(file)}#{kind}"] = (kind, lambda kind=kind: {kind: read_json(file)[kind]})

    def streams(self):
        out = []
        for name, (kind, _) in self.sensors.items():
            imu = self.imu(name)
            seconds = (imu.t_ns[-1] - imu.t_ns[0]) * 1e-9 if len(imu.t_ns) > 1 else 0
            out.append(StreamInfo(name, kind, len(imu.t_ns), f"{len(imu.t_ns) / seconds:.1f} Hz" if seconds > 0 else ""))
        for name, (file, layout) in self.images.items():
            out.append(StreamInfo(name, "camera", sum(1 for _ in tables.rows_of(file, layout)), "images listed in a table"))
        return out

    def imu(self, name):
        sensors = self.read(name)
        where = f"{self.root / name}".split("#")[0]
        parts = {kind: np.array(s.values, float).reshape(-1, 3) for kind, s in sensors.items()}
        first = next(iter(sensors.values()))
        t_ns = tables.to_nanoseconds(first.times, first.time_unit, where)
        return Imu(name, t_ns, t_ns, parts.get("gyro"), parts.get("accel"), None,
                   sensors["gyro"].unit if "gyro" in sensors else "", sensors["accel"].unit if "accel" in sensors else "")

    def frames(self, name):
        file, layout = self.images[name]
        rows = list(tables.rows_of(file, layout))
        stamps = tables.to_nanoseconds([fields[layout.time] for _, fields in rows], layout.time_unit, str(file), rates_hz=(1, 2_000))
        for (number, fields), t_ns in zip(rows, stamps):
            image = next((f for f in (file.parent / "data" / fields[layout.file_name], file.parent / fields[layout.file_name]) if f.is_file()), None)
            if image is None or image.suffix.lower() not in IMAGE:
                raise InputError(f"{file}:{number}: expected an image that exists, found {fields[layout.file_name]}")
            exposure_ns = tables.exposure_of(fields[layout.exposure], layout.exposure_unit, f"{file}:{number}") if layout.exposure_unit else 0
            yield Image(int(t_ns), int(t_ns), None, image.read_bytes(), image.suffix.lower(), exposure_ns)

    def calib(self, name):
        return None

    def extrinsics(self, camera, imu):
        return None


def read_table(file, layout):
    sensors = {kind: tables.Sensor(file.name, kind, unit, layout.time_unit) for kind, (_, unit) in layout.axes.items()}
    for number, fields in tables.rows_of(file, layout):
        try:
            for kind, (slots, _) in layout.axes.items():
                sensors[kind].values.append([float(fields[i]) for i in slots])
                sensors[kind].times.append(fields[layout.time])
        except ValueError:
            raise InputError(f"{file}:{number}: expected numbers for the three axes") from None
    return sensors


def objects_of(file, head_only):
    """(line, object): one a line, or the members of one list."""
    text = "\n".join(head_of(file)[:-1]) if head_only and file.stat().st_size > HEAD_BYTES else file.read_text(encoding="utf-8-sig", errors="replace")
    if text.lstrip().startswith("["):
        try:
            return [(1, o) for o in json.loads(file.read_text(encoding="utf-8-sig"), parse_float=str)]
        except json.JSONDecodeError as error:
            raise InputError(f"{file}:{error.lineno}: expected JSON, {error.msg}") from None
    out = []
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            out.append((number, json.loads(line, parse_float=str)))
        except json.JSONDecodeError as error:
            if head_only or (number == len(lines) and out):
                break  # another format; or the last line was cut off
            raise InputError(f"{file}:{number}: expected a JSON object on each line, {error.msg}") from None
    return out


def read_json(file, head_only=False):
    """Sensors of a JSON file by kind. Known: {"sensor": "gyro", "time": t, "x": ...}, {"sensor": {"type": ..., "values": [...]},
    "time": t}, {"time": t, "gyro": [...], "accel": [...]}; numbers may be texts, times too."""
    sensors = {}
    for number, entry in objects_of(file, head_only):
        if not isinstance(entry, dict):
            continue
        time_key = next((k for k in entry if tables.TIME.match(k.lower())), None)
        if time_key is None:
            continue
        for kind, values in values_of(entry):
            sensor = sensors.setdefault(kind, tables.Sensor(file.name, kind, "", tables.time_unit(tables.Column.of(time_key))))
            try:
                sensor.values.append([float(v) for v in values])
                sensor.times.append(str(entry[time_key]))
            except (TypeError, ValueError):
                raise InputError(f"{file}:{number}: expected numbers for the three axes") from None
    return sensors


def values_of(entry):
    """[(kind, x y z)] of one JSON object."""
    named = entry.get("sensor", entry.get("type", entry.get("name")))
    if isinstance(named, dict):  # {"sensor": {"type": "gyroscope", "values": [...]}}
        entry, named = named, named.get("type", named.get("name"))
    if isinstance(named, str):
        kind = tables.sensor_of(named)
        inner = entry.get("values", entry)
        triple = inner if isinstance(inner, list) else [inner.get(a) for a in "xyz"] if isinstance(inner, dict) else []
        return [(kind, triple[:3])] if kind and len(triple) >= 3 and None not in triple[:3] else []
    out = []
    for key, value in entry.items():
        kind = tables.sensor_of(key)
        triple = [value.get(a) for a in "xyz"] if isinstance(value, dict) else value
        if kind and isinstance(triple, list) and len(triple) == 3:
            out.append((kind, triple))
    return out
