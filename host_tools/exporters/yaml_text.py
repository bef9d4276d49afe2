"""YAML lines with all digits of a number."""


def number(value):
    """Shortest text that reads back to the same. YAML 1.1 (PyYAML, so Kalibr) takes 2e-05 for a word: 2.0e-05."""
    text = repr(float(value))
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def row(values):
    return "[" + ", ".join(map(number, values)) + "]"


def matrix(name, rows, indent="  "):
    return f"{indent}{name}:\n" + "".join(f"{indent}- {row(r)}\n" for r in rows)
