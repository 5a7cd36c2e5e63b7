"""Reads and summarises many logs at once, in worker processes."""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Final, NamedTuple

from app.flight_analysis.summary import FlightSummary, summarise
from app.flight_logs.csv_columns import CsvColumns
from app.flight_logs.flight_log import LogUnreadable
from app.flight_logs.read_log import read_flight_log
from app.text.messages import UserMessage, said
from protocol.translatable import marked

FEW_LOGS: Final = 4
"""Read one after the other in this process: starting others would take longer."""
POLLED_S: Final = 0.1
"""How soon a cancellation is seen."""


class SummarisedLog(NamedTuple):
    """`flight` is None where the log cannot be read; `why_not` then says why."""

    path: Path
    flight: FlightSummary | None
    why_not: UserMessage | None = None


def summarise_log(path: Path, columns: CsvColumns | None = None) -> SummarisedLog:
    """Raises nothing."""
    try:
        return SummarisedLog(path, summarise(read_flight_log(path, columns)))
    except LogUnreadable as error:
        return SummarisedLog(path, None, error.why)


def summarise_logs(
    paths: Sequence[Path],
    columns: CsvColumns | None = None,
    *,
    is_cancelled: Callable[[], bool] = lambda: False,
    processes: int | None = None,
) -> Iterator[SummarisedLog]:
    """One result a log, in the order in which they are done; fewer where it was cancelled.

    Blocks: call it in a thread of its own. `is_cancelled` is asked in that thread, some ten times a second.
    `processes`: as many as there are processors.
    """
    count = processes if processes is not None else os.cpu_count() or 1
    if len(paths) < FEW_LOGS or count < 2:
        for path in paths:
            if is_cancelled():
                return
            yield summarise_log(path, columns)
        return
    # Started from nothing: a copy of a process with threads may hang, and Windows knows no copies.
    pool = ProcessPoolExecutor(min(count, len(paths)), multiprocessing.get_context("spawn"))
    try:
        yield from _gathered(pool, paths, columns, is_cancelled)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _gathered(
    pool: ProcessPoolExecutor, paths: Sequence[Path], columns: CsvColumns | None, is_cancelled: Callable[[], bool]
) -> Iterator[SummarisedLog]:
    path_of: dict[Future[SummarisedLog], Path] = {pool.submit(summarise_log, path, columns): path for path in paths}
    open_ones = set(path_of)
    while open_ones:
        if is_cancelled():
            return
        done, open_ones = wait(open_ones, POLLED_S, FIRST_COMPLETED)
        for future in done:
            try:
                yield future.result()
            except BrokenProcessPool:
                yield SummarisedLog(path_of[future], None, said(marked("The process that read it ended.")))
