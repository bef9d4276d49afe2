"""Files of a folder belong together: manifest.json (docs/formats.md)."""

from __future__ import annotations

import hashlib
import json
import pathlib


def check_folder(folder):
    """Raises ValueError if the run that wrote the folder was stopped, or if a file is not the one that it wrote. A folder without a
    manifest passes, made by hand or by other programs, and so do files that were removed."""
    folder = pathlib.Path(folder)
    file = folder / "manifest.json"
    if not file.exists():
        return
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        if not isinstance(content, dict) or content.get("kind") != "segcal output":
            return
        if "writing" in content:
            raise ValueError(f"segcal {content['writing']['command']} was stopped while it wrote this folder; run it again")
        written = [(run["command"], entry["name"], entry["bytes"], entry["sha256"]) for run in content["runs"] for entry in run["files"]]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{file}: {error}") from None
    for command, name, size, sha256 in written:
        path = folder / name
        if path.exists() and (path.stat().st_size != size or hashlib.sha256(path.read_bytes()).hexdigest() != sha256):
            raise ValueError(f"{path}: not the file that segcal {command} wrote with the others of this folder; run it again, or remove "
                             f"{file} if you changed the file yourself")
