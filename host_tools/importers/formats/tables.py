"""Text tables of phone applications: which column is the time, which are the axes of which sensor, and in which unit."""

import re
import sys
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from streams import InputError

NOTED = set()
NS_OF = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000}
UNIT_WORDS = {"nanoseconds": "ns", "microseconds": "us", "milliseconds": "ms", "seconds": "s", "sec": "s", "µs": "us",
              "nanosec": "ns", "microsec": "us", "millisec": "ms", "nsec": "ns", "usec": "us", "msec": "ms"}
GYRO = re.compile(r"gyr|angular|rotation_?rate|omega|^[wg]_?(rs_s_)?[xyz]\b|^rot")
ACCEL = re.compile(r"acc|^a_?(rs_s_)?[xyz]\b")
OTHER = re.compile(r"linear|user|gravity|magn|orient|attitude|quat|baro|light|compass|without")  # and no raw accelerometer
TIME = re.compile(r"^(sensor_?|event_?|hardware_?)?(time_?stamps?|time|t|seconds_elapsed|elapsed(_?time)?)(_?(ns|us|ms|s|seconds|nanoseconds|milliseconds))?$")
EXPOSURE = re.compile(r"^exposure(_?(time|duration))?(_(ns|us|ms|s|sec|seconds|nanosec|nanoseconds|microseconds|milliseconds))?$")
LONGEST_EXPOSURE_NS = 1_000_000_000  # of a camera that moves: more is another unit
FILE_NAME = re.compile(r"^(file_?name|file|image|image_?name|path|frame_?file)$")


def sensor_of(text):
    """ "gyro", "accel" or None, from the name of a column, a file or a JSON field."""
    text = text.lower()
    if OTHER.search(text) and "total" not in text:
        return None
    return "gyro" if GYRO.search(text) else "accel" if ACCEL.search(text) or text == "totalacceleration" else None


@dataclass
class Column:
    """One heading, taken apart: `Acceleration x (m/s^2)` is name "acceleration x", unit "m/s^2"."""

    name: str
    unit: str

    @staticmethod
    def of(heading):
        heading = heading.strip().lstrip("#").strip().strip('"').strip()
        match = re.match(r"^(.*?)\s*[\[(]\s*(.*?)\s*[\])]?$", heading)
        name, unit = (match.group(1), match.group(2)) if match else (heading, "")
        return Column(name.strip().lower().replace(" ", "_"), unit_name(unit))


def unit_name(text):
    """SI spellings to one: "m s^-2", "m/s²", "m/s2" are m/s^2."""
    text = text.lower().replace("²", "^2").replace(" ", "")
    text = UNIT_WORDS.get(text, text)
    if text in ("m/s^2", "m/s2", "ms^-2", "ms-2"):
        return "m/s^2"
    if text in ("rad/s", "rads^-1", "rads-1"):
        return "rad/s"
    if text in ("deg/s", "°/s", "dps", "degs^-1"):
        return "deg/s"
    return text if text in ("g", "mg", *NS_OF) else ""


@dataclass
class Sensor:
    """Rows of one sensor, as text for the time (exact) and numbers for the axes."""

    name: str
    kind: str
    unit: str
    time_unit: str
    times: list = field(default_factory=list)
    values: list = field(default_factory=list)


def to_nanoseconds(times, unit, where, rates_hz=(5, 20_000)):
    """Exact: decimals are not rounded to a double on the way. Without a unit, the one whose rate is plausible."""
    try:
        if unit == "ns" or not unit:
            numbers = [int(t) if isinstance(t, int) or t.lstrip("-").isdigit() else Decimal(t) for t in times]
        else:
            numbers = [Decimal(t) for t in times]
    except (InvalidOperation, ValueError):
        raise InputError(f"{where}: expected numbers as stamps") from None
    if not unit:
        step = float(np.median(np.abs(np.diff(np.array(numbers, float))))) if len(numbers) > 1 else 0
        fitting = [u for u, scale in NS_OF.items() if step > 0 and rates_hz[0] <= 1e9 / (step * scale) <= rates_hz[1]]
        # From the coarsest: a phone's sensors run at 5 to 1000 Hz.
        best = [u for u in fitting if 1e9 / (step * NS_OF[u]) <= 1500] or fitting
        if not best:
            raise InputError(f"{where}: the stamps' unit is not said, and {step:g} between two is no interval of a sensor in s, ms, us or ns")
        unit = best[-1]
    return np.array([int(n * NS_OF[unit]) for n in numbers], np.int64)


