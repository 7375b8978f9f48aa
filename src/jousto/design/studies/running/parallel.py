"""Points of a study spread over threads, processes or a Dask cluster; results as they come."""

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
from jousto.design.studies.running.guard import end_with_parent, hold
from jousto.design.studies.running.journal import Journal, Sizes, read_row, write_row

WAYS = ("threads", "processes", "dask")
MOST_DEATHS = 3
"""How often a process may die over a point before the point counts as failed."""
CHUNK = 32  # points that a process gets at once, at the most

Points = Sequence[tuple[int, tuple[float, ...]]]
Found = Iterator[tuple[int, Row]]


def nothing(evaluator: Evaluator, reason: str) -> Row:
    """Return the row of a point that failed."""
    return [float("nan")] * len(evaluator.outcomes), reason


def parts(points: Points, size: int) -> list[Points]:
    """Return the points in pieces of a size."""
    return [points[k : k + size] for k in range(0, len(points), size)]


def one_by_one(evaluator: Evaluator, points: Points, journal: Journal | None) -> Found:
    """Work here, one point after the other, or as many at once as share a vector."""
    for part in parts(points, evaluator.width):
        yield from _worked_out(evaluator, part, journal)


def _worked_out(evaluator: Evaluator, points: Points, journal: Journal | None) -> Found:
    rows = evaluator.rows([np.array(x) for _, x in points])
    for (i, x), row in zip(points, rows, strict=True):
        if journal is not None:
            journal.add(x, row)
        yield i, row


def by_threads(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: int
) -> Found:
    """Let threads share the evaluator; the engine works without the lock of Python."""

    def work(part: Points) -> list[tuple[int, Row]]:
        return list(_worked_out(evaluator, part, journal))

    with ThreadPoolExecutor(workers) as pool:
        open_: set[Future[list[tuple[int, Row]]]] = set()
        try:
            for part in parts(points, evaluator.width):
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
    """Make a process ready, and say so."""
    global _EVALUATOR
    end_with_parent()
    hold(path)
    _EVALUATOR = pickle.loads(data)
    Path(sign).touch()


def _chunk(points: Points, path: str) -> tuple[dict[str, int], dict[str, int]]:
    """Work out points in a process and write each as it comes; return counts and notes."""
    assert _EVALUATOR is not None
    return work_out(_EVALUATOR, points, path)[1:]


def work_out(
    evaluator: Evaluator, points: Points, path: str
) -> tuple[list[tuple[int, Row]], dict[str, int], dict[str, int]]:
    """Work out points, write them if there is a file; return them with counts and notes."""
    hold(path)
    before, told = evaluator.counts, dict(evaluator.notes)
    rows = []
    with evaluator.noting():
        for part in parts(points, evaluator.width):
            found = evaluator.rows([np.array(x) for _, x in part])
            for (i, x), row in zip(part, found, strict=True):
                if path:
                    write_row(Path(path), x, row)
                rows.append((i, row))
    counts = {name: n - before[name] for name, n in evaluator.counts.items()}
    notes = {text: n - told.get(text, 0) for text, n in evaluator.notes.items()}
    return rows, counts, notes


def _add(evaluator: Evaluator, counts: dict[str, int], notes: dict[str, int]) -> None:
    """Add what was done elsewhere."""
    evaluator.memory.reductions.made += counts.pop("reductions")
    for name, n in counts.items():
        evaluator.memory.counts[name] += n
    for text, n in notes.items():
        if n:
            evaluator.notes[text] = evaluator.notes.get(text, 0) + n


def portable(evaluator: Evaluator) -> bytes:
    """Return an evaluator for another process.

    Raises
    ------
    InputError
        If it holds a function that cannot travel.
    """
    try:
        from cloudpickle import dumps  # takes functions of scripts and notebooks along
    except ImportError:
        dumps = pickle.dumps
    try:
        return bytes(dumps(evaluator))
    except Exception as error:
        message = (
            f"cannot go to another process ({error}); put functions at the top level of a module, "
            "or use threads"
        )
        raise InputError(Problem("study", message)) from None


