"""The formats, in the order in which they are asked whether a file is theirs."""

from . import asl, phone, ros, ulog, unsupported, video, vrs

ALL = [unsupported, ros, ulog, vrs, asl, video, phone]

# What is imported of packages that are not installed unasked: the package, and the list that the command installs.
EXTRAS = {"av": ("av", "video"), "pyvrs": ("vrs", "vrs")}


def missing_package(name):
    extra = EXTRAS.get((name or "").split(".")[0])
    if extra:
        package, file = extra
        return f"this log needs the Python package '{package}'; install it with: .venv/bin/pip install -r host_tools/importers/requirements-{file}.txt"
    return f"the Python package '{name}' is missing; host_tools/setup.sh installs it"
