"""Writes DIR/report.html from the files that `segcal replay`, `segcal diagnose` or `segcal allan` left in DIR.

Usage: report.py DIR. Exit code 0 when the page is written, 2 with one line on stderr when the input cannot be used.
"""

import json
import os
import sys
from pathlib import Path

from input_error import InputError


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


def calibration_lines(file):
    if not file.exists():
        return []
    import history
    try:
        return history.parse_lines(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise InputError(f"{file}: expected a JSON object on each line") from None


def replay_page(folder, name):
    import replay_page as page
    result = read_json(folder / "result.json", required=True)
    check_result(result, folder / "result.json")
    data = read_json(folder / "report_data.json", required=False)
    return page.render(name, result, data, calibration_lines(folder / "calibration.jsonl"))


def diagnosis_page(folder, name):
    import gap
    diagnosis = read_json(folder / "diagnosis.json", required=True)
    check_diagnosis(diagnosis, folder / "diagnosis.json")
    return gap.render(name, diagnosis, read_json(folder / "diagnosis_data.json", required=False),
                      read_json(folder / "twin.json", required=False))


def allan_page(folder, name):
    import allan
    return allan.render(name, read_json(folder / "allan.json", required=True))


# By the file that tells who wrote the folder; the first that is there.
PAGES = {"diagnosis.json": diagnosis_page, "allan.json": allan_page, "result.json": replay_page}


def rendered(folder):
    file = next((name for name in PAGES if (folder / name).exists()), "result.json")
    try:
        return PAGES[file](folder, folder.resolve().name)
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise InputError(f"{folder / file}: not what `segcal` writes ({type(error).__name__}: {error})") from None
    except ImportError as error:
        raise InputError(f"the Python package '{error.name}' is missing; host_tools/setup.sh installs it") from None


def write_whole(file, text):
    """The old file or the new one is there, never a part."""
    temporary = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, file)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise InputError(f"{file}: {error.strerror}") from None


def main(arguments):
    if len(arguments) != 1:
        raise InputError("expected one argument, the folder that `segcal replay`, `diagnose` or `allan` wrote")
    folder = Path(arguments[0])
    write_whole(folder / "report.html", rendered(folder))
    print(f"wrote {folder / 'report.html'}", file=sys.stderr)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print("segcal: " + " ".join(str(error).split()), file=sys.stderr)
        sys.exit(2)
