"""Which logs there are, and what tells them apart: their bytes, not their names."""

import functools
import hashlib
import pathlib
import re

import input_error
import yaml
from input_error import InputError


def is_log(path):
    return path.suffix == ".segcal" or (path / "mav0").is_dir()


def below(folder):
    """Recordings and device logs in a folder; a recording is not looked into."""
    if is_log(folder):
        return [folder]
    found = []
    for entry in sorted(folder.iterdir()):
        if is_log(entry):
            found.append(entry)
        elif entry.is_dir():
            found += below(entry)
    return found


def named_in(file):
    lines = (line.strip() for line in file.read_text().splitlines())
    return [pathlib.Path(line) for line in lines if line and not line.startswith("#")]


def natural_order(path):
    """session_2 before session_10."""
    return [(0, int(piece), "") if piece.isdigit() else (1, 0, piece) for piece in re.split(r"(\d+)", str(path))]


def find_logs(arguments):
    """Logs named on the command line, in folders, or in lists (@FILE), each once, in natural order of their paths."""
    paths = []
    for argument in arguments:
        path = pathlib.Path(argument.removeprefix("@"))
        if not path.exists():
            raise InputError(f"{path}: no such file or folder")
        if not path.is_file() and not path.is_dir():
            raise InputError(f"{path}: expected a regular file or a folder, found a pipe or a device")
        listed = named_in(path) if argument.startswith("@") else [path]
        for entry in listed:
            found = below(entry) if entry.is_dir() else [entry] if entry.suffix == ".segcal" and entry.is_file() else []
            if not found:
                raise InputError(f"{entry}: expected a recording (a folder with mav0), a device log (*.segcal) or a folder of them")
            paths += found
    return sorted({path.resolve() for path in paths}, key=natural_order)


def digest(data):
    return hashlib.sha256(data).hexdigest()


def digest_of_file(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_read(cameras):
    """What `segcal replay` reads of a recording (host_tools/src/replay/provenance.cpp)."""
    per_camera = [f"mav0/cam{c}/{name}" for c in range(cameras) for name in ("sensor.yaml", "tracks.csv")]
    calibrations = [f"dso/{name}" for name in ("camchain.yaml", "imu.yaml", "imu_config.yaml")]
    return sorted(["camchain-imucam.yaml", "imu.yaml", "mav0/imu0/data.csv", "mav0/imu0/sensor.yaml", *calibrations, *per_camera])


def digest_of_log(log, cameras=1):
    """result.json's log_sha256 (docs/formats.md), before any replay."""
    log = pathlib.Path(log)
    if not log.is_dir():
        return digest_of_file(log)
    lines = [f"{digest_of_file(log / file)}  {file}\n" for file in files_read(cameras) if (log / file).exists()]
    return digest("".join(lines).encode())


@functools.cache
def compiled(pattern):
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise InputError(f"--devices: expected a regular expression, {error}") from None
    if "device" not in expression.groupindex:
        raise InputError("--devices: expected a group (?P<device>...), and perhaps (?P<model>...)")
    return expression


def device_file(log):
    """REC/device.yaml, for logs that were refused; empty without one."""
    file = pathlib.Path(log) / "device.yaml"
    content = yaml.safe_load(file.read_text()) if file.exists() else None
    return content if isinstance(content, dict) else {}


def device_of(log, result, pattern):
    """(device, model) by the path where a pattern is given, else as result or log say; a log of an unknown device is one of its own."""
    said = result or device_file(log)
    device, model = said.get("device_id"), said.get("device_model")
    if pattern:
        match = compiled(pattern).search(log)
        if not match:
            raise InputError(f"--devices: {log} does not match {pattern}")
        groups = match.groupdict()
        device, model = groups["device"], groups.get("model") or model
    return device or f"unknown:{pathlib.Path(log).name}", model or "unknown"
