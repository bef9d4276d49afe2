"""Writes DIR/report.html from the files that `segcal replay` or `segcal diagnose` left in DIR.

Usage: report.py DIR. Exit code 0 when the page is written, 2 with one line on stderr when the input cannot be used.
"""

import json
import os
import sys
from pathlib import Path


class InputError(Exception):
    """What is wrong with which file, in one line."""


def read_json(file, required):
    """The object in `file`; an empty one if the file is absent and not required."""
    if not file.exists() and not required:
        return {}
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{file}: file is missing; `segcal replay` writes it") from None
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{file}:{error.lineno}: expected JSON, {error.msg}") from None
    except UnicodeDecodeError:
        raise InputError(f"{file}: expected UTF-8 text") from None
    if not isinstance(content, dict):
        raise InputError(f"{file}: expected a JSON object")
    return content


def check_result(result, file):
    """The few members without which there is nothing to report."""
    if result.get("format", 1) not in (1, 2):
        raise InputError(f"{file}: expected format 1 or 2, found {result['format']}")
    if not isinstance(result.get("status"), str):
        raise InputError(f"{file}: expected a member \"status\" with a text")
    parameters = result.get("parameters")
    named = isinstance(parameters, list) and all(isinstance(p, dict) and "name" in p for p in parameters)
    if not named:
        raise InputError(f"{file}: expected a member \"parameters\" with a list of {{name, value, sigma, ...}}")


def check_diagnosis(diagnosis, file):
    if diagnosis.get("format", 1) not in (1, 2):
        raise InputError(f"{file}: expected format 1 or 2, found {diagnosis['format']}")
    if not isinstance(diagnosis.get("verdict"), str):
        raise InputError(f"{file}: expected a member \"verdict\" with a text")


def rendered(folder):
    """The gap page where there is a diagnosis, else the page of a calibration."""
    file = folder / "diagnosis.json"
    if file.exists():
        diagnosis = read_json(file, required=True)
        check_diagnosis(diagnosis, file)
        import gap
        return gap.render(folder.resolve().name, diagnosis, read_json(folder / "diagnosis_data.json", required=False))
    result = read_json(folder / "result.json", required=True)
    check_result(result, folder / "result.json")
    data = read_json(folder / "report_data.json", required=False)
    import page
    return page.render(folder.resolve().name, result, data)


def write_whole(file, text):
    """The old file or the new one is there, never a part."""
    temporary = file.with_name(file.name + ".tmp")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, file)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise InputError(f"{file}: {error.strerror}") from None


def main(arguments):
    if len(arguments) != 1:
        raise InputError("expected one argument, the folder that `segcal replay` or `segcal diagnose` wrote")
    folder = Path(arguments[0])
    try:
        text = rendered(folder)
    except ImportError as error:
        raise InputError(f"the Python package '{error.name}' is missing; host_tools/setup.sh installs it") from None
    write_whole(folder / "report.html", text)
    print(f"wrote {folder / 'report.html'}", file=sys.stderr)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print(f"segcal: {error}", file=sys.stderr)
        sys.exit(2)
