"""Facts are exchanged with a file in both directions; nothing hostile is believed; only own facts decide."""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import OTHERS_FILE, Synced, all_facts, exchanged, status_of, sync
from app.archive.places import FilePlace
from app.store.fact_store import Store
from app.store.rows import (
    COLUMNS,
    ModuleNamed,
    PreflightCheck,
    Row,
    SaidNew,
    StationNamed,
    content_text,
    fact_id,
    make_row,
)
from app.text.messages import UserError
from app.trigger_records.history import KeptTriggers
from tests.files.records.test_filing import file_one
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import checks_of, open_store, tamper

STRANGER = "b" * 64
NOW = datetime.now(UTC)


@pytest.fixture
def stores(tmp_path: Path) -> Iterator[list[Store]]:
    with ExitStack() as stack:
        yield [stack.enter_context(closing(open_store(tmp_path / name))) for name in "ABC"]


@pytest.fixture
def stick(tmp_path: Path) -> Path:
    return tmp_path / "stick.dps-s"


@pytest.fixture
def exchange(stick: Path) -> Callable[[Store], Synced]:
    return lambda store: sync(store, str(stick))


def say(store: Store, module: str) -> None:
    store.add(SaidNew(is_new=True), module).result(PATIENCE_S)


def ids(store: Store) -> set[str]:
    query = "SELECT id FROM facts"
    with all_facts(store) as facts:
        return {id_ for (id_,) in facts.connection.execute(query)}


def made(kind: str = "said_new", text: str = '{"is_new":true}', module: str | None = "M-66", **values: Any) -> Row:
    """A fact of a stranger."""
    return make_row(kind, text, module=module, **{"station": STRANGER, "at": NOW, **values})


def honest(**changed: Any) -> Row:
    """Wrong, with the id of what it says."""
    row = made()._replace(**changed)
    return row._replace(id=fact_id(*row[1:]))


def put(stick: Path, *rows: tuple[object, ...]) -> None:
    FilePlace(stick).close()
    with closing(sqlite3.connect(stick, isolation_level=None)) as connection:
        connection.executemany(f"INSERT INTO facts ({COLUMNS}) VALUES (?, ?, ?, ?, ?, ?)", rows)


def test_all_get_the_same_rows_through_one_file(stores: list[Store], exchange: Callable[[Store], Synced]) -> None:
    for number, store in enumerate(stores):
        for module in range(number + 1):
            say(store, f"M-{module}")
    for store in (*stores, *stores):
        exchange(store)
    assert ids(stores[0]) == ids(stores[1]) == ids(stores[2])
    assert len(ids(stores[0])) == 3 + 6
    assert exchange(stores[0]) == Synced()


