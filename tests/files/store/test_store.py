"""The store: what it keeps, and the files that it meets instead of its own."""

import argparse
import os
import sqlite3
import stat
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import pytest

from app.archive.archive import all_facts
from app.cli.archive import run_service
from app.safety.left_active import LeftActive, all_left
from app.store.fact_store import FILE_NAME, LAYOUT, Facts, Store, StoreError, copies_of, copy_if_due, unusable
from app.store.rows import ActIntended, Content, ModuleNamed, SaidNew, Serviced, ServiceKind, SettingsSeen, StationNamed
from app.store.station import KEY_FILE
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import add

NOON = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)
INTENT = ActIntended(act="lock", port="/dev/ttyUSB0", frame="42 61 25 01 00 26")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


@contextmanager
def opened(folder: Path, at: datetime = NOON, *modules: str) -> Iterator[Store]:
    """With a fact about each of these modules."""
    with closing(Store(folder, clock=lambda: at)) as store:
        for module in modules:
            add(store, SaidNew(is_new=True), module).result(PATIENCE_S)
        yield store


def said(store: Store) -> list[str | None]:
    return [kept.row.module for kept in store.read(lambda facts: facts.of_kind(SaidNew))]


def notice(store: Store) -> str:
    found = store.opened.result(PATIENCE_S)
    return "" if found is None else found.in_english()


def test_what_is_added_is_there_after_the_program_ended(folder: Path) -> None:
    with opened(folder, NOON, "M-07", "M-08") as store:
        store.set_state("stream:A", {"boot_count": 3})
        store.set_state("stream:B", 1)
        store.set_state("stream:B", None)
    with opened(folder) as store:
        assert said(store) == ["M-07", "M-08"], "also within one tick of the clock"
        assert store.read(lambda facts: facts.states("stream:")) == {"A": {"boot_count": 3}}
        (kept,) = store.read(lambda facts: facts.of_kind(StationNamed))
        assert kept.content.public_key == kept.row.station == store.station


