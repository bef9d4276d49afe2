"""What README, CONTRIBUTING and docs say of this repository: files that they name are there, options that they use exist, figures that
other files hold are the same. Usage: docs_facts.py SEGCAL SOURCE_TREE [TEXT.md...]"""

import functools
import json
import pathlib
import re
import subprocess
import sys

SEGCAL, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
TEXTS = [pathlib.Path(t) for t in sys.argv[3:]] or [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", SOURCE / "CHANGELOG.md", *sorted((SOURCE / "docs").glob("*.md"))]
ROOTS = "lib/", "host_tools/", "test/", "docs/", "fixtures/", "port/", "cmake/", "zephyr/", "python/", "examples/"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def links(text, folder):
    for target in re.findall(r"\]\((?!https?:)([^)#]+)[^)]*\)", text):
        if not (folder / target).exists():
            yield f"link to {target}: not there"


def files(text):
    """Names in backticks that begin with a folder of the repository; a * stands for anything. A test may be named without .cpp."""
    for name in re.findall(r"`([\w./*+-]+)`", text):
        if name.startswith(ROOTS) and not any(any(SOURCE.glob(name.rstrip("/") + suffix)) for suffix in ("", ".cpp")):
            yield f"{name}: no such file"


@functools.cache
def help_of(*command):
    return subprocess.run([SEGCAL, *command, "--help"], capture_output=True, text=True, check=False).stdout


def options(text):
    """Of `segcal COMMAND --option ...`, in a line of its own or in backticks; what stands behind -- is replay's."""
    calls = re.findall(r"^    \S*segcal (.*)$", text, re.M) + re.findall(r"`segcal ([^`]*)`", text)
    commands = re.findall(r"^  ([a-z]+) ", help_of(), re.M)
    for call in calls:
        command = call.split(None, 1)[0] if call.split() else ""
        if command not in commands:
            continue
        own, _, behind = call.partition(" -- ")
        for name, part in ((command, own), ("replay", behind)):
            known = OPTION.findall(help_of(name))
            yield from (f"segcal {name} {o}: no such option" for o in OPTION.findall(part.split("  # ")[0].split("   ")[0]) if o not in known)


def figures():
    """Of the README against fixtures/budget."""
    kept, limits = (json.loads((SOURCE / "fixtures/budget" / name).read_text()) for name in ("kept.json", "limits.json"))
    left = limits["limits"]["cortex-m7 mcu -O2"]["state_bytes"] - kept["cortex-m7 mcu -O2"]["state_bytes"]
    readme = (SOURCE / "README.md").read_text()
    if f"{left:,} bytes left below its limit" not in readme:
        yield f"README.md: on Cortex-M7 {left:,} bytes are left below the limit"


def fleet_tables():
    """docs/fleet.md names each table and its first columns."""
    sys.path[:0] = [str(SOURCE / "host_tools" / part) for part in ("fleet", "common")]
    import tables
    rows = dict(re.findall(r"^\| `(\w+)` \| [^|]* \| (.*) \|$", (SOURCE / "docs/fleet.md").read_text(), re.M))
    yield from (f"docs/fleet.md: table {name} is not explained" for name in tables.SCHEMAS if name not in rows)
    for name, columns in rows.items():
        yield from (f"docs/fleet.md: {name} has no column {c}" for c in re.findall(r"`(\w+)`", columns)
                    if name in tables.SCHEMAS and c not in tables.SCHEMAS[name] and c not in ("change", "outlier", "misfit", "failed", "refused", "insufficient", "parameters", "timing"))


wrong = []
for file in TEXTS:
    text = file.read_text()
    wrong += [f"{file.name}: {w}" for w in (*links(text, file.parent), *files(text), *options(text))]
if len(sys.argv) <= 3:
    wrong += [*figures(), *fleet_tables()]
sys.exit("\n".join(wrong) or 0)
