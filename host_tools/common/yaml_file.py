"""The one reader of YAML files: a map, or InputError that says the file and the line."""

import output_run
import yaml

from input_error import InputError


def read_yaml(file, missing="file is missing"):
    """The map in `file`, which its folder's manifest, if there is one, must know as whole. `missing`: what to say where there is none."""
    if file.exists() and not file.is_file():
        raise InputError(f"{file}: expected a regular file")
    try:
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{file}: {missing}") from None
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        raise InputError(f"{file}:{mark.line + 1 if mark else 1}: expected YAML") from None
    output_run.check_file(file)
    if not isinstance(content, dict):
        raise InputError(f"{file}:1: expected a YAML map")
    return content
