"""segcal fleet as a user runs it: on this machine, in shards, interrupted, on a Dask scheduler whose worker is killed; always the same tables.
Usage: test_fleet.py SEGCAL SOURCE_TREE FOLDER [SEED]; SEGCAL_LONG=1 kills ten workers, not two."""

import fcntl
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import duckdb
import pyarrow.parquet as pq

SEGCAL, SOURCE, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
SEED = int(sys.argv[4]) if len(sys.argv) > 4 else 1
DEVICES, LOGS, KILLS = (5, 6, 10) if os.environ.get("SEGCAL_LONG") else (5, 2, 2)
REPLAY = ["--", "--segments", "3", "--segment-seconds", "3"]
ENVIRONMENT = {**os.environ, "SEGCAL_PYTHON": sys.executable}


def segcal(*arguments, **how):
    return subprocess.run([SEGCAL, *map(str, arguments)], capture_output=True, text=True, check=False, env=ENVIRONMENT, timeout=300, **how)


def fleet(out, *arguments):
    done = segcal("fleet", FOLDER / "logs", "--out", FOLDER / out, *arguments, *REPLAY)
    assert done.returncode in (0, 1), done.stderr
    return done


def table(out, name):
    return pq.read_table(FOLDER / out / f"{name}.parquet").to_pylist()


def check_same(a, b):
    files = sorted(f.name for f in (FOLDER / a).glob("*.parquet"))
    assert len(files) == 11, files
    for name in files:
        same = (FOLDER / a / name).read_bytes() == (FOLDER / b / name).read_bytes()
        assert same or name == "times.parquet", f"{name}: {a} and {b} differ"


def make_logs():
    for device in range(DEVICES):
        for log in range(LOGS):
            folder = FOLDER / "logs" / f"device_{device}" / f"session_{log}"
            done = segcal("simulate", "--out", folder, "--scenario", "rich", "--seconds", 11, "--seed", 10 * device + log + 1, "--device-seed", device + 1)
            assert done.returncode == 0, done.stderr
    shutil.copytree(FOLDER / "logs/device_0/session_0", FOLDER / f"logs/device_0/session_{LOGS}", dirs_exist_ok=True)
    tracks = FOLDER / f"logs/device_0/session_{LOGS}/mav0/cam0/tracks.csv"
    tracks.write_text(tracks.read_text()[:5000] + "\nbroken line\n")


def check_tables():
    runs = table("whole", "runs")
    assert [r["place"] for r in runs] == [*range(LOGS + 1)] + [*range(LOGS)] * (DEVICES - 1)
    assert runs[LOGS]["status"] == "refused" and "tracks.csv:" in runs[LOGS]["error"] and runs[LOGS]["exit_code"] == 2
    assert {r["device"] for r in runs if r["status"] != "refused"} == {f"simulated-{d + 1}" for d in range(DEVICES)}
    fused = [r for r in table("whole", "devices") if r["device"] == "simulated-1"]
    single = {(r["device"], r["place"], r["name"]): r for r in table("whole", "parameters")}
    assert len(fused) == 26 and fused[0]["logs"] == LOGS
    for row in fused:  # all logs know more than each
        each = [single["simulated-1", place, row["name"]]["sigma"] for place in range(LOGS)]
        assert row["sigma"] < 1.001 * min(each), (row, each)
    assert {r["devices"] for r in table("whole", "models")} <= set(range(1, DEVICES + 1))
    page = (FOLDER / "whole" / "report.html").read_text()
    assert f"{DEVICES * LOGS + 1} logs of {DEVICES} devices" in page and f"device_0/session_{LOGS}" in page
    kinds = {(r["kind"], r["device"]) for r in table("whole", "attention")}
    assert any(kind == "refused" for kind, _ in kinds) and not any(kind == "change" for kind, _ in kinds), kinds


