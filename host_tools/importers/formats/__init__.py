"""The formats, in the order in which they are asked whether a file is theirs."""

from . import asl, phone, ros, ulog, unsupported, video, vrs

ALL = [unsupported, ros, ulog, vrs, asl, video, phone]

# Packages that are not installed unasked, and the command that does.
EXTRAS = {"av": "video", "pyvrs": "vrs"}


def missing_package(name):
    extra = EXTRAS.get((name or "").split(".")[0])
    if extra:
        return f"this log needs the Python package '{name}'; install it with: .venv/bin/pip install -r host_tools/importers/requirements-{extra}.txt"
    return f"the Python package '{name}' is missing; host_tools/setup.sh installs it"
