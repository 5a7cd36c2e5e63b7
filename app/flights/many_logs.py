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

from app.flights.judging import FlightSummary, summarise
from app.flights.raw_log import unreadable
from app.flights.read_log import read_flight_log
from app.flights.table import CsvColumns, UnreadTable
from app.text.messages import UserError, UserMessage
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
    # The names of the columns of a table that cannot be read.
    head: tuple[str, ...] = ()


def summarise_log(path: Path, columns: CsvColumns | None = None) -> SummarisedLog:
    """Reads and summarises one log. `columns`: of a table, None recognises them by name."""
    try:
        return SummarisedLog(path, summarise(read_flight_log(path, columns)))
    except UserError as error:
        head = error.head if isinstance(error, UnreadTable) else ()
        return SummarisedLog(path, None, error.message, head)


def summarise_logs(
    paths: Sequence[Path],
    columns: CsvColumns | None = None,
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
            yield summarise_log(path, columns)
        return
    waiting = deque(paths)
    reading: dict[Future[SummarisedLog], Path] = {}
    # Spawned, because a fork of a process with threads may hang, and Windows has none.
    workers = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), initializer=_begin_worker)
    try:
        while (waiting or reading) and not is_cancelled():
            while waiting and len(reading) < 2 * count:
                future = workers.submit(summarise_log, waiting[0], columns)
                reading[future] = waiting.popleft()
            done, _ = wait(reading, POLLED_S, FIRST_COMPLETED)
            for future in done:
                result = future.result()
                del reading[future]
                yield result
    except BrokenProcessPool:  # a process was killed, such as for want of memory
        why_not = unreadable(marked("the program that reads it ended")).message
        for path in (*reading.values(), *waiting):
            yield SummarisedLog(path, None, why_not)
    finally:
        workers.shutdown(cancel_futures=True)


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
