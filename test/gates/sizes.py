"""What a reader can take in at a time: no file of lib/src and host_tools/src is longer than 250 lines, no function of lib/src longer than 40. Longer
ones are split along ideas, with a name for each; a file in EXCEPTIONS may only shrink, and leaves the list when it is short enough.
Usage: sizes.py SOURCE_TREE"""

import pathlib
import re
import sys

MOST_LINES, MOST_FUNCTION_LINES = 250, 40
EXCEPTIONS = {}
# The last line of a function's head, as clang-format leaves it: "...) const {", "...) : a_(a), b_(b) {".
HEAD_END = re.compile(r"^( *)\S.*\)(?: const| noexcept| override| final| -> [\w:<>]+)*(?: :.*)? \{$|^( *)(?: {4}): .* \{$")
NO_FUNCTION = re.compile(r"^\s*(?:if|for|while|switch|\} else|else|do|namespace|struct|class|union|enum|extern|return|case|SEGCAL_\w+)\b|\]\([^)]*\)[^{]*\{$")


def functions(lines):
    """(first line, number of lines) of each function that has more than one."""
    for last_of_head, line in enumerate(lines):
        if not HEAD_END.match(line) or NO_FUNCTION.search(line):
            continue
        first = last_of_head
        while first > 0 and lines[first].count(")") > lines[first].count("("):
            first -= 1
        if NO_FUNCTION.search(lines[first]):
            continue
        indent = re.match(" *", lines[first])[0]
        for end in range(last_of_head + 1, len(lines)):
            if lines[end].startswith(indent + "}"):
                yield first, end - first + 1
                break


def main():
    root = pathlib.Path(sys.argv[1])
    bad, seen, found = [], set(), 0
    for folder in "lib/src", "host_tools/src":
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            name, lines = file.relative_to(root).as_posix(), file.read_text(encoding="utf-8").splitlines()
            most = EXCEPTIONS.get(name, MOST_LINES)
            if len(lines) > most:
                bad.append(f"{name}: {len(lines)} lines, at most {most}")
            if name in EXCEPTIONS:
                seen.add(name)
                if len(lines) <= MOST_LINES:
                    bad.append(f"{name}: {len(lines)} lines: short enough, take it off the list of exceptions")
            for first, count in functions(lines) if folder == "lib/src" else []:
                found += 1
                if count > MOST_FUNCTION_LINES:
                    bad.append(f"{name}:{first + 1}: a function of {count} lines, at most {MOST_FUNCTION_LINES}")
    bad += [f"{name}: an exception that no file needs" for name in EXCEPTIONS if name not in seen]
    print("\n".join(bad) if bad else f"{found} functions of several lines and all files are short enough")
    return 1 if bad or found < 500 else 0  # fewer: the functions were not found


if __name__ == "__main__":
    sys.exit(main())
