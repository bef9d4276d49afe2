"""`segcal export`: a calibration in the files of other tools.

Usage: export.py DIR kalibr|openvins|basalt|ros|mcap|rerun OUT [--rec=REC] [--no-images]. Exit code 0 when all files are written, 2 with one line on stderr."""

import importlib
import os
import sys
from pathlib import Path

import fsspec
from calibration_folder import read_calibration
from input_error import InputError
from output_run import OutputRun


def run_into(out, to, names):
    return OutputRun(fsspec.filesystem("file"), str(out.absolute()), f"export --to {to}", names)


def write_all(out, to, files):
    """All files or none that is new: each under a temporary name first."""
    try:
        with run_into(out, to, files):
            parts = []
            for name, text in files.items():
                part = out / f".{name}.{os.getpid()}.part"
                part.write_text(text, encoding="utf-8")
                parts.append((part, out / name))
            for part, file in parts:
                os.replace(part, file)
    except OSError as error:
        raise InputError(f"{error.filename or out}: cannot be written: {error.strerror}") from None


SESSIONS = {"mcap": "session.mcap", "rerun": "session.rrd"}
# Packages that are not installed unasked, and the command that does.
EXTRAS = {"rerun": "rerun"}


def missing_package(name):
    extra = EXTRAS.get((name or "").split(".")[0])
    if extra:
        return f"this export needs the Python package '{name}'; install it with: .venv/bin/pip install -r host_tools/exporters/requirements-{extra}.txt"
    return f"the Python package '{name}' is missing; host_tools/setup.sh installs it"


def export_session(folder, to, out, options):
    """One file, which may be as large as the recording: written beside its place, then renamed."""
    session = importlib.import_module(f"session_{to}")
    recording = next((Path(o.removeprefix("--rec=")) for o in options if o.startswith("--rec=")), None)
    part, file = out / f".{SESSIONS[to]}.{os.getpid()}.part", out / SESSIONS[to]
    try:
        with run_into(out, to, [file.name]):
            session.write(part, folder, read_calibration(folder), recording, "--no-images" not in options)
            os.replace(part, file)
    except OSError as error:
        raise InputError(f"{error.filename or out}: {error.strerror}") from None
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"{folder}: not what `segcal replay` writes, or not its recording ({type(error).__name__}: {error})") from None
    finally:
        part.unlink(missing_ok=True)
    print(f"wrote {file}")


def main(arguments):
    folder, to, out = Path(arguments[0]), arguments[1], Path(arguments[2])
    if out.exists() and folder.resolve() == out.resolve():
        raise InputError(f"{out}: expected another folder than the calibration's: files of the same name would be replaced")
    try:
        if to in SESSIONS:
            return export_session(folder, to, out, arguments[3:])
        import basalt
        import kalibr
        import openvins
        import ros
    except ImportError as error:
        raise InputError(missing_package(error.name)) from None
    files, notes = {"kalibr": kalibr, "openvins": openvins, "basalt": basalt, "ros": ros}[to].files_of(read_calibration(folder))
    write_all(out, to, files)
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    print(f"wrote {', '.join(str(out / name) for name in files)}")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print("segcal: " + " ".join(str(error).split()), file=sys.stderr)
        sys.exit(2)
