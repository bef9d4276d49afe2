"""What README, CONTRIBUTING and docs say of this repository: files that they name are there, options and struct fields that they use exist,
figures that other files hold are the same. Sections of these texts that comments of the code cite exist, and all version numbers agree.
Usage: docs_facts.py SEGCAL SOURCE_TREE [TEXT.md...]"""

import functools
import json
import pathlib
import re
import subprocess
import sys

SEGCAL, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
TEXTS = [pathlib.Path(t) for t in sys.argv[3:]] or [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", SOURCE / "CHANGELOG.md", *sorted((SOURCE / "docs").glob("*.md"))]
ROOTS = "lib/", "host_tools/", "test/", "docs/", "fixtures/", "port/", "cmake/", "zephyr/", "python/", "examples/"
CODE = ".h", ".hpp", ".cpp", ".c", ".py", ".txt", ".cmake", ".sh", ".yml", ".yaml"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
LEADER = re.compile(r"\n\s*(?://+<?|\*|#)?\s*")   # a line of a comment may end inside a citation
CITATION = re.compile(r"\b([\w-]+)\.md(?:`|\]\([^)]*\))?, ?(?:sections? ?((?:\d+(?:, | and )?)+)|(\d+)\b|[\"'“]([^\"'”]+)[\"'”])")


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


@functools.cache
def headings(name):
    """Of README, CONTRIBUTING or docs/NAME.md: numbers, and the words of headings and of paragraphs that begin in bold. None: no such file."""
    text = next((p.read_text() for p in (SOURCE / "docs" / f"{name}.md", SOURCE / f"{name}.md") if p.exists()), None)
    if text is None:
        return None
    words = re.findall(r"^#+ (.*)$", text, re.M) + re.findall(r"^(?:- )?\*\*([^*]+)\*\*", text, re.M)
    return set(re.findall(r"^## (\d+)\.", text, re.M)), [w.replace("`", "") for w in words]


def citations(text):
    """design.md, section 5; results.md, "Rough IMUs" (the beginning of a heading); also README, "Known limits"."""
    text = re.sub(r"\bREADME, (?=\")", "README.md, ", LEADER.sub(" ", text))
    for name, several, one, words in CITATION.findall(text):
        if headings(name) is None:
            continue
        numbers, begins = headings(name)
        yield from (f"{name}.md has no section {n}" for n in re.findall(r"\d+", several + one) if n not in numbers)
        if words and not any(w.startswith(words.replace("`", "")) for w in begins):
            yield f'{name}.md has no heading that begins "{words}"'
    if re.search(r"\bDESIGN\b", text):
        yield "cites DESIGN: no such document"


def code_citations():
    for root in ROOTS:
        for file in sorted((SOURCE / root).rglob("*")):
            if file.suffix in CODE and file.is_file() and not file.samefile(__file__):
                yield from (f"{file.relative_to(SOURCE)}: {w}" for w in citations(file.read_text(errors="replace")))


@functools.cache
def struct_fields():
    """{struct: fields} of the public headers."""
    fields = {}
    for header in sorted((SOURCE / "lib/include/segcal").glob("*.h")):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(), flags=re.S)
        for body, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.S):
            fields[name] = {re.findall(r"\w+", re.sub(r"\[.*?\]", "", d))[-1] for line in body.split(";") if line.strip() and "(" not in line
                            for d in line.split(",")} | set(re.findall(r"\(\*(\w+)\)", body))
    return fields


def members(text):
    for struct, field in re.findall(r"\b(segcal_\w+_t)\.(\w+)", text):
        if field not in struct_fields().get(struct, ()):
            yield f"{struct}.{field}: no such field"


def versions():
    """SEGCAL_VERSION, major and minor, is that of each package; docs/formats.md names the log's format."""
    number = int(re.search(r"#define SEGCAL_VERSION 0x(\w+)u", (SOURCE / "lib/include/segcal/segcal.h").read_text())[1], 16)
    wanted = f"{number >> 16}.{number & 0xFFFF}."
    released = {}
    for name, pattern in (("CMakeLists.txt", r"project\(segcal VERSION ([\d.]+)"), ("library.json", r'"version": "([\d.]+)"'),
                          ("python/pyproject.toml", r'^version = "([\d.]+)"'), ("python/segcal/__init__.py", r'__version__ = "([\d.]+)"'),
                          ("port/esp_idf/segcal/idf_component.yml", r'^version: "([\d.]+)"'), ("docs/formats.md", r"`segcal ([\d.]+)`"),
                          ("host_tools/src/files/manifest.h", r'"segcal ([\d.]+)"')):
        released[name] = re.search(pattern, (SOURCE / name).read_text(), re.M)[1]
    first = released["CMakeLists.txt"]
    yield from (f"{name}: version {v}, CMakeLists.txt has {first}, and segcal.h {wanted}x" for name, v in released.items()
                if v != first or not v.startswith(wanted))
    log = re.search(r"#define SEGCAL_LOG_FORMAT (\d+)", (SOURCE / "lib/include/segcal/log.h").read_text())[1]
    if f"NAME.segcal, format {log}\n" not in (text := (SOURCE / "docs/formats.md").read_text()) or f"log format {log}," not in text:
        yield f"docs/formats.md: log.h has log format {log}"


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
    wrong += [f"{file.name}: {w}" for w in (*links(text, file.parent), *files(text), *options(text), *citations(text), *members(text))]
if len(sys.argv) <= 3:
    wrong += [*figures(), *fleet_tables(), *versions(), *code_citations()]
sys.exit("\n".join(wrong) or 0)
