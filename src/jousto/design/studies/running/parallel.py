"""Parallel computation of a study: threads, processes or a Dask cluster."""

from __future__ import annotations

import os
import pickle
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.pipes import broken_pipes_raise
from jousto.design.studies.running.evaluator import Evaluator, Row
from jousto.design.studies.running.guard import end_with_parent, lock_shared
from jousto.design.studies.running.journal import Journal, Sizes, read_row, write_row

WAYS = ("threads", "processes", "dask")
MOST_DEATHS = 3
"""Number of worker deaths at a point from which it counts as failed."""
CHUNK = 32  # largest number of points in one task of a process

Points = Sequence[tuple[int, tuple[float, ...]]]
Found = Iterator[tuple[int, Row]]


def failed_row(evaluator: Evaluator, reason: str) -> Row:
    """Return the row of a failed point."""
    return [float("nan")] * len(evaluator.outcomes), reason


def split_points(points: Points, size: int) -> list[Points]:
    """Return the points in pieces of a size."""
    return [points[k : k + size] for k in range(0, len(points), size)]


def run_here(evaluator: Evaluator, points: Points, journal: Journal | None) -> Found:
    """Compute the points in this thread, one by one or in batches."""
    for part in split_points(points, evaluator.width):
        yield from _worked_out(evaluator, part, journal)


def _worked_out(evaluator: Evaluator, points: Points, journal: Journal | None) -> Found:
    rows = evaluator.rows([np.array(x) for _, x in points])
    for (i, x), row in zip(points, rows, strict=True):
        if journal is not None:
            journal.add(x, row)
        yield i, row


def run_threads(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: int
) -> Found:
    """Compute the points in threads that share the evaluator; the engine releases the GIL."""

    def work(part: Points) -> list[tuple[int, Row]]:
        return list(_worked_out(evaluator, part, journal))

    with ThreadPoolExecutor(workers) as pool:
        open_: set[Future[list[tuple[int, Row]]]] = set()
        try:
            for part in split_points(points, evaluator.width):
                open_.add(pool.submit(work, part))
                if len(open_) >= 2 * workers:
                    yield from _finished(open_)
            while open_:
                yield from _finished(open_)
        finally:
            for future in open_:
                future.cancel()


def _finished(open_: set[Future[list[tuple[int, Row]]]]) -> Found:
    done, _ = wait(open_, return_when=FIRST_COMPLETED)
    for future in done:
        open_.remove(future)
        yield from future.result()


# -- processes ------------------------------------------------------------------------------

_EVALUATOR: Evaluator | None = None


def _start(data: bytes, sign: str, path: str) -> None:
    """Initialise a worker process and report that it is ready."""
    global _EVALUATOR
    end_with_parent()
    lock_shared(path)
    _EVALUATOR = pickle.loads(data)
    Path(sign).touch()


def _chunk(points: Points, path: str) -> tuple[dict[str, int], dict[str, int]]:
    """Compute points in a worker process; return counts and warnings."""
    assert _EVALUATOR is not None
    return compute_points(_EVALUATOR, points, path)[1:]


def compute_points(
    evaluator: Evaluator, points: Points, path: str
) -> tuple[list[tuple[int, Row]], dict[str, int], dict[str, int]]:
    """Compute points and append them to a journal if there is one; return them with counts."""
    lock_shared(path)
    before, noted = evaluator.counts, dict(evaluator.notes)
    rows = []
    with evaluator.count_warnings():
        for part in split_points(points, evaluator.width):
            found = evaluator.rows([np.array(x) for _, x in part])
            for (i, x), row in zip(part, found, strict=True):
                if path:
                    write_row(Path(path), x, row)
                rows.append((i, row))
    counts = {name: n - before[name] for name, n in evaluator.counts.items()}
    notes = {text: n - noted.get(text, 0) for text, n in evaluator.notes.items()}
    return rows, counts, notes


def _add(evaluator: Evaluator, counts: dict[str, int], notes: dict[str, int]) -> None:
    """Add counts and warnings of a worker."""
    evaluator.memory.reductions.made += counts.pop("reductions")
    for name, n in counts.items():
        evaluator.memory.counts[name] += n
    for text, n in notes.items():
        if n:
            evaluator.notes[text] = evaluator.notes.get(text, 0) + n


