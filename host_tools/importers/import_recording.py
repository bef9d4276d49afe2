"""`segcal import`: any log to a recording folder. Called by the program, which parses and explains the options."""

import argparse
import sys
from pathlib import Path

import formats
from streams import InputError


def parse(arguments):
    parser = argparse.ArgumentParser()
    parser.add_argument("sources", nargs="+", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--json", action="store_true")
    for name in ("imu", "gyro", "accel", "stamps", "gyro-unit", "accel-unit", "gyro-axes", "accel-axes", "mount"):
        parser.add_argument(f"--{name}", default="")
    parser.add_argument("--imu-stamps", default="auto")
    parser.add_argument("--camera", action="append", default=[])
    parser.add_argument("--calib", type=Path)
    parser.add_argument("--imu-noise", type=Path)
    parser.add_argument("--focal", type=float, default=0)
    return parser.parse_args(arguments)


def opened(paths):
    """Sources for all paths: together if they are one log, else one by one."""
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such file or folder")
        if not path.is_file() and not path.is_dir():
            raise InputError(f"{path}: expected a regular file or a folder, found a pipe or a device")
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{path}: the file is empty")
    for group in ([paths] if len(paths) > 1 else []):
        for module in formats.ALL:
            source = module.probe(group)
            if source:
                return [source]
    return [opened_one(path) for path in paths]


def opened_one(path):
    for module in formats.ALL:
        source = module.probe([path])
        if source:
            return source
    raise InputError(f"{path}: not a log that segcal knows; `segcal import --help` lists the formats{formats.phone.table_without_heading(path)}")


def show(sources):
    for source in sources:
        print(f"{source.where}: {source.title}")
        for stream in source.streams():
            print(f"  {stream.kind:7} {stream.name:40} {stream.count:8d}  {stream.note}")


def main(arguments):
    options = parse(arguments)
    try:
        sources = opened(options.sources)
        if options.list:
            return show(sources)
        import stage
        stage.convert(sources, options)
    except ImportError as error:
        raise InputError(formats.missing_package(error.name)) from None


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print("segcal: " + " ".join(str(error).split()), file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("segcal: interrupted, nothing was written", file=sys.stderr)
        sys.exit(2)
