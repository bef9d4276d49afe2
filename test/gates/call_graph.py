#!/usr/bin/env python3
"""Proves the worst stack of the C API from the call graph that GCC writes (-fcallgraph-info=su,da): no recursion, no frame
of variable size, no indirect call. Functions without a graph (libgcc, the C library) are read from the linked image.

usage: call_graph.py --graphs FOLDER [--image ELF --objdump OBJDUMP] [--assume NAME=BYTES]... [--limit BYTES] [--json FILE]
                     [--roots PREFIX] [--callbacks REGEX]
Exit code 0: proven and within the limit, 1: not (each reason is named), 2: nothing to read."""
import argparse
import json
import pathlib
import re
import subprocess
import sys

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "((?:[^"\\]|\\.)*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
FRAME = re.compile(r"(\d+) bytes \(([^)]*)\)")


def name_of(title):
    """Functions of a file are titled "file:name"."""
    return title.split(":")[-1]


class Graph:
    def __init__(self):
        self.frame, self.dynamic, self.calls = {}, set(), {}

    def add_file(self, path):
        for line in path.read_text().splitlines():
            if node := NODE.match(line):
                if frame := FRAME.search(node[2]):
                    self.add(name_of(node[1]), int(frame[1]), frame[2].startswith("dynamic") and "bounded" not in frame[2])
            elif edge := EDGE.match(line):
                self.calls.setdefault(name_of(edge[1]), set()).add(name_of(edge[2]))

    def add(self, name, size, dynamic):
        """An inline function may be in several objects, the linker keeps one of them: the largest counts."""
        self.frame[name] = max(size, self.frame.get(name, 0))
        if dynamic:
            self.dynamic.add(name)

    def resolve(self, name):
        """The constructor's and destructor's second name stands for the same code; clones carry a suffix in the object."""
        for other in (name, name.replace("C1E", "C2E"), name.replace("D1E", "D2E")):
            if other in self.frame:
                return other
        return name


REGISTERS = re.compile(r"\{([^}]*)\}")


def pushed_bytes(opcode, operands):
    """Bytes that one Thumb instruction takes from the stack; None if that cannot be said."""
    def count(text, size):
        total = 0
        for part in REGISTERS.search(text)[1].replace(" ", "").split(","):
            ends = [int(n) for n in re.findall(r"\d+", part)]
            total += ends[1] - ends[0] + 1 if "-" in part else 1
        return total * size

    op = opcode.split(".")[0]
    if op == "push" or (op.startswith("stmdb") and operands.startswith("sp!")):
        return count(operands, 4)
    if op == "vpush":
        return count(operands, 8 if "d" in REGISTERS.search(operands)[1] else 4)
    if op in ("sub", "subw") and re.match(r"sp,", operands):
        value = re.search(r"#(\d+)", operands)
        return int(value[1]) if value else None
    if taken := re.search(r"\[sp, #-(\d+)\]!", operands):
        return int(taken[1])
    if re.match(r"sp,", operands) and op in ("mov", "msr", "bic"):
        return None
    return 0


def leaves(opcode, operands):
    """Whether nothing after this instruction runs: a jump, a return, or data behind the code."""
    op = opcode.split(".")[0]
    return op in ("b", "bx", "tbb", "tbh", "udf", "bkpt") or opcode.startswith(".") or "pc" in operands


class Image:
    """Frames and calls of functions in a linked Thumb image."""

    def __init__(self, path, objdump):
        def lines(*options):
            return subprocess.run([objdump, *options, path], check=True, capture_output=True, text=True).stdout.splitlines()

        self.body, self.follows, name, at = {}, {}, None, {}
        for line in lines("-d", "--no-show-raw-insn"):
            if start := re.match(r"([0-9a-f]+) <([^>]+)>:", line):
                self.follows[name] = start[2]
                name = at[int(start[1], 16)] = start[2]
                self.body[name] = []
            elif name and (code := re.match(r"\s*[0-9a-f]+:\s+(\S+)\s*(.*)", line)):
                self.body[name].append((code[1], code[2]))
        # A function may have several names, of which the listing shows one: __aeabi_dadd is __adddf3.
        for line in lines("-t"):
            symbol = re.match(r"([0-9a-f]+) .*\s(\S+)$", line)
            if symbol and symbol[2] not in self.body and (shown := at.get(int(symbol[1], 16))):
                self.body[symbol[2]], self.follows[symbol[2]] = self.body[shown], self.follows.get(shown)

    def add_to(self, graph, name):
        """All that the function pushes, whichever way it takes: an upper bound."""
        size, dynamic, calls = 0, False, set()
        for opcode, operands in self.body[name]:
            taken = pushed_bytes(opcode, operands)
            dynamic |= taken is None
            size += taken or 0
            target = re.search(r"<([^>+]+)(\+0x[0-9a-f]+)?>", operands)
            if re.match(r"(b|bl|blx|b\.\w+|b[a-z]{2}(\.\w)?)$", opcode) and target and target[1] != name:
                calls.add(target[1])
            elif opcode == "blx":
                calls.add("__indirect_call")
        code = [line for line in self.body[name] if line[0].split(".")[0] != "nop"]  # without padding
        if code and not leaves(*code[-1]) and self.follows.get(name):
            calls.add(self.follows[name])  # it runs on into the next one, as __aeabi_dsub does
        graph.add(name, size, dynamic)
        graph.calls[name] = calls


