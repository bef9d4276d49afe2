"""segcal fleet: many logs through one program, fused per device and per model. Called by the program, which says where it is."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small, and the cores are busy with replays

import argparse
import collections
import functools
import pathlib
import signal
import subprocess
import sys
import tempfile

import execution
import judge
import logs
import output_run
import tables
import work

EPILOG = """examples:
  segcal fleet logs/ --out tables                              this machine's cores
  segcal fleet @list.txt --out s3://bucket/tables --scheduler tcp://head:8786
  segcal fleet logs/ --out tables --shard 3/16                 one of 16 jobs of a batch array; then once without --shard
  segcal fleet logs/ --out tables -- --segments 12 --enable time_offset     options of `segcal replay`, behind --

Logs of a device are told by device_id in REC/device.yaml (docs/formats.md), or by --devices 'fleet/(?P<model>\\w+)/(?P<device>\\w+)/'.
A log is replayed once per library version and configuration; after an interruption the same command continues where it stopped. The tables and
queries for them: docs/fleet.md.

Exit code 1: some logs gave no result, or --again found other bits; 2: bad usage or input."""


NEGATIVE = 3  # exit code that the program turns into 1: Python itself ends with 1 after an error of its own


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise logs.InputError(f"{message} (see segcal fleet --help)")

    def print_help(self, file=None):
        """argparse's own takes a full disk for a success."""
        (file or sys.stdout).write(self.format_help())
        sys.stdout.flush()


def shard(text):
    try:
        i, n = map(int, text.split("/"))
    except ValueError:
        i, n = -1, 0
    if not 0 <= i < n:
        raise argparse.ArgumentTypeError(f"expected i/n with 0 <= i < n, found {text}")
    return i, n


def positive(text):
    if not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text}")
    return int(text)


def parsed(arguments):
    options = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    p = Parser(prog="segcal fleet", description="Replays many logs and fuses their results per device and per model.", epilog=EPILOG,
               formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("logs", nargs="+", metavar="LOG", help="recordings, device logs (*.segcal), folders of them, or @FILE with one path a line")
    p.add_argument("--out", required=True, metavar="TABLES", help="folder of the tables: a path, or any address that fsspec knows")
    p.add_argument("--devices", metavar="REGEX", help="device (and model) in a log's path, as groups (?P<device>) and (?P<model>)")
    p.add_argument("--jobs", type=positive, help="replays at a time on this machine (default: its cores)")
    p.add_argument("--scheduler", metavar="ADDRESS", help="of Dask distributed: its workers do the work; they see the same paths")
    p.add_argument("--shard", type=shard, metavar="i/n", help="only every n-th log, from the i-th; writes no tables")
    p.add_argument("--batch", type=positive, help="logs per task (default: by the number of workers, at most 100)")
    p.add_argument("--again", action="store_true", help="replay finished logs again, and compare the result hashes")
    p.add_argument("--program", default=os.environ.get("SEGCAL_PROGRAM"), help="the segcal program on the workers (default: this one)")
    p.add_argument("--version", default=os.environ.get("SEGCAL_PROGRAM_VERSION", ""), help=argparse.SUPPRESS)
    a = p.parse_args(arguments)
    a.options = one_word_each(options)
    return a


OWNED = "--out", "--json", "--hash", "--verify-hash"  # fleet's own
FILES = "--config", "--priors", "--calib", "--model"


def one_word_each(options):
    """`--name=value` as `--name value`: what is behind a name decides what a log's key is."""
    return [part for o in options for part in (o.split("=", 1) if o.startswith("--") else [o])]


def check_options(options, program):
    """Found here, not in ten thousand replays."""
    for name in OWNED:
        if name in options:
            raise logs.InputError(f"{name} behind --: segcal fleet uses it itself")
    if "--state" in options:
        raise logs.InputError("--state behind --: replays run at the same time, and a fleet fuses a device's logs itself")
    if not options or not pathlib.Path(program).exists():  # on a cluster it may be on the workers alone
        return
    with tempfile.TemporaryDirectory() as folder:
        nowhere = f"{folder}/none"  # the options are read before it is missed
        said = subprocess.run([program, "replay", nowhere, *options, "--out", f"{folder}/out"], capture_output=True, text=True, check=False).stderr.strip()
    if nowhere not in said:
        raise logs.InputError(f"options behind --: {said.removeprefix('segcal: ')}")
    for name, value in zip(options, options[1:]):
        if name in FILES and not pathlib.Path(value).is_file():
            raise logs.InputError(f"{name} {value}: no such file")
        if name in FILES:
            output_run.check_file(value)


def store_of(tables):
    protocol = tables.split("://")[0]
    try:
        return work.Store(tables)
    except ImportError as error:  # its words name the package; fsspec's own, and raised without a name
        words = str(error).replace("Install ", "install ")
        raise logs.InputError(f"--out {tables}: {words} into the environment of {sys.executable}") from None
    except ValueError:
        raise logs.InputError(f"--out {tables}: expected a path or an address that fsspec knows, found the protocol '{protocol}'") from None


def complain_of(entries):
    """One line each for what gave no record or other bits."""
    bad = 0
    for entry in entries:
        if entry.get("unfinished"):
            print(f"segcal fleet: {entry['log']}: {entry['error']}", file=sys.stderr)
            bad += 1
        elif entry.get("other_bits"):
            print(f"segcal fleet: {entry['log']}: another result hash than before", file=sys.stderr)
            bad += 1
    return bad


def sentences(rows, dispersion):
    """How it went: for the terminal and for the top of the page."""
    status = [row["status"] for row in rows["runs"]]
    counts = ", ".join(f"{status.count(s)} {s}" for s in ("calibrated", "insufficient", "failed", "refused") if s in status)
    named = {row["device"] for row in rows["attention"] if row["kind"] in ("change", "outlier", "misfit")}
    return [f"{len(status)} logs of {len({row['device'] for row in rows['runs']})} devices: {counts}",
            f"Logs of a device disagree by {dispersion:.2f} times their noise (chi2/dof, median over devices)",
            f"{len(named)} devices to look at" if named else "No device stands out"]


def write_report(store, rows, said):
    sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "report"))
    import fleet_page
    html = fleet_page.render(rows, said).encode()
    output_run.write_whole(store.fs, f"{store.root}/report.html", lambda file: file.write(html))