def by_processes(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: int
) -> Found:
    """Let processes write their rows themselves, so that no death loses one.

    Where a process dies the others are stopped and new ones go on with what is not written.
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
            for i in list(left)[:workers]:  # begun first, one of them is suspected
                deaths[i] = deaths.get(i, 0) + 1
                if deaths[i] >= MOST_DEATHS:
                    row = nothing(evaluator, "its process died")
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
    """Yield the rows that a pool of processes writes; None as the point if one of them died."""
    chunks = parts(left, size)
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
    """Reads what is appended to a journal."""

    def __init__(self, path: Path, sizes: Sizes) -> None:
        self.path, self._sizes = path, sizes
        self._at = path.stat().st_size

    def rows(self) -> Iterator[tuple[tuple[float, ...], Row]]:
        """Yield the rows that are new and whole."""
        with self.path.open("rb") as file:
            file.seek(self._at)
            data = file.read()
        data = data[: data.rfind(b"\n") + 1]
        self._at += len(data)
        for line in data.split(b"\n")[:-1]:
            try:
                yield read_row(line, self._sizes)
            except ValueError:
                continue  # a piece that a process left as it died


# -- Dask -----------------------------------------------------------------------------------

ONWARD = "the same call with another client and the same path goes on"


def by_dask(
    evaluator: Evaluator, points: Points, journal: Journal | None, client: Any, local: bool
) -> Found:
    """Let a Dask cluster work; the rows of a local one are written by its workers."""
    from distributed import KilledWorker, as_completed

    path = str(journal.path.resolve()) if journal is not None and local else ""
    workers = max(1, len(client.scheduler_info()["workers"]))
    size = max(1, min(CHUNK, len(points) // (8 * workers)))
    shared = client.scatter(evaluator, broadcast=True)
    chunks = parts(points, size)
    places = {client.submit(work_out, shared, c, path, pure=False): c for c in chunks}
    coming, tries = as_completed(list(places)), Counter[int]()
    for future in coming:
        chunk = places.pop(future)
        done = future.status == "finished"
        try:
            rows, counts, notes = future.result() if done else ([], {}, {})
        except CancelledError:  # a worker died with its result, and with what it was given
            shared = client.scatter(evaluator, broadcast=True)
            again = client.submit(work_out, shared, chunk, path, pure=False)
            places[again] = chunk
            coming.add(again)
            continue
        if done:
            _add(evaluator, counts, notes)
        elif future.cancelled():
            kept = "" if journal is None else f", what it did is in {journal.path}"
            raise InputError(Problem("study", f"the cluster is gone or cancelled{kept}; {ONWARD}"))
        elif len(chunk) > 1 or _again(tries, chunk[0][0], future.exception(), KilledWorker):
            for point in chunk:  # a worker died over one of them, or before it gave its results
                again = client.submit(work_out, shared, [point], path, pure=False)
                places[again] = [point]
                coming.add(again)
            continue
        else:
            rows = [(chunk[0][0], nothing(evaluator, f"its worker died: {future.exception()}"))]
        for i, row in rows:
            if journal is not None and not (path and done):
                journal.add(dict(chunk)[i], row)
            yield i, row
        future.release()


def _again(tries: Counter[int], point: int, error: Any, killed: type) -> bool:
    """Return whether to try a point again: its results got lost, it did not kill its workers."""
    tries[point] += 1
    return not isinstance(error, killed) and tries[point] <= MOST_DEATHS


def dask_client(workers: int) -> Any:
    """Return the client of a new local cluster of processes with one thread each.

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
    # its page gets a port that is free: without an address it would insist on 8787
    cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0")
    return Client(cluster)


def spread(
    evaluator: Evaluator, points: Points, journal: Journal | None, workers: Any, how: str
) -> Found:
    """Yield the rows of points as they come, from where `workers` and `how` say.

    Raises
    ------
    InputError
        If there is no such way.
    """
    client = workers if hasattr(workers, "submit") and hasattr(workers, "scatter") else None
    if workers == "dask":
        workers, how = None, "dask"
    count = 1 if client is not None else _workers(workers)
    if client is None and how not in WAYS:
        raise InputError(Problem("study", f"how is {how!r}{suggest(str(how), WAYS)}"))
    left = []
    for i, x in points:
        if outside := evaluator.outside(np.array(x)):  # no number would match what is not one
            row = nothing(evaluator, outside)
            if journal is not None:
                journal.add(x, row)
            yield i, row
        else:
            left.append((i, x))
    if client is not None:
        yield from by_dask(evaluator, left, journal, client, local=False)
    elif how == "dask":
        client = dask_client(count)
        try:
            yield from by_dask(evaluator, left, journal, client, local=True)
        finally:
            client.cluster.close()
            client.close()
    elif how == "processes":
        with broken_pipes_raise():
            yield from by_processes(evaluator, left, journal, count)
    elif count == 1:
        yield from one_by_one(evaluator, left, journal)
    else:
        yield from by_threads(evaluator, left, journal, count)


def _workers(given: Any) -> int:
    if given is None:
        return os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        message = f"workers is {given!r}, must be a whole number from 1, 'dask' or a Client of Dask"
        raise InputError(Problem("study", message))
    return given
