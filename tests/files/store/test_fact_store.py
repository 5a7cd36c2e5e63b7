"""The store: what it keeps, and the files that it meets instead of its own."""

import sqlite3
import stat
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.store.fact_store import Facts, Store
from app.store.opening import FILE_NAME, LAYOUT, StoreFault, StoreTrouble, copies_of, copy_if_due
from app.store.rows import ActIntended, SaidNew, Serviced, SettingsSeen, StationNamed
from tests.support.patience import PATIENCE_S

NOON = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)
INTENT = ActIntended(act="lock", port="/dev/ttyUSB0", frame="42 61 25 01 00 26")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


@contextmanager
def opened(folder: Path, at: datetime = NOON) -> Iterator[Store]:
    with closing(Store(folder, clock=lambda: at)) as store:
        yield store


def said(store: Store) -> list[tuple[str | None, bool]]:
    return [(kept.row.module, kept.content.is_new) for kept in store.read(lambda facts: facts.of_kind(SaidNew))]


def notice(store: Store) -> str:
    found = store.opened.result(PATIENCE_S)
    return "" if found is None else found.in_english()


def test_what_is_added_is_there_after_the_program_ended(folder: Path) -> None:
    with opened(folder) as store:
        first = store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
        second = store.add(SaidNew(is_new=False), "M-08").result(PATIENCE_S)
        store.set_state("stream:A", {"boot_count": 3})
        store.set_state("stream:B", 1)
        store.set_state("stream:B", None)
    assert first.id < second.id or first.made_at < second.made_at  # also within one tick of the clock
    with opened(folder) as store:
        assert said(store) == [("M-07", True), ("M-08", False)]
        assert store.read(lambda facts: facts.states("stream:")) == {"A": {"boot_count": 3}}
        assert store.read(lambda facts: facts.modules()) == ["M-07", "M-08"]


def test_the_station_introduces_itself_once(folder: Path) -> None:
    for _ in range(2):
        with opened(folder) as store:
            (kept,) = store.read(lambda facts: facts.of_kind(StationNamed))
            assert kept.content.public_key == kept.row.station == store.station


@pytest.mark.parametrize(
    "statement",
    ["UPDATE facts SET module = 'M-08'", "DELETE FROM facts", "INSERT OR REPLACE INTO facts SELECT * FROM facts"],
)
def test_facts_are_only_ever_added(statement: str, folder: Path) -> None:
    with opened(folder) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
        with pytest.raises(StoreTrouble):
            store.write(lambda facts: facts.connection.execute(statement)).result(PATIENCE_S)
        assert said(store) == [("M-07", True)]


@pytest.mark.parametrize(
    "content",
    [
        SettingsSeen(port="p", boot_count=1, settings={"light_threshold_v": float("nan")}),
        SettingsSeen(port="p", boot_count=256, settings={}),
        Serviced(service="repack", on=NOON.date(), due=None, who="x" * 401),
    ],
)
def test_what_could_not_be_read_again_is_refused_where_it_is_made(content: Serviced, folder: Path) -> None:
    with opened(folder) as store, pytest.raises(ValueError):
        store.add(content, "M-07")


def test_a_piece_of_work_is_kept_whole_or_not_at_all_and_its_fault_is_told_as_what_it_is(folder: Path) -> None:
    def fail(facts: Facts) -> None:
        facts.add(SaidNew(is_new=True), "M-07")
        raise TypeError("a fault of the program")

    with opened(folder) as store:
        with pytest.raises(TypeError, match="a fault of the program"):
            store.write(fail).result(PATIENCE_S)
        assert said(store) == []


def test_an_intent_that_is_taken_back_in_time_is_never_written(folder: Path) -> None:
    go_on = threading.Event()
    with opened(folder) as store:
        store.opened.result(PATIENCE_S)
        busy = store.write(lambda _facts: go_on.wait(PATIENCE_S))
        intent = store.add(INTENT)
        assert intent.cancel()
        go_on.set()
        assert busy.result(PATIENCE_S)
        with pytest.raises(CancelledError):
            intent.result(PATIENCE_S)
        assert store.read(lambda facts: facts.of_kind(ActIntended)) == []


def test_a_fact_from_the_future_counts_for_nothing(folder: Path) -> None:
    with opened(folder, at=datetime.now(UTC) + timedelta(days=2)) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
        assert said(store) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such rights")
def test_its_folder_is_for_this_user_only(folder: Path) -> None:
    folder.mkdir(mode=0o777)
    with opened(folder) as store:
        store.opened.result(PATIENCE_S)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


# Copies, and what takes the place of a file that is damaged, gone or another's


def copied(folder: Path, at: datetime = NOON) -> Path:
    """The copy of that day."""
    path = folder / FILE_NAME
    copy_if_due(path, at)
    return copies_of(path)[0]


@pytest.mark.promise("f")
def test_a_copy_a_day_is_kept_of_the_last_seven(folder: Path) -> None:
    with opened(folder, NOON - timedelta(days=1)) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
    for day in range(9):
        copied(folder, NOON + timedelta(days=day))
        copied(folder, NOON + timedelta(days=day, hours=1))
    names = [copy.name for copy in copies_of(folder / FILE_NAME)]
    assert names == [f"dps-s.202601{day:02}.sqlite" for day in range(10, 3, -1)]


