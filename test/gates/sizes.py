"""What a reader can take in at a time: no file of lib and host_tools/src is longer than 250 lines; functions of lib have a median, a 90 % quantile and
a largest length as in FUNCTION_LINES. Longer ones are split along ideas, with a name for each. Lengths are lizard's, heads included.
Usage: sizes.py SOURCE_TREE, or sizes.py --self-test: the kinds of functions that have once been missed are found."""

import pathlib
import statistics
import sys

import lizard

MOST_LINES = 250
FUNCTION_LINES = {"median": 6, "90 % quantile": 18, "largest": 40}
LEAST_FUNCTIONS = 1000  # fewer: they were not found
HIDING = """
auto a(int x) -> std::pair<int, int> {
  return {x,
          x};
}
struct K {
  K(int x)
      : x_(x),
        y_(x) {
  }
  int b() & {  // why
    return 1;
  }
};
struct P c(int x) {
  return {x};
}
enum E d(int x) {
  return E(x);
}
extern "C" [[gnu::cold]] int e(int x) {
  return x;
}
"""


def functions(file, text):
    """(name, first line, number of lines)"""
    return [(f.name, f.start_line, f.end_line - f.start_line + 1) for f in lizard.analyze_file.analyze_source_code(str(file), text).function_list]


def self_test():
    found = {(name.split("::")[-1], count) for name, _, count in functions("hiding.cpp", HIDING)}
    wanted = {("a", 4), ("K", 4), ("b", 3), ("c", 3), ("d", 3), ("e", 3)}
    print("not found:", wanted - found) if wanted - found else None
    return 1 if wanted - found else 0


def main():
    root, bad, lengths = pathlib.Path(sys.argv[1]), [], []
    for folder in "lib/include", "lib/src", "host_tools/src":
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".hpp", ".cpp"):
                continue
            name, text = file.relative_to(root).as_posix(), file.read_text(encoding="utf-8")
            lines = text.count("\n")
            if lines > MOST_LINES and not folder.endswith("include"):  # a public header is one page of reference
                bad.append(f"{name}: {lines} lines, at most {MOST_LINES}")
            for function, first, count in functions(file, text) if folder.startswith("lib") else []:
                lengths.append(count)
                if count > FUNCTION_LINES["largest"]:
                    bad.append(f"{name}:{first}: {function} has {count} lines, at most {FUNCTION_LINES['largest']}")
    measured = {"median": statistics.median(lengths), "90 % quantile": statistics.quantiles(lengths, n=10)[-1], "largest": max(lengths)}
    bad += [f"functions of lib: {what} of {measured[what]:g} lines, at most {most}" for what, most in FUNCTION_LINES.items() if measured[what] > most]
    if len(lengths) < LEAST_FUNCTIONS:
        bad.append(f"only {len(lengths)} functions found")
    print("\n".join(bad) if bad else f"{len(lengths)} functions, lines: " + ", ".join(f"{what} {count:g}" for what, count in measured.items()))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(self_test() if sys.argv[1] == "--self-test" else main())