def split(line):
    separator = "\t" if "\t" in line else ";" if ";" in line else ","
    return [part.strip().strip('"') for part in line.rstrip("\r\n").split(separator)]


def is_number(text):
    try:
        float(text)
        return True
    except ValueError:
        return False


def axes_of(columns, file_kind):
    """{kind: ([x, y, z] column numbers, unit)} of a heading."""
    found = {}
    for i, column in enumerate(columns):
        axis = re.search(r"(?:^|_)([xyz])$|^(?:w|a|g|gyro|gyr|acc|accel|omega)_?([xyz])$|([xyz])$", column.name)
        if not axis or TIME.match(column.name):
            continue
        letter = next(g for g in axis.groups() if g)
        bare = column.name == letter
        kind = file_kind if bare else (sensor_of(column.name) or (file_kind if not OTHER.search(column.name) and len(column.name) <= 3 else None))
        if kind:
            slots, units = found.setdefault(kind, ({}, []))
            slots.setdefault(letter, i)
            units.append(column.unit)
    return {kind: ([slots[a] for a in "xyz"], units[0]) for kind, (slots, units) in found.items() if len(slots) == 3}


def time_column(columns):
    """Absolute stamps before elapsed seconds."""
    found = [i for i, column in enumerate(columns) if TIME.match(column.name)]
    found.sort(key=lambda i: "elapsed" in columns[i].name)
    return found[0] if found else None


def time_unit(column):
    match = re.search(r"_(ns|us|ms|s|sec|nanosec|nanoseconds|microseconds|milliseconds|seconds)$", column.name)
    return column.unit or (UNIT_WORDS.get(match.group(1), match.group(1)) if match else "s" if column.name == "seconds_elapsed" else "")


def exposure_of(text, unit, where):
    """ns; 0 where it is not known."""
    try:
        ns = int(round(Decimal(text) * NS_OF[unit]))
    except (InvalidOperation, ValueError, OverflowError):
        ns = -1
    if not 0 <= ns <= LONGEST_EXPOSURE_NS:
        raise InputError(f"{where}: expected an exposure of 0 (not known) to 1 s, found {text}")
    return ns


@dataclass
class Layout:
    """What the columns of one file mean."""

    first_row: int  # lines above it are the heading
    time: int
    time_unit: str
    axes: dict
    file_name: int | None
    columns: int
    exposure: int | None = None
    exposure_unit: str = ""  # empty: the heading does not say


def layout_of(file, head):
    """The layout by the heading, else by the file's name for bare rows of t, x, y, z; None if it is no sensor's table."""
    kind = sensor_of(Path(file).stem)
    lines = [line for line in head if line.strip()]
    if not lines:
        return None
    first = split(lines[0])
    if all(map(is_number, first)):
        return Layout(0, 0, "", {kind: ([1, 2, 3], "")}, None, 4) if kind and len(first) == 4 else None
    columns = [Column.of(part) for part in first]
    at = time_column(columns)
    if at is None:
        return None
    names = [i for i, column in enumerate(columns) if FILE_NAME.match(column.name)]
    axes = axes_of(columns, kind)
    if not axes and not names:
        return None
    exposure = next((i for i, column in enumerate(columns) if EXPOSURE.match(column.name)), None)
    return Layout(1, at, time_unit(columns[at]), axes, names[0] if names else None, len(columns), exposure,
                  time_unit(columns[exposure]) if exposure is not None else "")


def rows_of(file, layout):
    """(line number, fields); a last line that does not end may be cut inside a number: it is left out. Raises InputError."""
    try:
        text = Path(file).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{file}: expected text in UTF-8") from None
    lines = text.split("\n")
    whole = text.endswith("\n")
    for number, line in enumerate(lines, 1):
        if number <= layout.first_row or not line.strip() or line.startswith("#"):
            continue
        if number == len(lines) and not whole:
            if file not in NOTED:  # files are read several times
                NOTED.add(file)
                print(f"note: {file}:{number}: the last line does not end, so that it may be cut: it is left out", file=sys.stderr)
            return
        fields = split(line)
        if len(fields) != layout.columns:
            raise InputError(f"{file}:{number}: expected {layout.columns} columns, found {len(fields)}")
        yield number, fields
