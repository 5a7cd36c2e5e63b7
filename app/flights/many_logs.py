"""Reads and summarises many logs in worker processes."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Final, NamedTuple

from app.flights.columns import CsvColumns
from app.flights.curves import JudgedFlight, judge_flight
from app.flights.flight_log import NO_PROGRESS, Progress, unreadable
from app.flights.judge import TriggerLimits
from app.flights.module_view import RuleReading
from app.flights.read_log import read_flight_log
from app.flights.summary import FlightSummary, summarise
from app.text.messages import UserMessage
from app.text.user_error import UserError
from protocol.translatable import marked

FEW_LOGS: Final = 4
"""Fewer logs are read in this process, since starting workers takes longer."""
MAX_PROCESSES: Final = 60
"""Windows cannot wait for more."""
POLLED_S: Final = 0.1
"""Longest delay of a cancellation."""


class SummarisedLog(NamedTuple):
    """`flight` is None where the log cannot be read; then `why_not` says why."""

    path: Path
    flight: FlightSummary | None
    why_not: UserMessage | None = None
    judged: tuple[JudgedFlight, ...] = ()
    """One per `RuleReading`, where the order has `limits`."""


class LogOrder(NamedTuple):
    columns: CsvColumns | None = None
    """Of CSV files; None recognises them by name."""
    limits: TriggerLimits | None = None
    """Also judge each log with these; None makes the curves only."""


PLAIN: Final = LogOrder()


class _Cancelled(Exception):
    """In the middle of a log."""


def summarise_log(path: Path, order: LogOrder = PLAIN, on_progress: Progress = NO_PROGRESS) -> SummarisedLog:
    """Reads and summarises one log. Raises only what `on_progress` raises."""
    try:
        log = read_flight_log(path, order.columns, on_progress)
        summary = summarise(log)
        limits = order.limits
        judged = () if limits is None else tuple(judge_flight(log, limits, reading) for reading in RuleReading)
        return SummarisedLog(path, summary, judged=judged)
    except UserError as error:
        return SummarisedLog(path, None, error.message)


def summarise_logs(
    paths: Sequence[Path],
    order: LogOrder = PLAIN,
    *,
    is_cancelled: Callable[[], bool] = lambda: False,
    on_progress: Progress = NO_PROGRESS,
    processes: int | None = None,
) -> Iterator[SummarisedLog]:
    """Yields a result per log as they are done; fewer when cancelled.

    Blocks: call it in a thread of its own, which polls `is_cancelled` about ten times a second. `processes`: None uses
    one per processor. `on_progress`: with the share of the log that is read, where few are read one after another.
    """

    def go_on(share: float) -> None:
        if is_cancelled():
            raise _Cancelled
        on_progress(share)

    count = processes if processes is not None else os.cpu_count() or 1
    if len(paths) < FEW_LOGS or count < 2:
        for path in paths:
            if is_cancelled():
                return
            try:
                summarised = summarise_log(path, order, go_on)
            except _Cancelled:
                return
            yield summarised
        return
    waiting = deque(paths)
    while waiting and not is_cancelled():
        processes = min(count, MAX_PROCESSES, len(waiting))
        suspects = deque((yield from _in_processes(waiting, order, is_cancelled, processes, ahead=2 * processes)))
        while suspects and not is_cancelled():  # one of them crashed its process: read one at a time to find it
            for path in (yield from _in_processes(suspects, order, is_cancelled, 1, ahead=1)):
                yield SummarisedLog(path, None, unreadable(marked("cannot be read")).message)


def _in_processes(
    waiting: deque[Path], order: LogOrder, is_cancelled: Callable[[], bool], processes: int, *, ahead: int
) -> Generator[SummarisedLog, None, list[Path]]:
    """Takes from `waiting` until it is empty or a process crashed; returns the logs that were being read then.

    `ahead`: logs submitted at a time; a cancellation waits for those that have begun.
    """
    # Spawned, because a fork of a process with threads may hang, and Windows has none.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, context, initializer=_begin_worker)
    path_of: dict[Future[SummarisedLog], Path] = {}
    suspects: list[Path] = []
    try:
        while (waiting and not suspects) or path_of:
            if is_cancelled():
                return []
            while waiting and not suspects and len(path_of) < ahead:
                try:
                    path_of[pool.submit(summarise_log, waiting[0], order)] = waiting[0]
                except BrokenProcessPool:  # the submitted logs raise it, too
                    if not path_of:
                        suspects.append(waiting.popleft())
                    break
                waiting.popleft()
            done, _ = wait(path_of, POLLED_S, FIRST_COMPLETED)
            for future in done:
                path = path_of.pop(future)
                try:
                    yield future.result()
                except BrokenProcessPool:
                    suspects.append(path)
        return suspects
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


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
