"""Three stations and a server, whatever happens in whatever order: in the end all know the same, all of it, once.

Longer: `python -m tests.app.archive.test_stations_stateful SEED STEPS`
"""

import random
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.archive.chains import chains_in
from app.archive.exchange import Exchanged, export_facts, import_facts, status_of, sync
from app.archive.module_names import names_of
from app.guided.results import GuidedVerdict
from app.text.user_error import UserError
from app.trigger_records.history import Judgement
from tests.support.processes import ran_code
from tests.support.records.archive_server import ArchiveServer, archive_server
from tests.support.records.archive_stations import NOON, ArchiveStation, archive_station

NAMES = ("M-01", "M-02", "M-03")
_KILLED = """
import os, signal, sys
from pathlib import Path
from app.archive.archive import Archive
from app.archive.exchange import sync
from app.store.database import Database
from app.store.store import open_store

left, write = int(sys.argv[3]), Database.write_all

def count_down(*_):
    global left
    left -= 1
    if left <= 0:
        os.kill(os.getpid(), signal.SIGKILL)

def counted(self, *written):
    write(self, *written)
    if sys.argv[4] == "while signing":
        count_down()

Database.write_all = counted
archive = Archive(open_store(Path(sys.argv[1])))
sync(archive, sys.argv[2], on_page=count_down)
os.kill(os.getpid(), signal.SIGKILL)
"""


@dataclass
class Desk:
    """Everything of one run. `clocks`: how wrong each station's clock is."""

    folder: Path
    server: ArchiveServer
    dice: random.Random
    stack: ExitStack = field(default_factory=ExitStack)
    stations: list[ArchiveStation] = field(default_factory=list)
    clocks: list[timedelta] = field(default_factory=lambda: [timedelta()] * 3)
    ticks: int = 0

    def open(self) -> None:
        self.stations = [
            self.stack.enter_context(archive_station(self.folder / name, clock=self._clock(number)))
            for number, name in enumerate("ABC")
        ]

    def _clock(self, number: int) -> Callable[[], datetime]:
        def now() -> datetime:
            self.ticks += 1
            return (NOON + timedelta(seconds=self.ticks) + self.clocks[number]).astimezone(UTC)

        return now

    # What may happen

    def record(self) -> None:
        one, module = self.dice.choice(self.stations), self.dice.choice(NAMES)
        self.dice.choice((
            lambda: one.visit(module, *range(self.dice.randint(1, 9))),
            lambda: one.judge(module, self.dice.choice(list(Judgement))),
            lambda: one.snapshot(module, self.dice.randint(30, 90)),
            lambda: one.test(module, self.dice.choice(list(GuidedVerdict))),
            lambda: one.act(is_settled=self.dice.random() < 0.7),
            lambda: one.check(module),
        ))()  # fmt: skip

    def record_much(self) -> None:
        for _ in range(10):
            self.record()

    def set_clock(self) -> None:
        self.clocks[self.dice.randrange(3)] = timedelta(days=self.dice.randint(-20, 20))

    def sync(self) -> None:
        done = sync(self.dice.choice(self.stations).archive, self.server.url())
        assert done.is_whole

    def sync_cut_off(self) -> None:
        """The server ends the connection in the middle."""
        left = self.dice.randint(1, 5)

        def cut(_done: Exchanged) -> None:
            nonlocal left
            left -= 1
            if left == 0:
                self.server.run(
                    "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity WHERE pid <> pg_backend_pid() "
                    "AND datname = 'archive'"
                )

        with suppress(UserError):
            sync(self.dice.choice(self.stations).archive, self.server.url(), on_page=cut)

    def sync_killed(self) -> None:
        """The program is killed in the middle, as by kill -9."""
        one = self.dice.choice(self.stations)
        when = self.dice.choice(("while signing", "while exchanging"))
        killed = ran_code(_KILLED, one.folder, self.server.url(), self.dice.randint(1, 4), when)
        assert killed.returncode == -9, killed.stderr

    def carry_a_stick(self) -> None:
        one, other = self.dice.sample(self.stations, 2)
        stick = self.folder / "stick"
        export_facts(one.archive, stick)
        assert import_facts(other.archive, stick).is_whole

    # What must be so

    def end(self) -> None:
        for one in (*self.stations, *self.stations):
            sync(one.archive, self.server.url())
        everything = self.stations[0].content()
        assert all(station.content() == everything for station in self.stations), "not all know the same"
        rows = self.server.run("SELECT id, kind, station, made_at, payload, signature FROM dps_s_facts ORDER BY id")
        assert rows == everything, "the server knows something else"
        recorded = sum(len(station.store.database.read("SELECT 1 FROM facts")) for station in self.stations)
        assert len(everything) == recorded, "something was lost or invented"
        for station in self.stations:
            assert station.store.facts.faults() == []
            assert [chain.missing for chain in chains_in(station.archive)] == [0] * len(chains_in(station.archive))
        names = [names_of(station.archive) for station in self.stations]
        assert names[0] == names[1] == names[2]
        for station in self.stations:
            assert status_of(station.archive, self.server.url()).not_shared == 0


OFTEN = (Desk.record, Desk.record, Desk.record_much, Desk.sync, Desk.sync, Desk.set_clock,
         Desk.sync_cut_off, Desk.carry_a_stick)  # fmt: skip


def run(server: ArchiveServer, folder: Path, seed: int, steps: int, kills: int) -> None:
    server.run("DROP TABLE IF EXISTS dps_s_facts")
    dice = random.Random(seed)
    desk = Desk(folder, server, dice)
    with desk.stack:
        desk.open()
        acts = [*(dice.choice(OFTEN) for _ in range(steps)), *[Desk.sync_killed] * kills]
        dice.shuffle(acts)
        desk.record_much()
        for act in acts:
            act(desk)
        desk.end()


@pytest.mark.parametrize("seed", [1, 2])
def test_all_end_equal_nothing_is_lost_and_nothing_doubled(server: ArchiveServer, tmp_path: Path, seed: int) -> None:
    run(server, tmp_path, seed, steps=25, kills=3)


def test_a_program_that_loses_a_page_is_found_out(
    server: ArchiveServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The test can fail: a sync that claims to have shared what it left out."""
    from app.archive.postgres import PostgresFacts

    monkeypatch.setattr(PostgresFacts, "add", lambda _self, facts: len(facts))
    with pytest.raises(AssertionError, match="not all know the same"):
        run(server, tmp_path, 3, steps=6, kills=0)


if __name__ == "__main__":
    _first, _steps = map(int, sys.argv[1:])
    with archive_server() as _server:
        for _seed in range(_first, _first + 100):
            with tempfile.TemporaryDirectory() as _folder:
                run(_server, Path(_folder), _seed, _steps, 5)
            print(_seed, flush=True)
