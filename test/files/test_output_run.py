"""manifest.json of what Python writes (`segcal export`, `fleet`, `import`): a command that is killed at any change of the file system leaves
a folder that is whole, the old one or the new one, or one that readers refuse.
Usage: test_output_run.py SEGCAL SOURCE_TREE FOLDER"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

SEGCAL, SOURCE, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
sys.path[:0] = [*(str(SOURCE / "host_tools" / part) for part in ("common", "exporters", "fleet")), str(SOURCE / "python" / "segcal")]
import _manifest  # noqa: E402  as `segcal.read` checks a folder
import export  # noqa: E402
import fsspec  # noqa: E402
import tables  # noqa: E402

KILLED = 9


def segcal(*arguments, code=0):
    done = subprocess.run([SEGCAL, *map(str, arguments)], capture_output=True, text=True, check=False, env={**os.environ, "SEGCAL_PYTHON": sys.executable})
    assert done.returncode == code, (arguments, done.returncode, done.stderr)
    return done


def killed_at(change, work):
    """Does `work` in a process that ends without a word before its `change`-th rename or removal. True if it came so far."""
    child = os.fork()
    if child == 0:
        count = 0

        def counted(original):
            def call(*arguments, **named):
                nonlocal count
                count += 1
                if count == change:
                    os._exit(KILLED)
                return original(*arguments, **named)
            return call

        os.replace, os.remove, os.unlink = counted(os.replace), counted(os.remove), counted(os.unlink)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        work()
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert status in (0, KILLED), f"change {change}: {status}"
    return status == KILLED


def contents(folder):
    return {f.name: f.read_bytes() for f in folder.iterdir() if f.name != "manifest.json" and not f.name.endswith(".part")}


def accepted(folder):
    try:
        _manifest.check_folder(folder)
        return True
    except ValueError:
        return False


def check_killed_anywhere(name, old, new):
    """`old` and `new` write different files into a folder."""
    folder = FOLDER / name
    work = {"old": old, "new": new}
    whole = {}
    for which in work:
        shutil.rmtree(folder, ignore_errors=True)
        work[which](folder)
        assert accepted(folder)
        whole[which] = contents(folder)
    refused, change = 0, 1
    while True:
        shutil.rmtree(folder, ignore_errors=True)
        old(folder)
        if not killed_at(change, lambda: new(folder)):
            break
        if accepted(folder):
            assert contents(folder) in whole.values(), f"{name}: killed before change {change}: a mixed folder is accepted"
        else:
            refused += 1
            new(folder)  # the same again puts it right
            assert accepted(folder) and contents(folder) == whole["new"], f"{name}: after change {change}, again"
        change += 1
    assert refused >= len(whole["new"]), f"{name}: {refused} of {change - 1} kills were seen"
    assert contents(folder) == whole["new"] and not list(folder.glob(".*.part"))


def check_export():
    def exported(calibration, to):
        return lambda folder: export.main([str(FOLDER / calibration), to, str(folder)])
    check_killed_anywhere("export", exported("a", "ros"), exported("b", "ros"))
    both = FOLDER / "both"
    exported("a", "kalibr")(both)
    exported("a", "openvins")(both)
    assert accepted(both) and len(json.loads((both / "manifest.json").read_text())["runs"]) == 2
    exported("b", "kalibr")(both)
    assert accepted(both)
    segcal("export", FOLDER / "a", "--to", "ros", "--out", FOLDER / "b", code=2)  # another replay's folder
    manifest = json.loads((FOLDER / "both" / "manifest.json").read_text())
    assert [r["command"] for r in manifest["runs"]] == ["export --to openvins", "export --to kalibr"]


def check_fleet():
    def written(seed):
        rows = {"faults": [{"key": f"{seed}", "name": "imu_gaps", "count": seed}]}
        return lambda folder: tables.write_tables(*fsspec.core.url_to_fs(str(folder)), rows)
    check_killed_anywhere("fleet", written(1), written(2))
    said = segcal("fleet", FOLDER / "rec", "--out", FOLDER / "a", code=2).stderr
    assert "found the files of `segcal replay`" in said and said.count("\n") == 1, said


def check_readers():
    """`segcal` refuses what Python wrote and somebody changed; and what `compare` wrote."""
    segcal("import", FOLDER / "rec", "--out", FOLDER / "imported")
    run = json.loads((FOLDER / "imported" / "manifest.json").read_text())["runs"][0]
    assert run["command"] == "import" and run["arguments"][0] == "import" and run["program"].startswith("segcal 1."), run
    assert {"import.json", "mav0/imu0/data.csv"} <= {f["name"] for f in run["files"]}, run
    segcal("import", FOLDER / "imported", "--list")
    imu = FOLDER / "imported" / "mav0/imu0/data.csv"
    imu.write_text(imu.read_text().rsplit("\n", 2)[0] + "\n")
    said = segcal("replay", FOLDER / "imported", "--out", FOLDER / "none", code=2).stderr
    assert "expected the file that `segcal import` wrote" in said, said
    segcal("compare", FOLDER / "a", FOLDER / "a", "--out", FOLDER / "compared")
    (FOLDER / "compared" / "compare.json").write_text("{}")
    assert not accepted(FOLDER / "compared")


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    for seed, name in ((1, "a"), (2, "b")):
        segcal("simulate", "--out", FOLDER / "rec", "--scenario", "rich", "--seconds", 10, "--seed", seed)
        segcal("replay", FOLDER / "rec", "--segments", 3, "--segment-seconds", 3, "--out", FOLDER / name)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    check_export()
    check_fleet()
    check_readers()
    print("output run: whole, or refused", file=sys.stderr)


main()
