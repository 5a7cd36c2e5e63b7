"""Reads and summarises many logs in worker processes."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Final, NamedTuple

from app.flights.columns import CsvColumns
from app.flights.judge import TriggerLimits
from app.flights.judging import LogFiring, RuleReading, first_firings
from app.flights.raw_log import unreadable
from app.flights.read_log import read_flight_log
from app.flights.summary import FlightSummary, summarise
from app.flights.table import UnreadTable
from app.text.messages import UserMessage
from app.text.user_error import UserError
from protocol.translatable import marked

FEW_LOGS: Final = 4
"""Fewer logs are read in this process, since starting workers takes longer."""
POLLED_S: Final = 0.1
"""Longest delay of a cancellation."""


class SummarisedLog(NamedTuple):
    """`flight` is None where the log cannot be read; then `why_not` says why."""

    path: Path
    flight: FlightSummary | None
    why_not: UserMessage | None = None
    # With the thresholds of the order.
    firings: tuple[LogFiring, ...] = ()
    # The names of the columns of a table that cannot be read.
    head: tuple[str, ...] = ()


class LogOrder(NamedTuple):
    """`columns`: of tables, None recognises them by name. `limits`: with which it is asked what fires first."""

    columns: CsvColumns | None = None
    limits: TriggerLimits = TriggerLimits()


def summarise_log(path: Path, order: LogOrder) -> SummarisedLog:
    """Reads and summarises one log."""
    try:
        log = read_flight_log(path, order.columns)
    except UserError as error:
        head = error.head if isinstance(error, UnreadTable) else ()
        return SummarisedLog(path, None, error.message, head=head)
    summary = summarise(log)
    firings = first_firings(log, summary.curves[RuleReading.DIRECT], order.limits)
    return SummarisedLog(path, summary, firings=tuple(firings))


def summarise_logs(
    paths: Sequence[Path],
    order: LogOrder,
    *,
    is_cancelled: Callable[[], bool] = lambda: False,
    processes: int | None = None,
) -> Iterator[SummarisedLog]:
    """Yields a result per log as they are done; fewer when cancelled.

    Blocks: call it in a thread of its own, which polls `is_cancelled` about ten times a second. `processes`: None uses
    one per processor.
    """
    count = min(processes or os.cpu_count() or 1, len(paths))
    if len(paths) < FEW_LOGS or count < 2:
        for path in paths:
            if is_cancelled():
                return
            yield summarise_log(path, order)
        return
    waiting = deque(paths)
    idle = [_new_worker() for _ in range(count)]
    reading: dict[Future[SummarisedLog], tuple[Path, ProcessPoolExecutor]] = {}
    try:
        while (waiting or reading) and not is_cancelled():
            while waiting and idle:
                path, worker = waiting.popleft(), idle.pop()
                reading[worker.submit(summarise_log, path, order)] = path, worker
            done, _ = wait(reading, POLLED_S, FIRST_COMPLETED)
            for future in done:
                path, worker = reading.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):  # this log crashed its process
                    worker.shutdown()
                    idle.append(_new_worker())
                    yield SummarisedLog(path, None, unreadable(marked("cannot be read")).message)
                else:
                    idle.append(worker)
                    yield future.result()
    finally:
        for worker in (*idle, *(worker for _, worker in reading.values())):
            worker.shutdown(cancel_futures=True)


def _new_worker() -> ProcessPoolExecutor:
    """One process, so that a crash costs the one log that it reads.

    Spawned, because a fork of a process with threads may hang, and Windows has none.
    """
    return ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=_begin_worker)


def _begin_worker() -> None:
    """Ignores Ctrl-C, which the parent process handles, and ends with the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_program, name="dps-s program", daemon=True).start()


def _end_with_program() -> None:
    """A killed parent does not end its workers."""
    program = multiprocessing.parent_process()
    if program is not None:
        program.join()
    os._exit(1)