def check_resumed_and_sharded():
    """Two shards, then the whole: nothing is done twice. Then one record is damaged: only that is done again."""
    for i in (0, 1):
        done = fleet("sharded", "--shard", f"{i}/2")
        assert "shard" in done.stderr and not (FOLDER / "sharded" / "runs.parquet").exists()
    stamps = {f: f.stat().st_mtime_ns for f in (FOLDER / "sharded" / "work").rglob("*.json")}
    assert len(stamps) == DEVICES * LOGS + 1
    damaged = sorted(stamps)[0]
    damaged.write_text("{")
    fleet("sharded")
    changed = [f for f in stamps if f.stat().st_mtime_ns != stamps[f]]
    assert changed == [damaged], changed
    check_same("whole", "sharded")


def check_interrupted():
    """The command and its replays are killed in the middle; begun again it comes to the same."""
    command = [SEGCAL, "fleet", FOLDER / "logs", "--out", FOLDER / "killed", "--jobs", "1", "--batch", "1", *REPLAY]
    process = subprocess.Popen(list(map(str, command)), env=ENVIRONMENT, stderr=subprocess.DEVNULL, start_new_session=True)
    done = FOLDER / "killed" / "work"
    while len(list(done.rglob("*.json"))) < 3 and process.poll() is None:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert 3 <= len(list(done.rglob("*.json"))) < DEVICES * LOGS + 1, "killed too late to show anything"
    fleet("killed")
    check_same("whole", "killed")
    again = fleet("killed", "--again")
    assert "another result hash" not in again.stderr
    check_same("whole", "killed")


def check_stopped():
    """Ctrl-C and SIGTERM: the replays under way end, no other is begun although a batch has many, no folder is left; the folders that a
    killed run left are removed by the next one, and those of a living one are not."""
    temporary = FOLDER / "temporary"
    environment = {**ENVIRONMENT, "TMPDIR": str(temporary)}
    command = [SEGCAL, "fleet", FOLDER / "logs", "--out", FOLDER / "stopped", "--jobs", "1", "--batch", "100", *REPLAY]
    work, before = FOLDER / "stopped" / "work", 0
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        temporary.mkdir(exist_ok=True)
        process = subprocess.Popen(list(map(str, command)), env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
        while len(list(work.rglob("*.json"))) == before:
            assert process.poll() is None
            time.sleep(0.02)
        os.killpg(process.pid, number)
        by_then = len(list(work.rglob("*.json")))
        said = process.communicate()[1]  # to the end of all that write to it
        done = len(list(work.rglob("*.json")))
        assert before < done <= by_then + 1, f"signal {number}: {done - by_then} logs were done after it, {said}"  # the one under way
        before, left = done, list(temporary.glob("segcal_fleet_*"))
        assert number == signal.SIGKILL or ("interrupted" in said and not left), (said, left)
    for folder in left:
        os.utime(folder, (0, 0))
    alive = temporary / "segcal_fleet_alive"
    alive.mkdir()
    os.utime(alive, (0, 0))
    lock = os.open(alive, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_SH)
    subprocess.run(list(map(str, command)), env=environment, check=False, capture_output=True)
    os.close(lock)
    assert list(temporary.iterdir()) == [alive], list(temporary.iterdir())
    check_same("whole", "stopped")


def check_options_of_replay():
    """--name=value is --name value: the same key, and a file is known by its content, not by its name."""
    log, config = FOLDER / "logs/device_1/session_0", FOLDER / "config.yaml"
    keys = []
    for text, option in (("0.5", ["--config", config]), ("0.5", [f"--config={config}"]), ("0.6", [f"--config={config}"])):
        config.write_text(f"format: 1\nnoise:\n  pixel_sigma_px: {text}\n")
        done = segcal("fleet", log, "--out", FOLDER / "options", *REPLAY, *option)
        assert done.returncode == 0, done.stderr
        keys.append(table("options", "runs")[0]["key"])
    assert keys[0] == keys[1] != keys[2], keys


def worker(address):
    return subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"],
                            cwd=FOLDER, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def killed_at_random(process, workers, address, kills):
    """Kills one of the workers at a random moment and starts another one, so many times or until the work is done."""
    chosen, done = random.Random(SEED), 0
    while done < kills and process.poll() is None:
        time.sleep(chosen.uniform(0.3, 1.5))
        victim = chosen.randrange(len(workers))
        workers[victim].kill()
        workers[victim].wait()
        workers[victim] = worker(address)
        done += 1
    return done


def check_dask():
    """A real scheduler and two worker processes; one of them, drawn at random, is killed again and again."""
    address_file = FOLDER / "scheduler.json"
    scheduler = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                                  "--scheduler-file", str(address_file)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    workers = []
    try:
        while not address_file.exists():
            assert scheduler.poll() is None
            time.sleep(0.1)
        address = re.search(r"tcp://[0-9.:]+", address_file.read_text())[0]
        workers += [worker(address) for _ in range(2)]
        command = [SEGCAL, "fleet", FOLDER / "logs", "--out", FOLDER / "dask", "--batch", "2", "--scheduler", address, *REPLAY]
        process = subprocess.Popen(list(map(str, command)), env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        while not list((FOLDER / "dask" / "work").rglob("*.json")) and process.poll() is None:
            time.sleep(0.02)
        killed = killed_at_random(process, workers, address, KILLS)
        said, _ = process.communicate(timeout=300)
        assert process.returncode == 1, said  # 1: the broken log
        assert killed >= 1, f"the work was done before a worker was killed; seed {SEED}"  # a fast machine may be done before the others
    finally:
        for child in (*workers, scheduler):
            child.kill()
            child.wait()
    check_same("whole", "dask")
    return killed


def check_refusals():
    (FOLDER / "empty.txt").write_text("# none yet\n")
    for arguments, says in (
        ([f"@{FOLDER / 'empty.txt'}", "--out", FOLDER / "x"], "no logs in it"),
        ([FOLDER / "logs", "--out", "foo://x"], "found the protocol 'foo'"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--", "--state", "f"], "--state behind --"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--", "--segmentz", "3"], "not expected: --segmentz"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--", "--cameras", "x"], "Value x not in range"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--", "--config=none.yaml"], "--config none.yaml: no such file"),
        (["nowhere", "--out", "x"], "nowhere: no such file or folder"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--shard", "2/2"], "expected i/n"),
        ([FOLDER / "logs"], "--out"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--devices", "(?P<model>x)"], "(?P<device>...)"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--scheduler", "tcp://127.0.0.1:1"], "--scheduler tcp://127.0.0.1:1"),
        ([FOLDER / "logs", "--out", FOLDER / "x", "--", "--json"], "--json behind --"),
    ):
        done = segcal("fleet", *arguments)
        assert done.returncode == 2 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1, (arguments, done.stderr)
    assert not (FOLDER / "x").exists()
    assert "--scheduler" in segcal("fleet", "--help").stdout


