"""Files that belong together: a folder's manifest.json (docs/formats.md), as host_tools/src/files/output_run.h writes it, on any file
system that fsspec knows."""

import hashlib
import json
import os
import platform
import re
from pathlib import Path

import fsspec
from input_error import InputError

NAME, KIND, FORMAT = "manifest.json", "segcal output", 1
ID_DIGITS = 16


def write_whole(fs, path, write):
    """`write` gets an open file. The old file or the new one is there, never a part; two runs into one folder do not meet, the last
    one stays."""
    folder, _, name = path.rpartition("/")
    temporary = f"{folder}/.{name}.{platform.node()}.{os.getpid()}.part"
    with fs.open(temporary, "wb") as file:
        write(file)
    if "file" in fs.protocol:
        os.replace(temporary, path)
    else:
        fs.mv(temporary, path)


def command_line():
    """Of the program that started this script, without its name."""
    try:
        return Path(f"/proc/{os.getppid()}/cmdline").read_bytes().decode(errors="replace").split("\0")[1:-1]
    except OSError:
        return []


def entry_of(fs, root, name):
    with fs.open(f"{root}/{name}", "rb") as file:
        digest = hashlib.sha256()
        size = 0
        while block := file.read(1 << 20):
            digest.update(block)
            size += len(block)
    return {"name": name, "bytes": size, "sha256": digest.hexdigest()}


def run_entry(command, files):
    lines = "".join(f"{f['sha256']}  {f['name']}\n" for f in files)
    return {"run": hashlib.sha256(lines.encode()).hexdigest()[:ID_DIGITS], "program": f"segcal {os.environ.get('SEGCAL_PROGRAM_VERSION', '')}".strip(),
            "command": command, "arguments": command_line(), "files": files}


def text_of(runs, writing=None):
    content = {"format": FORMAT, "kind": KIND, "runs": runs, **({"writing": writing} if writing else {})}
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode(errors="replace")


def read(fs, root):
    """(runs, what a stopped run was writing) of a folder; ([], {}) without a manifest."""
    where = f"{root}/{NAME}"
    try:
        content = json.loads(fs.cat_file(where))
    except FileNotFoundError:
        return [], {}
    except ValueError:
        raise InputError(f"{where}: expected the list of files that segcal writes") from None
    if not isinstance(content, dict) or content.get("kind") != KIND:
        raise InputError(f"{where}: expected a folder without one of another program: segcal writes its own")
    try:
        runs, writing = content["runs"], content.get("writing") or {}
        names = [f["name"] for run in runs for f in run["files"]] + writing.get("files", [])
        commands = [run["command"] for run in runs] + ([writing["command"]] if writing else [])
    except (AttributeError, KeyError, TypeError):
        raise InputError(f"{where}: expected the list of files that segcal writes") from None
    if not all(isinstance(n, str) and n and not n.startswith("/") and ".." not in n.split("/") for n in names) or not all(map(str.strip, commands)):
        raise InputError(f"{where}: expected names inside the folder")
    return runs, writing


DEEPEST = 3  # mav0/cam0/sensor.yaml: no name that segcal lists has more parts


def check_file(file):
    """InputError for a file on this machine that a manifest in its folder, or in one of those above, does not know as whole: files that pass, of
    one folder, belong together. As check_file of host_tools/src/files/manifest.h."""
    here = Path(os.path.abspath(file))
    for path in dict.fromkeys([here, here.resolve()]):  # a link into a folder of ours, or out of one
        for folder in list(path.parents)[:DEEPEST]:
            check_as_listed(folder, path.relative_to(folder).as_posix())


def check_as_listed(folder, name):
    fs = fsspec.filesystem("file")
    try:
        runs, writing = read(fs, str(folder))
    except InputError:
        return  # of another program
    entries = [(run["command"], f) for run in runs for f in run["files"] if f["name"] == name]
    if name in writing.get("files", []) or any(command == writing.get("command") for command, _ in entries):
        raise InputError(f"{folder}: expected all files of one run, but `segcal {writing['command']}` was stopped while it wrote them ({NAME}); run it again")
    for command, entry in entries:
        if entry_of(fs, str(folder), name) != entry:
            raise InputError(f"{folder / name}: expected the file that `segcal {command}` wrote with the others of this folder, found another one; run it "
                             f"again, or remove {folder / NAME} if you changed the file yourself")


