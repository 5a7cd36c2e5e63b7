"""Stores and a server of many facts."""

import gc
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from app.archive.archive import status_of, sync
from app.archive.report import report
from app.store.fact_store import INSERT, Facts, Store
from app.store.rows import ActIntended, ModuleVisited, SaidNew, content_text, make_row
from tests.bench.kit import Figure, at_most
from tests.support.records.archive_server import archive_server
from tests.support.records.stored import add

FACTS: Final = 600_000
MODULES: Final = 300
INTENT: Final = ActIntended(act="lock", port="/dev/ttyUSB0", frame="42 61 25 01 00 26")
INTENT_AIM_S: Final = 0.2


def _fill(facts: Facts, count: int) -> None:
    """With `count` facts of two years, of modules that are read again and again."""
    began = datetime.now(UTC) - timedelta(days=730)
    texts = [("said_new", content_text(SaidNew(is_new=True)))]
    for boot_count in range(5):
        visit = ModuleVisited(port="/dev/ttyUSB0", boot_count=boot_count, slots=[], is_confirmed=True)
        texts.append(("visit", content_text(visit)))
    rows = []
    for number in range(count):
        kind, text = texts[number % len(texts)]
        at = began + number * timedelta(days=729) / count
        rows.append(make_row(kind, text, module=f"M-{number % MODULES:03}", station=facts.station, at=at))
    facts.connection.executemany(INSERT, rows)


def archive(facts: int = FACTS) -> Iterator[Figure]:
    """An archive of 600,000 facts on a PostgreSQL server: the first exchange, a later one, what is read of it, and an
    act's intent beside all of it."""
    longest_s, is_over = 0.0, threading.Event()

    def intend(store: Store) -> None:
        """One after the other, beside all else."""
        nonlocal longest_s
        while not is_over.wait(0.02):
            began = time.perf_counter()
            add(store, INTENT).result()
            longest_s = max(longest_s, time.perf_counter() - began)

    with (
        archive_server() as server,
        tempfile.TemporaryDirectory() as folder,
        closing(Store(Path(folder) / "one")) as one,
        closing(Store(Path(folder) / "other")) as other,
    ):
        one.write(lambda facts_: _fill(facts_, facts)).result()
        # As in the window: to look through all that was ever imported keeps every thread for a tenth of a second.
        gc.collect()
        gc.freeze()
        threads = [threading.Thread(target=intend, args=[store], daemon=True) for store in (one, other)]
        for thread in threads:
            thread.start()
        steps: dict[str, tuple[Callable[[], object], float]] = {
            "the first push": (lambda: sync(one, server.url()), 60.0),
            "all of it taken over by another station": (lambda: sync(other, server.url()), 60.0),
            "a later exchange": (lambda: sync(one, server.url()), 3.0),
            "the status": (lambda: status_of(other), 2.0),
            "the report": (lambda: report(other, datetime.now(UTC)), 2.0),
        }
        for name, (work, aim_s) in steps.items():
            began = time.perf_counter()
            work()
            yield at_most(name, time.perf_counter() - began, aim_s, "{:.2f} s")
        is_over.set()
        for thread in threads:
            thread.join()
        yield at_most("the longest intent beside it", longest_s, INTENT_AIM_S, "{:.3f} s")
