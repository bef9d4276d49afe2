"""Every file of C and C++ is as clang-format leaves it. Exit code 77, skipped: no clang-format of the version that
host_tools/setup.sh installs (others break lines elsewhere).
Usage: clang_format.py SOURCE_TREE, or clang_format.py --self-test: a file that is not formatted is found."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

VERSION = "14"
FOLDERS = "cmake", "examples", "host_tools", "lib", "port", "python", "test"
SUFFIXES = ".c", ".cc", ".cpp", ".h", ".hpp"
LEAST_FILES = 500  # fewer: they were not found
SKIPPED = 77


def unformatted(files):
    done = subprocess.run(["clang-format", "--dry-run", "--Werror", *map(str, files)], capture_output=True, text=True)
    found = sorted(set(re.findall(r"^(.*?):\d+:\d+: error: code should be clang-formatted", done.stderr, re.MULTILINE)))
    if done.returncode != 0 and not found:
        sys.exit(f"clang-format failed: {done.stderr.strip()[:500]}")
    return found


def self_test(root):
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(root / ".clang-format", folder)
        good, bad = pathlib.Path(folder, "good.h"), pathlib.Path(folder, "bad.h")
        good.write_text("int one() { return 1; }\n")
        bad.write_text("int one( ){ return 1;}\n")
        return 0 if unformatted([good, bad]) == [str(bad)] else 1


def main(root):
    files = [f for folder in FOLDERS for f in sorted((root / folder).rglob("*")) if f.suffix in SUFFIXES]
    if len(files) < LEAST_FILES:
        print(f"only {len(files)} files found")
        return 1
    bad = unformatted(files)
    for file in bad:
        print(f"{file}: not formatted: clang-format -i {file}")
    print(f"{len(files)} files, {len(bad)} of them not formatted")
    return 1 if bad else 0


if __name__ == "__main__":
    version = shutil.which("clang-format") and subprocess.run(["clang-format", "--version"], capture_output=True, text=True).stdout
    if not version or f"version {VERSION}." not in version:
        print(f"skipped: clang-format {VERSION} is not installed: host_tools/setup.sh installs it")
        sys.exit(SKIPPED)
    here = pathlib.Path(__file__).resolve().parents[2]
    sys.exit(self_test(here) if sys.argv[1] == "--self-test" else main(pathlib.Path(sys.argv[1])))