def expect_folder(fs, root, command):
    """(runs, what a stopped one was writing). InputError if the folder is a recording or another command's: for the beginning of a
    command, so that no work is lost."""
    own, (runs, writing) = command.split()[0], read(fs, root)
    for other in (run["command"] for run in [*runs, *([writing] if writing else [])]):
        if other.split()[0] != own:
            raise InputError(f"{root}: expected a folder of its own for `segcal {own}`, found the files of `segcal {other}`")
    if fs.exists(f"{root}/mav0"):
        raise InputError(f"{root}: expected a folder of its own for `segcal {own}`, found a recording")
    if writing and writing["command"] != command:
        raise InputError(f"{root}: `segcal {writing['command']}` was stopped while it wrote here ({NAME}); run it again, or choose another folder")
    return runs, writing


class OutputRun:
    """`with OutputRun(fs, root, "export --to ros", names):` and the files are written inside. What stands there before the end, because the
    run was stopped, is known as that. Runs whose command has the same first word share a folder, each with its own files."""

    def __init__(self, fs, root, command, names):
        self.fs, self.root, self.command, self.names = fs, root, command, list(names)

    def __enter__(self):
        runs, writing = expect_folder(self.fs, self.root, self.command)
        self.fs.makedirs(self.root, exist_ok=True)
        self.remove_parts()
        self.old = [run for run in runs if run["command"] == self.command]
        self.others = [run for run in runs if run["command"] != self.command]
        self.runs, self.writing, self.interrupted = runs, writing, writing.get("files", [])
        self.before = self.state()
        self.put(text_of(runs, {"command": self.command, "files": list(dict.fromkeys([*self.interrupted, *self.names]))}))
        return self

    def put(self, text):
        write_whole(self.fs, f"{self.root}/{NAME}", lambda file: file.write(text))

    def remove_parts(self):
        """Temporary files of runs on this machine that are no more."""
        if "file" not in self.fs.protocol:
            return
        for part in Path(self.root).glob(".*.part"):
            match = re.fullmatch(rf"\..+?(?:\.{re.escape(platform.node())})?\.(\d+)\.part", part.name)
            if match and not Path(f"/proc/{match[1]}").exists():
                part.unlink(missing_ok=True)

    def state(self):
        """Tells whether any of the files was replaced: a rename brings another inode."""
        entries = {name: self.fs.info(f"{self.root}/{name}") for name in self.names if self.fs.exists(f"{self.root}/{name}")}
        return {name: tuple(entry.get(key) for key in ("size", "ino", "mtime", "LastModified", "etag")) for name, entry in entries.items()}

    def undo(self):
        """Nothing was written: as if it had not begun."""
        if self.runs or self.writing:
            self.put(text_of(self.runs, self.writing))
        else:
            self.fs.rm_file(f"{self.root}/{NAME}")

    def left_over(self):
        """Names of an earlier run of this command that this one did not write; of a run that came to its end, as it wrote them."""
        for entry in (f for run in self.old for f in run["files"] if f["name"] not in self.names):
            if self.fs.exists(f"{self.root}/{entry['name']}") and entry_of(self.fs, self.root, entry["name"]) == entry:
                yield entry["name"]
        yield from (n for n in self.interrupted if n not in self.names and self.fs.exists(f"{self.root}/{n}"))

    def __exit__(self, kind, *_):
        if kind is None:
            for name in list(self.left_over()):
                self.fs.rm_file(f"{self.root}/{name}")
            files = [entry_of(self.fs, self.root, name) for name in self.names]
            self.put(text_of([*self.others, run_entry(self.command, files)]))
        elif self.state() == self.before:
            self.undo()
        return False
