"""The store: what it keeps, and the files that it meets instead of its own."""

import sqlite3
import sys
import threading
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.engine.snapshots import Snapshot, restorable
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.database import FILE_NAME, StoreFault, StoreTrouble
from app.store.facts import FactKind
from app.store.left_active import LeftActive, left_active, note_locked, note_report
from app.store.store import Store, open_store
from app.store.store_journal import KnownAs, StoreJournal
from app.system.folders import data_folder
from app.text.user_error import UserError
from tests.support.patience import PATIENCE_S
from tests.support.processes import running
from tests.support.records.kept_facts import kept_settings

FRAME = bytes.fromhex("42 61 25 01 00 26")


def noon() -> datetime:
    return datetime(2026, 1, 2, 12, 0, tzinfo=UTC)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


def test_an_intent_without_an_outcome_reads_as_unknown(folder: Path) -> None:
    with closing(open_store(folder, clock=noon)) as store:
        first = store.begin(Act.ZERO, FRAME, {"tilt_deg": 3}, port="sim://", origin="command line")
        second = store.begin(Act.LOCK, FRAME, {}, port="sim://", origin="window")
        store.settle(second, Outcome.CONFIRMED, {"active": False})
    with closing(open_store(folder)) as store:
        newest, oldest = store.audit()
        assert [fact.content["origin"] for fact in store.facts.select(FactKind.ACT)] == ["command line", "window"]
    assert (oldest.id, oldest.outcome) == (first, Outcome.UNKNOWN)
    assert (oldest.act, oldest.frame, oldest.detail) == (Act.ZERO, FRAME, {"tilt_deg": 3})
    assert oldest.at == "2026-01-02T12:00:00.000+00:00"
    assert (newest.outcome, newest.result) == (Outcome.CONFIRMED, {"active": False})


