"""An archive of 600,000 facts on a PostgreSQL server: the first exchange, a later one, what is read of it, and an act's
intent beside all of it."""

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
from tests.bench.kit import Figure
from tests.support.records.archive_server import archive_server

FACTS: Final = 600_000
MODULES: Final = 300
INTENT: Final = ActIntended(act="lock", port="/dev/ttyUSB0", frame="42 61 25 01 00 26")
INTENT_AIM_S: Final = 0.2


def _fill(facts: Facts, count: int) -> None:
    """With `count` facts of two years, of modules that are read again and again."""
    began = datetime.now(UTC) - timedelta(days=730)
    texts = [("said_new", content_text(SaidNew(is_new=True)))]
    for boot_count in range(5):
        visit = ModuleVisited(port="/dev/ttyUSB0", boot_count=boot_count, slots=[], is_confirmed=True, known=0)
        texts.append(("visit", content_text(visit)))
    rows = []
    for number in range(count):
        kind, text = texts[number % len(texts)]
        at = began + number * timedelta(days=729) / count
        rows.append(make_row(kind, text, module=f"M-{number % MODULES:03}", station=facts.station, at=at))
    facts.connection.executemany(INSERT, rows)


class _Intents:
    """An intent after the other, in a thread, until `end`; `longest_s` is the time of the slowest."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._is_over = threading.Event()
        self.longest_s = 0.0
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._is_over.wait(0.02):
            began = time.perf_counter()
            self._store.add(INTENT).result()
            self.longest_s = max(self.longest_s, time.perf_counter() - began)

    def end(self) -> None:
        self._is_over.set()
        self._thread.join()


def _timed(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def figures(*, facts: int = FACTS) -> Iterator[Figure]:
    with (
        archive_server() as server,
        tempfile.TemporaryDirectory() as folder,
        closing(Store(Path(folder) / "one")) as one,
        closing(Store(Path(folder) / "other")) as other,
    ):
        one.write(lambda facts_: _fill(facts_, facts)).result()
        here, there = _Intents(one), _Intents(other)
        steps: dict[str, tuple[Callable[[], object], float | None]] = {
            "the first push": (lambda: sync(one, server.url()), 60.0),
            "all of it taken over by another station": (lambda: sync(other, server.url()), None),
            "a later exchange": (lambda: sync(one, server.url()), 3.0),
            "the status": (lambda: status_of(other), 2.0),
            "the report": (lambda: report(other, datetime.now(UTC)), 2.0),
        }
        for name, (work, aim_s) in steps.items():
            took_s = _timed(work)
            aim = "" if aim_s is None else f"<= {aim_s:.0f} s"
            yield Figure(name, f"{took_s:.2f} s", aim, None if aim_s is None else took_s <= aim_s)
        here.end()
        there.end()
        longest_s = max(here.longest_s, there.longest_s)
        is_met = longest_s <= INTENT_AIM_S
        yield Figure("the longest intent beside it", f"{longest_s:.3f} s", f"<= {INTENT_AIM_S:g} s", is_met)