def portable(evaluator: Evaluator) -> bytes:
    """Return a pickled evaluator for another process.

    Raises
    ------
    InputError
        If the evaluator contains a function that cannot be pickled.
    """
    try:
        # cloudpickle also serialises functions of scripts and notebooks
        from cloudpickle import dumps
    except ImportError:
        dumps = pickle.dumps
    try:
        return bytes(dumps(evaluator))
    except Exception as error:
        message = (
            f"cannot be sent to another process ({error}); put functions at the top level of a "
            "module, "
            "or use threads"
        )
        raise InputError(Problem("study", message)) from None


def run_processes(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: int
) -> Found:
    """Compute in processes that write their own rows, so that a crash loses no finished row.

    After a crash of one process the others are stopped, and new ones continue with the missing
    points.
    """
    data = portable(evaluator)
    with tempfile.TemporaryDirectory(prefix="jousto-") as folder:
        own = journal or Journal(Path(folder) / "rows.jsonl", {})
        left = dict(points)
        places = {x: i for i, x in points}
        deaths: dict[int, int] = {}
        reader, sign = Tail(own.path, own.sizes), Path(folder) / "started"
        size = max(1, min(CHUNK, len(left) // (8 * workers)))
        while left:
            before, broken = len(left), False
            start = (data, str(sign), str(own.path))
            for x, row in _pool(evaluator, start, list(left.items()), workers, size, reader):
                if x is None:
                    broken = True
                elif (i := places.get(x, -1)) in left:
                    del left[i]
                    yield i, row
            if not broken and len(left) == before:
                raise InputError(Problem("study", f"{own.path} was changed while it was written"))
            if not broken:
                continue
            if not sign.exists():
                raise InputError(Problem("study", GUARD))
            size = 1
            # the points that were begun first, since one of them may have crashed the worker
            for i in list(left)[:workers]:
                deaths[i] = deaths.get(i, 0) + 1
                if deaths[i] >= MOST_DEATHS:
                    row = failed_row(evaluator, "its process died")
                    own.add(left.pop(i), row)
                    yield i, row


GUARD = (
    "processes die before they work; a script that starts a study must do so below "
    "if __name__ == '__main__':; functions of a notebook need cloudpickle (pip install cloudpickle)"
)


def _pool(
    evaluator: Evaluator,
    start: tuple[bytes, str, str],
    left: Points,
    workers: int,
    size: int,
    reader: Tail,
) -> Iterator[tuple[tuple[float, ...] | None, Row]]:
    """Yield rows from a process pool; the point None reports a crashed worker."""
    chunks = split_points(left, size)
    pool = ProcessPoolExecutor(min(workers, len(chunks)), get_context("spawn"), _start, start)
    try:
        open_ = {pool.submit(_chunk, chunk, str(reader.path)) for chunk in chunks}
        while open_:
            done, open_ = wait(open_, timeout=0.1, return_when=FIRST_COMPLETED)
            yield from reader.rows()
            for future in done:
                _add(evaluator, *future.result())
    except BrokenProcessPool:
        yield from reader.rows()
        yield None, ([], "")
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    yield from reader.rows()


class Tail:
    """Reader of the lines that are appended to a journal."""

    def __init__(self, path: Path, sizes: Sizes) -> None:
        self.path, self._sizes = path, sizes
        self._at = path.stat().st_size

    def rows(self) -> Iterator[tuple[tuple[float, ...], Row]]:
        """Yield the new complete rows."""
        with self.path.open("rb") as file:
            file.seek(self._at)
            data = file.read()
        data = data[: data.rfind(b"\n") + 1]
        self._at += len(data)
        for line in data.split(b"\n")[:-1]:
            try:
                yield read_row(line, self._sizes)
            except ValueError:
                continue  # incomplete line of a crashed process


# -- Dask -----------------------------------------------------------------------------------

ONWARD = "the same call with another client and the same path goes on"


def run_dask(
    evaluator: Evaluator, points: Points, journal: Journal | None, client: Any, local: bool
) -> Found:
    """Compute on a Dask cluster; workers on this computer write their rows themselves."""
    from distributed import KilledWorker, as_completed

    path = str(journal.path.resolve()) if journal is not None and local else ""
    workers = max(1, len(client.scheduler_info()["workers"]))
    size = max(1, min(CHUNK, len(points) // (8 * workers)))
    shared = client.scatter(evaluator, broadcast=True)
    chunks = split_points(points, size)
    places = {client.submit(compute_points, shared, c, path, pure=False): c for c in chunks}
    coming, tries = as_completed(list(places)), Counter[int]()
    for future in coming:
        chunk = places.pop(future)
        done = future.status == "finished"
        try:
            rows, counts, notes = future.result() if done else ([], {}, {})
        except CancelledError:  # a worker crashed with its results and its data
            shared = client.scatter(evaluator, broadcast=True)
            again = client.submit(compute_points, shared, chunk, path, pure=False)
            places[again] = chunk
            coming.add(again)
            continue
        if done:
            _add(evaluator, counts, notes)
        elif future.cancelled():
            kept = "" if journal is None else f", what it did is in {journal.path}"
            raise InputError(Problem("study", f"the cluster is gone or cancelled{kept}; {ONWARD}"))
        elif len(chunk) > 1 or _should_retry(tries, chunk[0][0], future.exception(), KilledWorker):
            # a worker crashed at one of these points, or before it returned the results
            for point in chunk:
                again = client.submit(compute_points, shared, [point], path, pure=False)
                places[again] = [point]
                coming.add(again)
            continue
        else:
            rows = [(chunk[0][0], failed_row(evaluator, f"its worker died: {future.exception()}"))]
        for i, row in rows:
            if journal is not None and not (path and done):
                journal.add(dict(chunk)[i], row)
            yield i, row
        future.release()


def _should_retry(tries: Counter[int], point: int, error: Any, killed: type) -> bool:
    """Return whether to repeat a point whose result was lost without a crash at it."""
    tries[point] += 1
    return not isinstance(error, killed) and tries[point] <= MOST_DEATHS


def dask_client(workers: int) -> Any:
    """Return the client of a new local Dask cluster of processes with one thread each.

    Raises
    ------
    InputError
        If Dask is not installed.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        message = "needs Dask: pip install distributed"
        raise InputError(Problem("study", message)) from None
    # a free port for the dashboard instead of the default 8787
    cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0")
    return Client(cluster)


def run_points(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: Any, how: str
) -> Found:
    """Yield the rows of points as they complete, computed as `workers` and `how` specify.

    Raises
    ------
    InputError
        If `how` is unknown.
    """
    client = workers if hasattr(workers, "submit") and hasattr(workers, "scatter") else None
    if workers == "dask":
        workers, how = None, "dask"
    count = 1 if client is not None else _workers(workers)
    if client is None and how not in WAYS:
        raise InputError(Problem("study", f"how is {how!r}{suggest(str(how), WAYS)}"))
    left = []
    for i, x in points:
        # a NaN or infinite value: reported as a failed point
        if outside := evaluator.out_of_bounds(np.array(x)):
            row = failed_row(evaluator, outside)
            if journal is not None:
                journal.add(x, row)
            yield i, row
        else:
            left.append((i, x))
    if client is not None:
        yield from run_dask(evaluator, left, journal, client, local=False)
    elif how == "dask":
        client = dask_client(count)
        try:
            yield from run_dask(evaluator, left, journal, client, local=True)
        finally:
            client.cluster.close()
            client.close()
    elif how == "processes":
        with broken_pipes_raise():
            yield from run_processes(evaluator, left, journal, count)
    elif count == 1:
        yield from run_here(evaluator, left, journal)
    else:
        yield from run_threads(evaluator, left, journal, count)


def _workers(given: Any) -> int:
    if given is None:
        return os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        message = f"workers is {given!r}, must be a whole number from 1, 'dask' or a Client of Dask"
        raise InputError(Problem("study", message))
    return given