class Proof:
    def __init__(self, graph, image, assumed, callbacks):
        self.graph, self.image, self.assumed = graph, image, assumed
        self.callbacks = re.compile(callbacks) if callbacks else None
        self.problems, self.deepest = set(), {}

    def depth(self, name, path=()):
        """Bytes from a function on down, and the way there."""
        graph = self.graph
        name = graph.resolve(name)
        if name in path:
            self.problems.add("recursion: " + " -> ".join(path[path.index(name):] + (name,)))
            return 0, ()
        if name in self.deepest:
            return self.deepest[name]
        if name in self.assumed:
            return self.assumed[name], ((name, self.assumed[name]),)
        if name == "__indirect_call":
            if not self.callbacks or not self.callbacks.search(path[-1]):
                self.problems.add(f"indirect call from {path[-1]}")
            return 0, ()
        if name not in graph.frame:
            if not self.image or name not in self.image.body:
                self.problems.add(f"no frame is known of {name}, called from {path[-1] if path else 'outside'}")
                return 0, ()
            self.image.add_to(graph, name)
        if name in graph.dynamic:
            self.problems.add(f"frame of variable size: {name}")
        below = max((self.depth(c, path + (name,)) for c in sorted(graph.calls.get(name, ()))), key=lambda d: d[0], default=(0, ()))
        self.deepest[name] = (graph.frame[name] + below[0], ((name, graph.frame[name]),) + below[1])
        return self.deepest[name]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graphs", required=True, help="folder with .ci files, searched in depth")
    parser.add_argument("--image", help="linked image, for functions without a graph")
    parser.add_argument("--objdump", default="objdump")
    parser.add_argument("--assume", action="append", default=[], metavar="NAME=BYTES")
    parser.add_argument("--callbacks", help="functions that may call what the user gave them; that stack is the user's")
    parser.add_argument("--limit", type=int)
    parser.add_argument("--json")
    parser.add_argument("--roots", default="segcal_")
    return parser.parse_args()


def main():
    args = arguments()
    graph = Graph()
    for path in sorted(pathlib.Path(args.graphs).rglob("*.ci")):
        graph.add_file(path)
    roots = sorted(name for name in graph.frame if name.startswith(args.roots))
    if not roots:
        sys.exit(print(f"{args.graphs}: no call graph of a function {args.roots}*") or 2)
    image = Image(args.image, args.objdump) if args.image else None
    proof = Proof(graph, image, {k: int(v) for k, v in (a.split("=") for a in args.assume)}, args.callbacks)
    depth = {root: proof.depth(root) for root in roots}
    worst = max(roots, key=lambda root: depth[root][0])
    total, path = depth[worst]
    for name, size in path:
        print(f"{size:8d}  {name[:150]}")
    print(f"worst stack: {total} bytes, from {worst}; {len(roots)} entry points, {len(proof.deepest)} functions")
    for problem in sorted(proof.problems):
        print("NOT PROVEN:", problem)
    over = args.limit is not None and total > args.limit
    if over:
        print(f"over the limit of {args.limit} bytes")
    if args.json:
        result = {"bytes": total, "proven": not proof.problems, "root": worst, "path": [list(p) for p in path]}
        pathlib.Path(args.json).write_text(json.dumps(result, indent=1) + "\n")
    sys.exit(1 if proof.problems or over else 0)


if __name__ == "__main__":
    main()