@pytest.mark.parametrize("page", ["add", "rows"])
def test_an_exchange_that_is_broken_off_goes_on_where_it_was(
    page: str, stores: list[Store], stick: Path, exchange: Callable[[Store], Synced], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.archive.archive.PAGE_ROWS", 2)
    for number in range(9):
        say(stores[0], f"M-{number}")
    if page == "rows":
        exchange(stores[0])
    store = stores[page == "rows"]
    whole, pages = getattr(FilePlace, page), iter((True, False))

    def break_off(*args: object) -> object:
        if not next(pages):
            raise KeyboardInterrupt
        return whole(*args)

    with monkeypatch.context() as patch:
        patch.setattr(FilePlace, page, break_off)
        with pytest.raises(KeyboardInterrupt):
            exchange(store)
    assert exchanged(store, str(stick)).last_at is None
    again = exchange(store)
    assert max(again.sent, again.received) == 8
    assert exchanged(store, str(stick)).not_shared == 0
    say(store, "later")
    assert exchanged(store, str(stick)).not_shared == 1


def test_an_act_never_waits_for_a_page_of_an_exchange(stores: list[Store]) -> None:
    with all_facts(stores[0]) as facts:
        facts.connection.execute("BEGIN IMMEDIATE")
        say(stores[0], "M-07")
        facts.connection.execute("ROLLBACK")


def test_the_file_of_the_others_may_be_lost(stores: list[Store], exchange: Callable[[Store], Synced]) -> None:
    one, other, _third = stores
    say(one, "M-07")
    exchange(one)
    exchange(other)
    before = ids(other)
    (other.folder / OTHERS_FILE).write_bytes(b"SQLite format 3\x00" + b"\xff" * 3000)
    assert exchange(other).received == 2
    assert ids(other) == before


# What is left out


@pytest.mark.parametrize(
    "row",
    [
        made()._replace(content='{"is_new":false}'),
        made()._replace(module="M-07"),
        made()._replace(made_at="2026-01-01T00:00:00.000000+00:00"),
        made()._replace(id="f" * 40),
        honest(module="M\u202e07"),
        honest(module=" "),
        honest(made_at="3000-01-01T00:00:00.000000+00:00"),
        honest(made_at="2026-01-01 00:00+00:00"),
        honest(station="x" * 64),
        honest(kind="Said new"),
        made()._replace(content="[" * 100_000),
        made(text='{"is_new": 1}'),
        made(text="{"),
        made("visit", '{"port":"p","boot_count":256,"slots":[],"is_confirmed":true,"known":0}'),
        made("visit", f'{{"port":"{"p" * 401}","boot_count":1,"slots":[],"is_confirmed":true,"known":0}}'),
        made("visit", f'{{"port":"p","boot_count":1,"slots":[],"is_confirmed":true,"known":{2**70}}}'),
        made("service", '{"service":"repack","on":"2026-99-99","due":null,"who":""}'),
        made("new_kind", "[]"),
        made("preflight_check", '{"verdict":"GO","is_void":false,"is_simulated":false,"document":"{}"}'),
        made()._replace(content='{"is_new":true,"x":"' + "x" * 1_000_000 + '"}'),  # not even fetched
    ],
    ids=range(20),
)
@pytest.mark.promise("g")
def test_a_row_that_is_no_fact_is_left_out_and_named_once(
    row: Row, stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    put(stick, row, made(text='{"is_new":false}', module="M-67"))
    first = exchange(stores[0])
    assert first.left_out_count == 1
    assert [one.id for one in first.left_out] == [row.id]
    put(stick, made(module="M-67"))
    again = exchange(stores[0])
    assert (again.left_out, again.left_out_count, again.received) == ([], 1, 1)


def test_a_kind_of_a_newer_version_is_kept_and_passed_on(stores: list[Store], stick: Path, tmp_path: Path) -> None:
    newer = made("new_kind", '{"more":[1,2.5,null]}')
    more = made(text='{"is_new":true,"why":"a newer version says more"}')
    put(stick, newer, more)
    assert sync(stores[0], str(stick)).received == 2
    sync(stores[0], str(tmp_path / "next"))
    sync(stores[1], str(tmp_path / "next"))
    assert {newer.id, more.id} <= ids(stores[1])


@pytest.mark.parametrize(
    "statement",
    [
        "CREATE TRIGGER evil AFTER INSERT ON facts BEGIN DELETE FROM state; END",
        "CREATE VIEW evil AS SELECT * FROM facts",
        "CREATE TABLE evil (x)",
        "PRAGMA application_id = 7",
    ],
)
@pytest.mark.promise("g")
def test_a_file_with_anything_of_its_own_is_refused(
    statement: str, stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    put(stick)
    with closing(sqlite3.connect(stick, isolation_level=None)) as connection:
        connection.execute(statement)
    with pytest.raises(UserError):
        exchange(stores[0])


@pytest.mark.parametrize("content", [b"no database" * 100, b"SQLite format 3\x00" + b"\xff" * 5000])
def test_a_file_that_is_none_is_one_sentence_and_stays_as_it_was(
    content: bytes, stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    stick.write_bytes(content)
    with pytest.raises(UserError) as caught:
        exchange(stores[0])
    assert str(stick) in caught.value.sentence
    assert stick.read_bytes() == content


@pytest.mark.promise("g")
def test_a_check_whose_record_says_something_else_is_left_out(
    stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    one, other, third = stores
    file_one(one, "M-07")
    exchange(one)
    assert exchange(other).left_out_count == 0
    (kept,) = one.read(lambda facts: facts.of_module(PreflightCheck, "M-07"))
    assert kept.content.verdict != "GO"
    text = content_text(PreflightCheck(verdict="GO", is_void=False, is_simulated=False, document=kept.content.document))
    at, same = datetime.fromisoformat(kept.at), kept.row.content
    put(
        stick,
        made("preflight_check", text, "M-07", station=one.station, at=at),
        made("preflight_check", same, "M-07", at=at),
        made("preflight_check", same, "M-08", station=one.station, at=at),
        made("preflight_check", same, "M-07", station=one.station, at=at + timedelta(days=1)),
    )
    assert exchange(third).left_out_count == 4


# Nothing decides but what is in this station's own store


@pytest.mark.promise("g")
def test_what_comes_from_outside_decides_nothing_here_whatever_station_it_names(
    stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    one, other, _third = stores
    file_one(one, "M-07")
    exchange(one)
    own = made(module="M-07", station=other.station)
    put(stick, own)
    assert exchange(other).left_out_count == 0
    assert own.id in ids(other)
    assert checks_of(other, "M-07") == ()
    assert other.read(lambda facts: KeptTriggers(facts).is_said_new("M-07")) is False
    assert other.read(lambda facts: facts.of_module(ModuleNamed, "M-07")) == []


def test_a_wrong_clock_counts_for_nothing_and_is_named_and_so_is_a_station_only_by_itself(
    stores: list[Store], stick: Path, exchange: Callable[[Store], Synced]
) -> None:
    text = content_text(StationNamed(public_key=stores[0].station, name="another"))
    late = made(module="M-99", at=NOW + timedelta(days=3))
    put(stick, late, made("station", text, None, at=NOW + timedelta(hours=1)))
    assert exchange(stores[0]).received == 2
    with all_facts(stores[0]) as facts:
        assert facts.of_module(SaidNew, "M-99") == []
    assert status_of(stores[0]).ahead == [STRANGER]
    assert "another" not in status_of(stores[0]).stations.values()


def test_an_own_row_that_was_altered_in_place_is_sent_to_nobody_who_believes_it(
    stores: list[Store], exchange: Callable[[Store], Synced]
) -> None:
    one, other, _third = stores
    say(one, "M-07")
    tamper(one.path, "UPDATE facts SET module = 'M-08' WHERE module = 'M-07'")
    exchange(one)
    assert exchange(other).left_out_count == 1