def check_logs_with_a_state():
    """What a device's log begins with is of the logs before it, and does not count again."""
    log = FOLDER / "state.segcal"
    log.write_bytes((SOURCE / "fixtures/fuzz/log/state").read_bytes()[1:])
    assert '"begins_with_state": true' in segcal("replay", log, "--out", FOLDER / "state", "--json").stdout
    done = segcal("fleet", log, "--out", FOLDER / "states")
    assert done.returncode in (0, 1), done.stderr
    records = [f.read_text() for f in (FOLDER / "states" / "work").rglob("*.json")]
    assert len(records) == 1 and '"status"' in records[0] and "begins_with_state" not in records[0], records


def check_queries():
    """Each query of docs/fleet.md runs on these tables, and says something where there is something to say."""
    queries = re.findall(r"```sql\n(.*?)```", (SOURCE / "docs" / "fleet.md").read_text(), re.DOTALL)
    os.chdir(FOLDER / "whole")
    answers = [duckdb.sql(query).fetchall() for query in queries]
    assert len(queries) == 6 and all(answers[:3]) and answers[4], answers
    assert answers[0][0][0] == "simulated" and sum(row[2] for row in answers[0]) == DEVICES * LOGS + 1


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    make_logs()
    whole = fleet("whole")
    assert "1 refused: " in whole.stdout and "tracks.csv:" in whole.stdout, whole.stdout  # on the terminal too
    check_tables()
    check_resumed_and_sharded()
    check_interrupted()
    check_stopped()
    check_options_of_replay()
    killed = check_dask()
    check_refusals()
    check_logs_with_a_state()
    check_queries()
    print(f"fleet: the same tables each way, {killed} workers killed")


main()
