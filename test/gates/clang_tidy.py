"""clang-tidy on the lines that changed since SEGCAL_TIDY_BASE (else the last commit but one; what is not committed yet counts too), within
SECONDS. Files it did not come to are named. Exit code 77, skipped: no git history, or no clang-tidy.
Usage: clang_tidy.py SOURCE_TREE BUILD_TREE SECONDS"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

SOURCE, BUILD, SECONDS = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), float(sys.argv[3])
SKIPPED = 77
FOLDERS = "lib", "host_tools/src", "port", "python", "examples"
ROOTS = [SOURCE / folder for folder in ("lib/include", "lib/src", "host_tools/src", "port/include")]
# The database is of another compiler.
QUIET = ["--quiet", "--warnings-as-errors=*", "--extra-arg=-Wno-unknown-warning-option", "--extra-arg=-Wno-unknown-argument", "--extra-arg=-w"]


def git(*arguments):
    return subprocess.run(["git", "-C", str(SOURCE), *arguments], capture_output=True, text=True, check=False)


def changed_lines(base):
    """{file: [[first, last], ...]} of lines that were added or changed."""
    out, file = {}, None
    for line in git("diff", "-U0", "--no-color", base, "--", *FOLDERS).stdout.splitlines():
        if match := re.match(r"\+\+\+ b/(.*\.(?:cpp|c|h|hpp))$", line):
            file = match[1]
        elif line.startswith("+++"):
            file = None
        elif file and (match := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line)):
            first, count = int(match[1]), int(match[2] or 1)
            if count:
                out.setdefault(file, []).append([first, first + count - 1])
    return out


def commands():
    """Of the build, with those that are compiled as one unit (lib/CMakeLists.txt) one by one."""
    out = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        parts = [entry["file"]]
        if "/Unity/" in entry["file"]:
            parts = re.findall(r'^#include "(.*)"$', pathlib.Path(entry["file"]).read_text(), re.MULTILINE)
        for part in parts:
            out.setdefault(part, {**entry, "file": part, "command": entry["command"].replace(entry["file"], part)})
    return out


def unit_of(header, known):
    """A source in whose compilation the header is read: the nearest by includes, the core's own first."""
    includes = {}
    for folder in FOLDERS:
        for file in sorted((SOURCE / folder).rglob("*")):
            if file.suffix in (".h", ".hpp", ".c", ".cpp"):
                names = re.findall(r'^#include "(.*)"$', file.read_text(encoding="utf-8"), re.MULTILINE)
                found = (next((p for p in (root / name for root in (file.parent, *ROOTS)) if p.exists()), None) for name in names)
                includes[file.relative_to(SOURCE).as_posix()] = {p.relative_to(SOURCE).as_posix() for p in found if p}
    seen, level = {header}, [header]
    while level:
        units = [f for f in level if str(SOURCE / f) in known]
        if units:
            return min(units, key=lambda f: (not f.startswith("lib/"), f))
        level = [f for f, names in includes.items() if f not in seen and not names.isdisjoint(level)]
        seen.update(level)
    return None


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def main():
    if not shutil.which("clang-tidy"):
        skip("no clang-tidy; host_tools/setup.sh installs it")
    base = os.environ.get("SEGCAL_TIDY_BASE", "HEAD~1")
    if git("rev-parse", "--verify", "--quiet", f"{base}^{{commit}}").returncode != 0:
        skip(f"no commit {base} to compare with")
    changed = changed_lines(base)
    known = commands()
    units, unread = {}, []  # units, with the changed files that each shows
    for file in changed:
        unit = file if str(SOURCE / file) in known else unit_of(file, known)
        if unit:
            units.setdefault(unit, []).append(file)
        else:
            unread.append(file)
    database = tempfile.TemporaryDirectory()
    (pathlib.Path(database.name) / "compile_commands.json").write_text(json.dumps(list(known.values())))
    lines = json.dumps([{"name": str(SOURCE / f), "lines": spans} for f, spans in changed.items()])
    end, bad, late = time.monotonic() + SECONDS, [], []
    for unit, files in units.items():
        left = end - time.monotonic()
        try:
            done = subprocess.run(["clang-tidy", "-p", database.name, *QUIET, "--header-filter=.*", f"--line-filter={lines}", str(SOURCE / unit)], capture_output=True, text=True,
                                  check=False, timeout=max(left, 0.01))
        except subprocess.TimeoutExpired:
            late += files
            continue
        if done.returncode != 0:
            bad.append(unit)
            print(done.stdout + done.stderr)
    print(f"clang-tidy since {base}: {len(changed) - len(late) - len(unread)} of {len(changed)} changed files looked at"
          + (f"; compiled by nobody here: {', '.join(unread)}" if unread else "")
          + (f"; not within {SECONDS:.0f} s: {', '.join(late)}" if late else ""))
    sys.exit(1 if bad else 0)


main()
