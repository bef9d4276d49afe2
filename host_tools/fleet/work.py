"""One piece of work: a log replayed by one version of the program with one configuration. Its key is the hash of these three, its
record a file of that name, so that a piece is done once however often it is started, by whomever."""

import contextlib
import fcntl
import json
import os
import pathlib
import platform
import shutil
import signal
import subprocess
import tempfile
import time

import fsspec

from logs import digest, digest_of_file, digest_of_log  # functions: a worker gets them with this file's own

ATTEMPTS = 3  # a replay that is killed from outside (memory, an operator) is begun again; one that dies each time is a finding
FOLDER = "segcal_fleet_"  # of a replay, below the folder for temporary files
UNLOCKED_S = 60  # a folder that is made is locked at once; one without a lock that is older is a killed run's
STOPPING = []  # not empty: Ctrl-C or SIGTERM came, no further replay is begun. A list: what is sent to a worker holds no locks


class Store:
    """Records below TABLES/work, on any file system that fsspec knows."""

    def __init__(self, tables):
        self.fs, self.root = fsspec.core.url_to_fs(tables)

    def path(self, key):
        return "/".join((self.root, "work", key[:2], f"{key}.json"))

    def read(self, key):
        """None where there is none, or half of one."""
        try:
            return json.loads(self.fs.cat_file(self.path(key)))
        except (FileNotFoundError, json.JSONDecodeError):
            return None

    def write(self, key, record):
        """Whole or not at all: object stores put a file at once, a local file is renamed."""
        path = self.path(key)
        self.fs.makedirs(os.path.dirname(path), exist_ok=True)
        text = json.dumps(record).encode()
        if "file" not in self.fs.protocol:
            self.fs.pipe_file(path, text)
            return
        temporary = f"{path}.{platform.node()}.{os.getpid()}.{time.monotonic_ns()}"
        self.fs.pipe_file(temporary, text)
        os.replace(temporary, path)


def number_after(options, name, default):
    return int(options[options.index(name) + 1]) if name in options else default


def digest_of_options(options):
    """Options as they are; files among them by content."""
    parts = [f"file:{digest_of_file(o)}" if os.path.isfile(o) else o for o in options]
    return digest(json.dumps(parts).encode())


def key_of(log, version, options):
    cameras = number_after(options, "--cameras", 1)
    return digest(f"{digest_of_log(log, cameras)}\n{version}\n{digest_of_options(options)}\n".encode())


def remove_abandoned():
    """Folders of replays whose fleet was killed: nobody holds their lock."""
    for folder in pathlib.Path(tempfile.gettempdir()).glob(f"{FOLDER}*"):
        with contextlib.suppress(OSError):  # locked, another user's, or gone in the meantime
            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if time.time() - folder.stat().st_mtime > UNLOCKED_S:
                    shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(handle)


@contextlib.contextmanager
def temporary_folder():
    """(path, handle that holds its lock, for processes that write to it)."""
    with tempfile.TemporaryDirectory(prefix=FOLDER) as folder:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(handle, fcntl.LOCK_SH)
            yield folder, handle
        finally:
            os.close(handle)


def replay(program, log, options):
    """(exit code, result or None, last line of the error output). A negative code: the process was killed."""
    with temporary_folder() as (folder, lock):
        # A state that a device's log begins with holds the logs before it, which would count twice.
        command = [program, "replay", log, "--without-state", *options, "--out", folder]
        for _ in range(ATTEMPTS):
            done = subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL, pass_fds=[lock])
            if done.returncode >= 0 or done.returncode == -signal.SIGINT or STOPPING:
                break
        file = pathlib.Path(folder) / "result.json"
        result = json.loads(file.read_text()) if file.exists() else None
        lines = done.stderr.strip().splitlines()
        return done.returncode, result, lines[-1] if lines and result is None else ""


def record_of(program, log, options):
    begun = time.time()
    code, result, error = replay(program, log, options)
    if code < 0 or (result is None and code != 2):
        return {"log": log, "exit_code": code, "error": error or f"segcal replay was killed by signal {-code}", "unfinished": True}
    times = {"begun": begun, "seconds": time.time() - begun, "host": platform.node()}
    if result is not None:
        times.update(result.pop("timing", {}))
        result.pop("memory", None)
    return {"exit_code": code, "error": error, "result": result, "times": times}


def run_batch(program, version, options, tables, batch, again):
    """Does what has not been done of these logs. One entry each: {log, key} and what went wrong with it, if anything."""
    store, entries = Store(tables), []
    remove_abandoned()
    for log in batch:
        if STOPPING:
            break
        try:
            key = key_of(log, version, options)
        except OSError as error:
            entries.append({"log": log, "error": str(error), "unfinished": True})
            continue
        before = store.read(key)
        entry = {"log": log, "key": key, "new": before is None}
        if before is None or again:
            record = record_of(program, log, options)
            if record.get("unfinished"):
                entries.append({**entry, **record})
                continue
            entry["other_bits"] = before is not None and hash_of(before) != hash_of(record)
            if before is None:
                store.write(key, record)
        entries.append(entry)
    return entries


def hash_of(record):
    return (record["result"] or {}).get("result_hash")
