"""Runs one of the program's Python scripts: run_script.py SCRIPT ARGUMENT...

What a script did not foresee (a file that is not what its name says, a full disk, a closed pipe) ends with one line on stderr and
exit code 2, like what it did. SEGCAL_DEBUG=1 in the environment shows Python's own account of it."""

import os
import runpy
import sys
import traceback


def words_of(error, script):
    if isinstance(error, OSError) and not error.filename:
        return f"standard output: cannot be written: {error.strerror or error}"
    if isinstance(error, OSError):
        return f"{error.filename}: {error.strerror or error}"
    if isinstance(error, ImportError):
        return f"the Python package '{error.name}' is missing; host_tools/setup.sh installs it"
    frames = traceback.extract_tb(error.__traceback__)
    place = next((f"{os.path.basename(f.filename)}:{f.lineno}" for f in reversed(frames) if os.path.dirname(script) in f.filename), script)
    return f"input that {place} cannot use: {type(error).__name__}: {error} (SEGCAL_DEBUG=1 shows more)"


def main():
    script = sys.argv[1]
    sys.argv = sys.argv[1:]
    sys.path[0] = os.path.dirname(script)
    sys.path.insert(1, os.path.join(os.path.dirname(os.path.abspath(__file__)), "common"))
    code = 0
    try:
        try:
            runpy.run_path(script, run_name="__main__")
        except SystemExit as end:
            if isinstance(end.code, str):
                raise
            code = end.code or 0
        sys.stdout.flush()
    except KeyboardInterrupt:
        print("segcal: interrupted", file=sys.stderr)
        code = 2
    except Exception as error:
        if os.environ.get("SEGCAL_DEBUG"):
            traceback.print_exc()
        print("segcal: " + " ".join(words_of(error, script).split()), file=sys.stderr)
        code = 2
    if code == 2:  # what could not be written would be tried again at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(code)


if __name__ == "__main__":
    main()