def test_a_station_introduces_itself_once_and_again_under_a_new_name(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("hangar", "hangar", "field"):
        monkeypatch.setattr("platform.node", partial(str, name))
        with opened(folder) as store:
            store.opened.result(PATIENCE_S)
    with opened(folder) as store:
        kept = store.read(lambda facts: facts.of_kind(StationNamed))
    assert [one.content.name for one in kept] == ["hangar", "field"]


@pytest.mark.parametrize(
    "statement",
    ["UPDATE facts SET module = 'M-08'", "DELETE FROM facts", "INSERT OR REPLACE INTO facts SELECT * FROM facts"],
)
def test_facts_are_only_ever_added(statement: str, folder: Path) -> None:
    with opened(folder, NOON, "M-07") as store:
        with pytest.raises(StoreError):
            store.write(lambda facts: facts.connection.execute(statement)).result(PATIENCE_S)
        assert said(store) == ["M-07"]


@pytest.mark.parametrize(
    "content",
    [
        SettingsSeen(port="p", boot_count=1, settings={"light_threshold_v": float("nan")}),
        SettingsSeen(port="p", boot_count=256, settings={}),
        Serviced(service=ServiceKind.REPACK, on=NOON.date(), due=None, who="x" * 401),
    ],
)
def test_what_could_not_be_read_again_is_refused_where_it_is_made(content: Content, folder: Path) -> None:
    with opened(folder) as store, pytest.raises(ValueError):
        add(store, content, "M-07").result(PATIENCE_S)


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
        busy = store.write(lambda _facts: go_on.wait(PATIENCE_S))
        intent = add(store, INTENT)
        assert intent.cancel()
        go_on.set()
        assert busy.result(PATIENCE_S)
        with pytest.raises(CancelledError):
            intent.result(PATIENCE_S)
        assert store.read(lambda facts: facts.of_kind(ActIntended)) == []


def test_closing_has_a_limit_and_says_whether_all_was_written(folder: Path) -> None:
    go_on = threading.Event()
    with opened(folder) as store:
        store.write(lambda _facts: go_on.wait(PATIENCE_S))
        add(store, SaidNew(is_new=True), "M-07")
        assert not store.close(0.01)
        assert add(store, SaidNew(is_new=True), "late").cancelled()
        go_on.set()
        assert store.close(PATIENCE_S)
    with opened(folder) as store:
        assert said(store) == ["M-07"]


def test_reading_waits_no_longer_than_its_limit_for_a_disk_that_never_answers(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    release = threading.Event()
    monkeypatch.setattr("app.store.fact_store.open_file", lambda _path: release.wait())
    monkeypatch.setattr("app.store.fact_store.ANSWER_LIMIT_S", 0.1)
    store = Store(folder)
    try:
        with pytest.raises(StoreError) as refused:
            store.read(lambda facts: facts.station)
        with pytest.raises(StoreError) as refused_too, all_facts(store):
            pass
    finally:
        release.set()
        store.close()
    assert "being opened" in str(refused.value)
    assert "being opened" in str(refused_too.value)


def test_the_command_that_keeps_a_service_does_not_wait_for_ever(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.store.fact_store.ANSWER_LIMIT_S", 0.1)
    release = threading.Event()
    with opened(folder) as store:
        add(store, ModuleNamed(), "M-07").result(PATIENCE_S)
        store.write(lambda _facts: release.wait(PATIENCE_S))
        args = argparse.Namespace(module="M-07", what="repack", on=None, due=None, who="Li", note="", json=False)
        with pytest.raises(StoreError):
            run_service(args, store)
        release.set()


def test_a_full_disk_is_said_whatever_the_database_says(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    why = sqlite3.OperationalError("disk I/O error")
    assert "disk I/O error" in str(unusable(folder.parent / FILE_NAME, why))
    monkeypatch.setattr("shutil.disk_usage", lambda _path: argparse.Namespace(free=4096))
    assert "the disk is full" in str(unusable(folder.parent / FILE_NAME, why))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such rights")
def test_its_folder_is_for_this_user_only(folder: Path) -> None:
    folder.mkdir(mode=0o777)
    with opened(folder) as store:
        store.opened.result(PATIENCE_S)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


# Copies, and what takes the place of a file that is damaged, gone or another's


def copied(folder: Path, at: datetime = NOON) -> Path:
    """The copy of that day."""
    copy_if_due(folder / FILE_NAME, at)
    return folder / "copies" / f"dps-s.{at:%Y%m%d}.sqlite"


@pytest.mark.promise("f")
def test_a_copy_a_day_is_kept_of_the_last_seven(folder: Path) -> None:
    with opened(folder, NOON - timedelta(days=1), "M-07"):
        pass
    for day in range(9):
        first = copied(folder, NOON + timedelta(days=day)).stat().st_mtime_ns
        assert copied(folder, NOON + timedelta(days=day, hours=1)).stat().st_mtime_ns == first
    names = [copy.name for copy in copies_of(folder / FILE_NAME)]
    assert names == [f"dps-s.202601{day:02}.sqlite" for day in range(10, 3, -1)]


def test_a_store_with_something_in_it_is_copied_when_it_is_opened(folder: Path) -> None:
    with opened(folder):
        pass
    assert copies_of(folder / FILE_NAME) == [], "an empty copy would stand for the whole day"
    with opened(folder, NOON, "M-07"):
        pass
    ends_at = time.monotonic() + PATIENCE_S
    with opened(folder):
        while not copies_of(folder / FILE_NAME) and time.monotonic() < ends_at:
            time.sleep(0.01)
    assert [copy.name for copy in copies_of(folder / FILE_NAME)] == ["dps-s.20260102.sqlite"]


def damage(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[:200] + b"\xff" * (len(data) - 200))


@pytest.mark.parametrize("what", ["damaged", "no database", "empty", "gone", "gone but its log"])
@pytest.mark.promise("f")
def test_the_newest_whole_copy_takes_the_place_of_a_file_that_cannot_be_used(what: str, folder: Path) -> None:
    for day, module in ((-1, "older"), (0, "M-07")):
        with opened(folder, NOON + timedelta(days=day - 1), module):
            pass
        copied(folder, NOON + timedelta(days=day))
    path = folder / FILE_NAME
    log = path.with_name(f"{FILE_NAME}-wal")
    # Held open, so that its log stays.
    with closing(sqlite3.connect(path, isolation_level=None)) as other, opened(folder, NOON, "later", "more") as store:
        other.execute("SELECT 1 FROM facts").fetchone()
        store.write(lambda _facts: None).result(PATIENCE_S)
        written = log.read_bytes()
    damage(copied(folder, NOON + timedelta(days=1)))
    if what == "damaged":
        damage(path)
    elif what.startswith("gone"):
        path.unlink()
        if what == "gone but its log":
            log.write_bytes(written)
    else:
        path.write_bytes(b"" if what == "empty" else b"something else" * 1000)
    with opened(folder) as store:
        assert "Records restored from the copy of 20260102; later ones are missing." in notice(store)
        assert said(store) == ["older", "M-07"]
        assert store.read(lambda facts: facts.connection.execute("PRAGMA integrity_check").fetchall()) == [("ok",)]
    assert len(list(folder.glob("dps-s.aside-*.sqlite"))) == (not what.startswith("gone"))
    with opened(folder) as store:
        assert notice(store) == ""


@pytest.mark.promise("f")
def test_what_is_left_active_outlives_a_file_that_is_damaged_elsewhere(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.store.fact_store.copy_if_due", lambda *_: None)  # else it may take its place
    left = LeftActive(run="r", module="M-07", port="/dev/ttyUSB0", at="2026-01-02T12:00:00.000000+00:00")
    with opened(folder, NOON, *(f"M-{number}" for number in range(100))) as store:
        store.set_state("left:other", {"module": 1})
        store.set_state("left:r", left)
    path = folder / FILE_NAME
    data = path.read_bytes()
    intact = 8 * 4096  # the first page of each table
    path.write_bytes(data[:intact] + b"\xff" * (len(data) - intact))
    with opened(folder) as store:
        assert notice(store).startswith("The records cannot be used and are kept as ")
        assert "New records are started." in notice(store)
        assert store.read(all_left) == (left,)


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system does not say which files are open")
def test_where_there_is_no_station_there_is_no_store_and_no_file_stays_open(folder: Path) -> None:
    (folder / KEY_FILE).mkdir(parents=True)
    store = Store(folder)
    with pytest.raises(StoreError):
        store.opened.result(PATIENCE_S)
    store.close()
    numbers = Path("/proc/self/fd").iterdir()
    assert not [number for number in numbers if os.path.realpath(number) == str(folder / FILE_NAME)]


def test_a_file_of_a_newer_version_is_left_alone(folder: Path) -> None:
    with opened(folder, NOON, "M-07"):
        pass
    path = folder / FILE_NAME
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(f"PRAGMA user_version = {LAYOUT + 1}")
    before = path.read_bytes()
    with opened(folder) as store, pytest.raises(StoreError) as caught:
        add(store, INTENT).result(PATIENCE_S)
    assert "newer version" in caught.value.sentence
    assert str(path) in caught.value.sentence
    assert path.read_bytes() == before


@pytest.mark.promise("f")
def test_a_file_of_a_development_build_is_set_aside_after_what_it_leaves_active(folder: Path) -> None:
    acts = ("activate", "M-07", "confirmed"), ("activate", "M-08", "confirmed"), ("lock", "M-08", "confirmed")
    folder.mkdir()
    with closing(sqlite3.connect(folder / FILE_NAME)) as former:
        former.execute("PRAGMA application_id = 0x44505353")
        former.execute("PRAGMA user_version = 10")
        former.execute("CREATE TABLE facts (number INTEGER PRIMARY KEY, kind, made_at, payload, link, hash)")
        add = "INSERT INTO facts (kind, made_at, payload, link, hash) VALUES (?, '2026-01-01', ?, ?, ?)"
        for number, (act, module, outcome) in enumerate(
            (*acts, ("activate", "M-09", None), ("activate", "", "refused"))
        ):
            detail = f'{{"module": "{module}", "run": "r{number}"}}'
            payload = f'{{"act": "{act}", "port": "/dev/ttyUSB0", "detail": {detail}}}'
            former.execute(add, ("act", payload, act, f"h{number}"))
            if outcome is not None:
                former.execute(add, ("outcome", f'{{"outcome": "{outcome}"}}', f"h{number}", ""))
        former.commit()
    with opened(folder) as store:
        assert " are kept as " in notice(store)
        left = store.read(lambda facts: facts.states("left:"))
        assert sorted(entry["module"] for entry in left.values()) == ["M-07", "M-09"]
    assert list(folder.glob("dps-s.aside-*.sqlite"))