def test_an_outcome_is_written_once(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        entry = store.begin(Act.ZERO, FRAME, {}, port="p", origin="window")
        store.settle(entry, Outcome.UNKNOWN, {})
        store.settle(entry, Outcome.CONFIRMED, {})
        assert store.audit()[0].outcome is Outcome.UNKNOWN


def test_modules_and_snapshots(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        store.register_module("M-07", "usb 1")
        store.register_module("M-07", "usb 2")
        assert [(one.name, one.adapter) for one in store.modules()] == [("M-07", "usb 2")]
        store.register_module("M-07")  # who does not know the adapter takes away nothing
        assert [(one.name, one.adapter) for one in store.modules()] == [("M-07", "usb 2")]
        found = Snapshot(settings={"freefall_time_s": 1.6, "attitude_trigger": True}, boot_count=37)
        store.store_snapshot(found, port="sim://", module="M-07")
        assert kept_settings(store) == [found.settings]
        (kept,) = store.facts.select(FactKind.SNAPSHOT)
        assert (kept.content["module"], kept.content["boot_count"]) == ("M-07", 37)


def test_the_module_that_was_seen_last_is_first_whatever_the_clock_said(folder: Path) -> None:
    times = (noon() + timedelta(days=-days) for days in range(100))
    with closing(open_store(folder, clock=lambda: next(times))) as store:
        for name in ("M-1", "M-2", "M-3", "M-2", "M-1"):
            store.register_module(name, "usb 1")
        assert [module.name for module in store.modules()] == ["M-1", "M-2", "M-3"]


def test_settings_that_were_tampered_with_give_only_what_fits() -> None:
    strange = {"freefall_time_s": 99, "attitude_threshold_deg": "60", "light_threshold_v": 1.8, "other": 1}
    assert restorable(strange) == {"light_threshold_v": 1.8}


def test_a_change_of_rate_is_pending_until_it_is_settled(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        rates = {"old": 115200, "new": 9600, "adapter": "usb 1"}
        entry = store.begin(Act.CHANGE_BAUD, FRAME, rates, port="sim://", origin="window")
    with closing(open_store(folder)) as store:
        (pending,) = store.pending_bauds()
        assert (pending.id, pending.old_rate, pending.new_rate, pending.adapter) == (entry, 115200, 9600, "usb 1")
        store.settle(entry, Outcome.CONFIRMED, {"end": "changed"})
        assert store.pending_bauds() == ()


def test_the_commits_are_durable(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        assert store.database.read("PRAGMA journal_mode") == [("wal",)]
        assert store.database.read("PRAGMA synchronous") == [(2,)]  # FULL


def test_the_usual_folder_is_the_platforms(user_files: Path) -> None:
    assert data_folder().is_relative_to(user_files)


# Other files


@pytest.mark.parametrize("content", [b"not a database at all", b"SQLite format 3\x00" + b"\xff" * 5000, b"\x00" * 4096])
def test_what_is_no_database_is_set_aside_whole(folder: Path, content: bytes) -> None:
    folder.mkdir()
    (folder / FILE_NAME).write_bytes(content)
    (folder / f"{FILE_NAME}-wal").write_bytes(b"log")
    with closing(open_store(folder, clock=noon)) as store:
        store.begin(Act.ZERO, FRAME, {}, port="p", origin="window")
        assert store.database.notice is not None
    (aside,) = [path for path in folder.iterdir() if "20260102-120000" in path.name and path.suffix == ".sqlite"]
    assert aside.read_bytes() == content
    assert str(aside) in store.database.notice.in_english()
    if not content.startswith(b"SQLite"):  # else SQLite has thrown a log that does not belong to it away
        assert (folder / f"{aside.name}-wal").read_bytes() == b"log"


def test_damage_in_the_middle_is_found_at_the_opening(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        for number in range(300):
            store.begin(Act.LOCK, FRAME, {"n": number}, port="p" * 50, origin="window")
    path = folder / FILE_NAME
    data = bytearray(path.read_bytes())
    data[4096 * 3 : 4096 * 6] = b"\xa5" * 4096 * 3
    path.write_bytes(data)
    with closing(open_store(folder)) as store:
        assert store.database.notice is not None
        assert store.audit() == ()
    assert any("aside" in one.name for one in folder.iterdir())


def test_another_programs_database_is_set_aside(folder: Path) -> None:
    folder.mkdir()
    with closing(sqlite3.connect(folder / FILE_NAME)) as other:
        other.execute("CREATE TABLE audit (id INTEGER)")
        other.commit()
    for _ in range(2):
        with closing(open_store(folder, clock=noon)) as store:
            assert store.audit() == ()
    assert sum("aside" in path.name for path in folder.iterdir()) == 1


def test_a_newer_versions_file_is_left_alone(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        store.begin(Act.LOCK, FRAME, {}, port="p", origin="window")
        store.database.write("PRAGMA user_version = 99")
    with pytest.raises(StoreTrouble) as trouble:
        open_store(folder)
    assert trouble.value.fault is StoreFault.NEWER
    assert trouble.value.sentence.endswith("needs a newer version of this program.")
    with closing(sqlite3.connect(folder / FILE_NAME)) as file:
        assert file.execute("SELECT count(*) FROM facts").fetchone() == (1,)


# No room, no permission


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(StoreTrouble) as trouble:
        open_store(tmp_path / "file" / "data")
    assert trouble.value.fault is StoreFault.READ_ONLY


@pytest.mark.parametrize(
    ("pragma", "fault"), [("max_page_count = 1", StoreFault.FULL), ("query_only = ON", StoreFault.READ_ONLY)]
)
def test_a_store_that_takes_nothing_any_more_says_so(folder: Path, pragma: str, fault: StoreFault) -> None:
    with closing(open_store(folder)) as store:
        journal = StoreJournal(store, port="p", origin="window")
        entry = journal.begin(Act.ZERO, FRAME, {})
        entry.result(PATIENCE_S)
        with store.database.transaction():
            store.database.read(f"PRAGMA {pragma}")
        with pytest.raises(StoreTrouble) as trouble:
            store.begin(Act.ZERO, FRAME, {"much": "x" * 100_000}, port="p", origin="window")
        assert trouble.value.fault is fault
        with pytest.raises(UserError):
            journal.begin(Act.ZERO, FRAME, {"much": "x" * 100_000}).result(PATIENCE_S)
        journal.settle(entry, Outcome.CONFIRMED, {"much": "x" * 100_000})
        store.queue.submit(int).result(PATIENCE_S)
        assert store.audit()[0].outcome is Outcome.UNKNOWN


def test_a_file_held_by_another_program_is_said_and_not_waited_for(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.store.database.BUSY_S", 0.05)
    with closing(open_store(folder)) as store, closing(sqlite3.connect(folder / FILE_NAME)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(StoreTrouble) as trouble:
            store.begin(Act.ZERO, FRAME, {}, port="p", origin="window")
        assert trouble.value.fault is StoreFault.BUSY


def test_a_file_that_another_program_holds_for_a_moment_is_waited_for(folder: Path) -> None:
    """Several commands at once, on a slow card: what the last one had to keep was lost."""
    with (
        closing(open_store(folder)) as store,
        closing(sqlite3.connect(folder / FILE_NAME, check_same_thread=False)) as held,
    ):
        held.execute("BEGIN EXCLUSIVE")
        release = threading.Timer(1.3, held.rollback)
        release.start()
        store.begin(Act.ZERO, FRAME, {}, port="p", origin="window")
        release.join()
        assert len(store.audit()) == 1


def test_what_is_written_together_is_there_whole_or_not_at_all(folder: Path) -> None:
    with closing(open_store(folder)) as store, closing(sqlite3.connect(folder / FILE_NAME)) as other:

        def names() -> list[str]:
            return [name for (name,) in other.execute("SELECT module FROM facts ORDER BY module")]

        with store.database.transaction():
            store.register_module("M-07")
            with store.database.transaction():
                store.register_module("M-08")
            assert names() == []
        assert names() == ["M-07", "M-08"]

        def break_off(statement: str) -> None:
            with store.database.transaction():
                store.register_module("M-09")
                store.database.write(statement, (1,))

        with pytest.raises(StoreTrouble):
            break_off("INSERT INTO nowhere VALUES (?)")
        with pytest.raises(TypeError):
            break_off(None)  # type: ignore[arg-type]
        store.register_module("M-10")
        assert names() == ["M-07", "M-08", "M-10"]


def test_a_closed_store_says_so_and_closing_twice_is_fine(folder: Path) -> None:
    store = open_store(folder)
    store.close()
    store.close()
    with pytest.raises(StoreTrouble):
        store.audit()
    with pytest.raises(StoreTrouble), store.database.transaction():
        store.register_module("M-07")


# Killed


_WRITER = """
import sys
from pathlib import Path
from app.safety.acts import Act
from app.store.store import open_store
store = open_store(Path(sys.argv[1]))
while True:
    entry = store.begin(Act.DEPLOY, b"Ba", {}, port="p", origin="window")
    print(entry, flush=True)
"""


def test_what_was_acknowledged_survives_kill_9(folder: Path) -> None:
    acknowledged: list[int] = []
    for run in range(3):
        with running(sys.executable, "-c", _WRITER, folder) as writer:
            acknowledged += [int(writer.out.readline()) for _ in range(20 + 7 * run)]
            writer.process.kill()
            acknowledged += [int(line) for line in writer.out.read().split("\n")[:-1]]
        with closing(open_store(folder)) as store:
            kept = {entry.id for entry in store.audit()}
            assert store.database.notice is None
            assert set(acknowledged) <= kept
            assert all(entry.outcome is Outcome.UNKNOWN for entry in store.audit())
    assert len(acknowledged) >= 20 + 27 + 34


# What the log leaves ACTIVE, as is said at the next start


USB, OTHER = "/dev/ttyUSB0", "/dev/ttyUSB1"
CONFIRMED, REFUSED, UNKNOWN, NOT_SENT = Outcome
ACTIVE, LOCK_IN_DOUBT = "ACTIVE", "LOCK?"
Row = tuple[Act, Outcome | None, str, str]
"""Act, outcome, module, run of the program."""


@pytest.fixture
def store(folder: Path) -> Iterator[Store]:
    with closing(open_store(folder)) as opened:
        yield opened


def left(store: Store) -> list[tuple[str, str]]:
    found = left_active(store)
    return [(one.known_as.name or one.port, LOCK_IN_DOUBT if one.is_lock_unconfirmed else ACTIVE) for one in found]


def log(store: Store, act: Act, outcome: Outcome | None, module: str, run: str, port: str = USB) -> None:
    detail = {"module": module, "adapter": "", "run": run}
    entry = store.begin(act, b"AB", detail, port=port, origin="window")
    if outcome is not None:  # else the program was killed in between
        store.settle(entry, outcome, {})


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a")], [("M-07", ACTIVE)]),
        ([(Act.ACTIVATE, UNKNOWN, "M-07", "a")], [("M-07", ACTIVE)]),
        ([(Act.ACTIVATE, None, "M-07", "a")], [("M-07", ACTIVE)]),
        ([(Act.ACTIVATE, REFUSED, "M-07", "a")], []),
        ([(Act.ACTIVATE, NOT_SENT, "M-07", "a")], []),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.LOCK, CONFIRMED, "M-07", "b")], []),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.LOCK, CONFIRMED, "M-08", "b")], [("M-07", ACTIVE)]),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.LOCK, CONFIRMED, "", "b")], [("M-07", ACTIVE)]),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.LOCK, UNKNOWN, "M-07", "a")], [("M-07", LOCK_IN_DOUBT)]),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.LOCK, None, "M-07", "a")], [("M-07", LOCK_IN_DOUBT)]),
        ([(Act.LOCK, UNKNOWN, "M-07", "a")], [("M-07", LOCK_IN_DOUBT)]),
        ([(Act.LOCK, UNKNOWN, "M-07", "a"), (Act.LOCK, CONFIRMED, "M-07", "a")], []),
        ([(Act.ACTIVATE, CONFIRMED, "M-07", "a"), (Act.SHUTDOWN, CONFIRMED, "M-07", "a")], []),
        # Without a name it is known only within one run of the program.
        ([(Act.ACTIVATE, CONFIRMED, "", "a"), (Act.LOCK, CONFIRMED, "", "a")], []),
        ([(Act.ACTIVATE, CONFIRMED, "", "a"), (Act.LOCK, CONFIRMED, "", "b")], [(USB, ACTIVE)]),
        ([(Act.ACTIVATE, CONFIRMED, "", "a"), (Act.LOCK, CONFIRMED, "M-07", "a")], []),
    ],
)
def test_what_is_left_active(store: Store, rows: list[Row], expected: list[tuple[str, str]]) -> None:
    for act, outcome, module, run in rows:
        log(store, act, outcome, module, run)
    assert left(store) == expected