def summarise(rows, said, out):
    named = [row for row in rows["attention"] if row["kind"] in ("change", "outlier", "misfit")]
    print("\n".join(said) + (":" if named else ""))
    for row in named[:judge.WORST]:
        print(f"  {row['device']}: {row['sentence']}")
    for words, first, count in reasons(rows):
        print(f"  {count} refused: {words}" + ("" if first in words else f" ({first})"))
    print(f"tables and report.html in {out}")


def reasons(rows):
    """[(why, first log, how many)] of the logs that were refused, the most frequent first, three at most; paths do not make two of one."""
    groups = collections.OrderedDict()
    for row in rows["runs"]:
        if row["status"] == "refused":
            groups.setdefault((row["error"] or "").replace(row["log"], ""), []).append(row)
    ordered = sorted(groups.values(), key=len, reverse=True)[:3]
    return [(own[0]["error"].removeprefix("segcal: "), own[0]["log"], len(own)) for own in ordered]


def interrupted(*_):
    raise KeyboardInterrupt


def run(arguments):
    a = parsed(arguments)
    check_options(a.options, a.program)
    paths = [str(path) for path in logs.find_logs(a.logs)]
    if not paths:
        raise logs.InputError(f"{' '.join(a.logs)}: no logs in it")
    if a.devices:
        for path in paths:
            logs.device_of(path, None, a.devices)
    if a.shard:
        paths = paths[a.shard[0]::a.shard[1]]
    if "://" not in a.out:
        a.out = os.path.abspath(a.out)  # workers have another working directory
    store = store_of(a.out)
    output_run.expect_folder(store.fs, store.root, "fleet")
    task = functools.partial(work.run_batch, a.program, a.version, a.options, a.out, again=a.again)
    entries = execution.run_all(paths, task, a.scheduler, a.jobs, a.batch)
    bad = complain_of(entries)
    if a.shard:
        print(f"{len(paths) - bad} of {len(paths)} logs of shard {a.shard[0]}/{a.shard[1]} are done; the same command without --shard makes the tables",
              file=sys.stderr)
        return NEGATIVE if bad else 0
    runs = judge.runs_of([e for e in entries if not e.get("unfinished")], store, a.devices)
    rows, dispersion = judge.rows_of_fleet(runs)
    tables.write_tables(store.fs, store.root, rows)
    said = sentences(rows, dispersion)
    write_report(store, rows, said)
    summarise(rows, said, a.out)
    return NEGATIVE if bad or any(run.record["result"] is None for run in runs) else 0


def main():
    signal.signal(signal.SIGTERM, interrupted)
    try:
        return run(sys.argv[1:])
    except logs.InputError as error:
        print(f"segcal: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("segcal: interrupted; the same command goes on where it was stopped", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
