"""100,000 facts, from one station to a PostgreSQL server and from there to another, empty station."""

import tempfile
import time
from contextlib import ExitStack, closing
from datetime import timedelta
from pathlib import Path
from typing import Final

from app.archive.content import FactKind
from app.archive.exchange import exchange
from app.archive.facts import make_fact
from app.archive.postgres import open_server
from tests.benchmarks.figures import Figure
from tests.support.archive_server import archive_server, server_programs
from tests.support.records.archive_stations import NOON, ArchiveStation, archive_station, slot

FACTS: Final = 100_000
AIM_S: Final = 60.0
_PAGE: Final = 1000


def figures(count: int = FACTS) -> list[Figure]:
    if server_programs() is None:
        return [Figure(f"{count:,} facts", "not measured: PostgreSQL is not installed here")]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        server = stack.enter_context(archive_server())
        one, other = (stack.enter_context(archive_station(folder / name)) for name in "AB")
        began = time.perf_counter()
        _fill(one, count)
        filled = time.perf_counter()
        worked = time.process_time()
        sent = _sync(one, server.url())
        received = _sync(other, server.url())
        worked = time.process_time() - worked
        again = _sync(other, server.url())
        both = sent + received
        return [
            Figure(f"{count:,} facts signed and kept", f"{filled - began:.1f} s"),
            Figure(f"{count:,} facts to the server", f"{sent:.1f} s"),
            Figure(f"{count:,} facts from the server, each checked", f"{received:.1f} s"),
            Figure(f"{count:,} facts synchronised, both ways together", f"{both:.1f} s; {worked:.1f} s of "
                   "processor time without the server", f"<= {AIM_S:g} s", is_met=both <= AIM_S),
            Figure("once more, with nothing new", f"{again:.2f} s"),
        ]  # fmt: skip


def _fill(one: ArchiveStation, count: int) -> None:
    """Trigger records of fifty modules."""
    for start in range(0, count, _PAGE):
        facts = []
        for number in range(start, min(count, start + _PAGE)):
            at = (NOON + timedelta(seconds=number)).isoformat(timespec="milliseconds")
            content = {"module": f"M-{number % 50:02}", "place": number, "raw": slot(number % 60_000).hex()}
            facts.append(make_fact(FactKind.TRIGGER_RECORD, at, content, one.station))
        one.facts.add(facts)


def _sync(one: ArchiveStation, url: str) -> float:
    began = time.perf_counter()
    with closing(open_server(url)) as server:
        exchange(one.facts, server)
    return time.perf_counter() - began