def test_a_simulated_module_is_never_left(store: Store) -> None:
    log(store, Act.ACTIVATE, CONFIRMED, "M-07", "a", port="sim://one")
    assert left(store) == []


def note(store: Store, module: str, *, is_active: bool) -> None:
    note_report(store, LeftActive(KnownAs(module), USB, ""), "window", is_active=is_active)


def wait(store: Store) -> None:
    store.queue.submit(lambda: None).result(PATIENCE_S)


def test_only_a_report_that_differs_from_the_log_is_added(store: Store) -> None:
    note(store, "M-07", is_active=False)
    wait(store)
    assert store.audit() == ()
    for is_active in (True, True, False, False):
        note(store, "M-07", is_active=is_active)
        wait(store)
        assert left(store) == ([("M-07", ACTIVE)] if is_active else [])
    assert [(one.act, one.frame, one.result["sent"]) for one in store.audit()] == [
        (Act.LOCK, b"", 0), (Act.ACTIVATE, b"", 0),
    ]  # fmt: skip


def test_another_module_ends_nothing_and_a_person_does(store: Store) -> None:
    log(store, Act.ACTIVATE, CONFIRMED, "", "a")
    log(store, Act.ACTIVATE, CONFIRMED, "M-07", "a", port=OTHER)
    for module in ("", "M-08"):
        note(store, module, is_active=False)
        wait(store)
    assert sorted(left(store)) == [(USB, ACTIVE), ("M-07", ACTIVE)]
    for one in left_active(store):
        note_locked(store, one, "window")
    wait(store)
    assert left(store) == []