def test_a_store_with_something_in_it_is_copied_when_it_is_opened(folder: Path) -> None:
    for copies in ([], ["dps-s.20260102.sqlite"]):
        with opened(folder) as store:
            store.write(lambda _facts: None).result(PATIENCE_S)  # the copy is begun before that
            assert store._copying is not None
            store._copying.join(PATIENCE_S)
            store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
        assert [copy.name for copy in copies_of(folder / FILE_NAME)] == copies


def damage(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[200:] = b"\xff" * (len(data) - 200)
    path.write_bytes(data)


@pytest.mark.parametrize("what", ["damaged", "no database", "empty", "gone"])
@pytest.mark.promise("f")
def test_the_newest_whole_copy_takes_the_place_of_a_file_that_cannot_be_used(what: str, folder: Path) -> None:
    with opened(folder, NOON - timedelta(days=1)) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
    copied(folder)
    with opened(folder) as store:
        store.add(SaidNew(is_new=True), "later").result(PATIENCE_S)
    damage(copied(folder, NOON + timedelta(days=1)))
    path = folder / FILE_NAME
    if what == "damaged":
        damage(path)
    elif what == "gone":
        path.unlink()
    else:
        path.write_bytes(b"" if what == "empty" else b"something else" * 1000)
    with opened(folder) as store:
        assert "Records restored from the copy of 20260102; later ones are missing." in notice(store)
        assert said(store) == [("M-07", True)]
    kept = [file.name for file in folder.glob("dps-s.aside-*.sqlite")]
    assert len(kept) == (0 if what == "gone" else 1)
    with opened(folder) as store:
        assert notice(store) == ""


def test_a_log_that_a_lost_file_left_behind_spoils_no_copy(folder: Path) -> None:
    with opened(folder, NOON - timedelta(days=1)) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
    copied(folder)
    path = folder / FILE_NAME
    with closing(sqlite3.connect(path, isolation_level=None)) as kept_open, opened(folder) as store:
        kept_open.execute("SELECT 1 FROM facts").fetchone()
        for number in range(50):
            store.add(SaidNew(is_new=True), f"later {number}").result(PATIENCE_S)
        log = path.with_name(f"{FILE_NAME}-wal").read_bytes()
    assert log
    path.unlink()
    path.with_name(f"{FILE_NAME}-wal").write_bytes(log)
    with opened(folder) as store:
        assert said(store) == [("M-07", True)]
        assert store.read(lambda facts: facts.connection.execute("PRAGMA integrity_check").fetchall()) == [("ok",)]


def test_without_a_copy_a_damaged_file_is_set_aside_and_said(folder: Path) -> None:
    folder.mkdir()
    (folder / FILE_NAME).write_bytes(b"SQLite format 3\x00" + bytes(1000))
    with opened(folder) as store:
        assert notice(store).startswith("The records cannot be used and are kept as ")
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)


def test_a_file_of_a_newer_version_is_left_alone(folder: Path) -> None:
    with opened(folder) as store:
        store.add(SaidNew(is_new=True), "M-07").result(PATIENCE_S)
    path = folder / FILE_NAME
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(f"PRAGMA user_version = {LAYOUT + 1}")
    before = path.read_bytes()
    with opened(folder) as store, pytest.raises(StoreTrouble) as caught:
        store.opened.result(PATIENCE_S)
    assert caught.value.fault is StoreFault.NEWER
    assert path.read_bytes() == before


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no loops of links")
def test_a_folder_that_may_not_be_entered_is_one_sentence(tmp_path: Path) -> None:
    folder = tmp_path / "loop"
    folder.symlink_to(folder.name)
    with opened(folder) as store:
        with pytest.raises(StoreTrouble) as caught:
            store.add(INTENT).result(PATIENCE_S)
        with pytest.raises(StoreTrouble):
            store.state("x")
    assert str(folder) in caught.value.sentence
    assert caught.value.sentence.count(".") - str(folder).count(".") <= 2


@pytest.mark.promise("f")
def test_a_file_of_a_development_build_is_set_aside_after_what_it_leaves_active(folder: Path) -> None:
    folder.mkdir()
    with closing(sqlite3.connect(folder / FILE_NAME)) as former:
        former.execute("PRAGMA application_id = 0x44505353")
        former.execute("PRAGMA user_version = 10")
        former.execute("CREATE TABLE facts (number INTEGER PRIMARY KEY, kind, made_at, payload, link, hash)")
        for number, (act, module, outcome) in enumerate(
            (
                ("activate", "M-07", "confirmed"),
                ("activate", "M-08", "confirmed"),
                ("lock", "M-08", "confirmed"),
                ("activate", "M-09", None),
                ("activate", "", "refused"),
            )
        ):
            detail = f'{{"module": "{module}", "run": "r{number}"}}'
            payload = f'{{"act": "{act}", "port": "/dev/ttyUSB0", "detail": {detail}}}'
            add = "INSERT INTO facts (kind, made_at, payload, link, hash) VALUES (?, '2026-01-01', ?, ?, ?)"
            former.execute(add, ("act", payload, act, f"h{number}"))
            if outcome is not None:
                former.execute(add, ("outcome", f'{{"outcome": "{outcome}"}}', f"h{number}", ""))
        former.commit()
    with opened(folder) as store:
        assert " are kept as " in notice(store)
        left = store.read(lambda facts: facts.states("left:"))
        assert sorted(entry["module"] for entry in left.values()) == ["M-07", "M-09"]
    assert list(folder.glob("dps-s.aside-*.sqlite"))
