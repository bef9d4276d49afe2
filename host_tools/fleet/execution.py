"""Who does the work: the cores of this machine, or the workers of a Dask scheduler, behind the same interface
(concurrent.futures)."""

import concurrent.futures
import os
import sys

import work
import logs

MOST_IN_BATCH = 100   # 10^6 logs are 10^4 tasks for a scheduler
BATCHES_A_WORKER = 8  # so that all end at about the same time
AWAKE_S = 0.2
WITHOUT_PROGRESS = 3  # rounds of lost workers in which not one batch came back


def cores():
    return len(os.sched_getaffinity(0))


def connect(address, jobs):
    """(executor, number of workers, what to close)."""
    if not address:
        # Threads: each waits for a process of its own, `segcal replay`, which does the work and may die alone.
        executor = concurrent.futures.ThreadPoolExecutor(jobs or cores())
        return executor, jobs or cores(), []
    try:
        from distributed import Client
    except ImportError:
        raise logs.InputError("--scheduler: needs Python's distributed; pip install distributed") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise logs.InputError(f"--scheduler {address}: {error}") from None
    threads = sum(client.nthreads().values())
    return client.get_executor(pure=False), max(1, threads), [client]


def portable(task, address):
    """The task as a worker can take it that has no copy of these files: functions by value, in bytes that only it unpacks."""
    if not address:
        return task
    import cloudpickle
    for module in (work, logs, logs.input_error):
        cloudpickle.register_pickle_by_value(module)
    packed = cloudpickle.dumps(task)
    return lambda batch: cloudpickle.loads(packed)(batch)


def lost_workers(address):
    """What a future ends with when its worker is gone for good: Dask itself tries three others first."""
    if not address:
        return ()
    from distributed.scheduler import KilledWorker
    return KilledWorker, concurrent.futures.CancelledError


def batches_of(paths, workers, size):
    size = size or max(1, min(MOST_IN_BATCH, len(paths) // (workers * BATCHES_A_WORKER)))
    return [paths[i:i + size] for i in range(0, len(paths), size)]


def say(done, total):
    share = 100 * done // max(total, 1)
    sys.stderr.write(f"\rfleet {share} % ({done} of {total} logs)" if sys.stderr.isatty() else f"fleet {share} % ({done} of {total} logs)\n")
    sys.stderr.flush()


def as_completed(futures):
    """As concurrent.futures has it, but awake from time to time: a signal that comes while all is waited for may not wake this thread."""
    waiting = set(futures)
    while waiting:
        done, waiting = concurrent.futures.wait(waiting, timeout=AWAKE_S, return_when=concurrent.futures.FIRST_COMPLETED)
        yield from done


def run_all(paths, task, address=None, jobs=None, batch_size=None):
    """`task` is run_batch without its batch. Entries of all logs in the order of `paths`. A batch whose worker died is given to
    another one; what the dead one had finished is in the store."""
    executor, workers, to_close = connect(address, jobs)
    lost, task = lost_workers(address), portable(task, address)
    waiting, entries, lost_rounds, told = batches_of(paths, workers, batch_size), [], 0, -1
    try:
        while waiting:
            futures = {executor.submit(task, batch): batch for batch in waiting}
            waiting, before = [], len(entries)
            for future in as_completed(futures):
                try:
                    entries += future.result()
                except lost:
                    print("fleet: a batch lost its worker several times; it is begun again", file=sys.stderr)
                    waiting.append(futures[future])
                if 20 * len(entries) // max(len(paths), 1) != told:
                    told = 20 * len(entries) // max(len(paths), 1)
                    say(len(entries), len(paths))
            lost_rounds = lost_rounds + 1 if len(entries) == before else 0
            if lost_rounds == WITHOUT_PROGRESS:
                raise logs.InputError("workers die without finishing any log; see their own messages")
    except KeyboardInterrupt:
        work.STOPPING.append(True)  # else each thread would go on to the end of its batch
        raise
    finally:
        executor.shutdown(wait=False, cancel_futures=True) if not to_close else executor.shutdown(wait=False)
        for client in to_close:
            client.close()
    place = {path: i for i, path in enumerate(paths)}
    return sorted(entries, key=lambda entry: place[entry["log"]])
