"""Facts are exchanged with a file in both directions; nothing hostile is believed; only own facts decide."""

import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from app.archive.archive import OTHERS_FILE, Synced, all_facts, exchanged, known_names, status_of, sync
from app.archive.places import FilePlace
from app.archive.report import report
from app.store.fact_store import Store, StoreError, copies_of, copy_if_due
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
from app.store.station import shown_key
from app.text.messages import UserError
from app.trigger_records.history import KeptTriggers
from tests.files.records.test_filing import file_one
from tests.support.patience import PATIENCE_S, in_time
from tests.support.records.stored import add, checks_of, open_store, tamper

STRANGER = "b" * 64
NOW = datetime.now(UTC)


class Desk:
    """Three stations, and a stick that goes around."""

    def __init__(self, folder: Path, stores: list[Store]) -> None:
        self.stick, self.stores = folder / "stick.dps-s", stores

    def say(self, number: int, *modules: str) -> None:
        for module in modules:
            add(self.stores[number], SaidNew(is_new=True), module).result(PATIENCE_S)

    def exchange(self, number: int, stick: Path | None = None) -> Synced:
        return sync(self.stores[number], str(stick or self.stick))

    def ids(self, number: int) -> set[str]:
        with all_facts(self.stores[number]) as facts:
            return {id_ for (id_,) in facts.connection.execute("SELECT id FROM facts")}

    def put(self, *rows: tuple[object, ...], do: str = "") -> None:
        """What a stranger does to the stick."""
        FilePlace(self.stick).close()
        with closing(sqlite3.connect(self.stick, isolation_level=None)) as connection:
            connection.executemany(f"INSERT INTO facts ({COLUMNS}) VALUES (?, ?, ?, ?, ?, ?)", rows)
            connection.execute(do)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with ExitStack() as stack:
        yield Desk(tmp_path, [stack.enter_context(closing(open_store(tmp_path / name))) for name in "ABC"])


def made(kind: str = "said_new", text: str = '{"is_new":true}', module: str | None = "M-66", **values: Any) -> Row:
    """A fact of a stranger."""
    return make_row(kind, text, module=module, **{"station": STRANGER, "at": NOW, **values})


def honest(**changed: Any) -> Row:
    """Wrong, with the id of what it says."""
    row = made()._replace(**changed)
    return row._replace(id=fact_id(*row[1:]))


def test_all_get_the_same_rows_through_one_file(desk: Desk) -> None:
    for number in range(3):
        desk.say(number, *(f"M-{module}" for module in range(number + 1)))
    for number in (0, 1, 2, 0, 1, 2):
        desk.exchange(number)
    assert desk.ids(0) == desk.ids(1) == desk.ids(2)
    assert len(desk.ids(0)) == 3 + 6
    known = known_names(desk.stores[0])
    assert all(known.of_key(store.station) for store in desk.stores)
    assert desk.exchange(0) == Synced(str(desk.stick))


@pytest.mark.parametrize("page", ["add", "rows"])
def test_an_exchange_that_is_broken_off_goes_on_where_it_was(
    page: str, desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.archive.archive.PAGE_ROWS", 2)
    desk.say(0, *(f"M-{number}" for number in range(9)))
    number = int(page == "rows")
    if page == "rows":
        desk.exchange(0)
    whole, pages = getattr(FilePlace, page), iter((True, False))

    def break_off(*args: object) -> object:
        if not next(pages):
            raise KeyboardInterrupt
        return whole(*args)

    with monkeypatch.context() as patch:
        patch.setattr(FilePlace, page, break_off)
        with pytest.raises(KeyboardInterrupt):
            desk.exchange(number)
    store, stick = desk.stores[number], str(desk.stick)
    assert exchanged(store, stick)[0] is None
    again = desk.exchange(number)
    assert max(again.sent, again.received) == 8
    assert exchanged(store, stick)[1] == 0
    desk.say(number, "later")
    assert exchanged(store, stick)[1] == 1


def test_a_stick_that_takes_nothing_gives_all_that_is_on_it(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write-protected, say, and what this station has to add is older than what is there."""
    there = [made(at=NOW - timedelta(days=days)) for days in (0, 80)]
    desk.put(*there)
    at = NOW - timedelta(days=100)
    desk.stores[0].write(lambda facts: facts.add(SaidNew(is_new=True), "M-07", at=at)).result(PATIENCE_S)
    with monkeypatch.context() as patch:
        patch.setattr("app.archive.places.INSERT", "INSERT INTO nowhere VALUES (?, ?, ?, ?, ?, ?)")
        with pytest.raises(UserError, match="cannot be used"):
            desk.exchange(0)
    assert {row.id for row in there} <= desk.ids(0)


def test_an_act_never_waits_for_a_page_of_an_exchange(desk: Desk) -> None:
    with all_facts(desk.stores[0]) as facts:
        facts.connection.execute("BEGIN IMMEDIATE")
        desk.say(0, "M-07")
        facts.connection.execute("ROLLBACK")


@pytest.mark.parametrize("begins_at", [16, 4096], ids=["whole", "its middle"])
def test_the_file_of_the_others_may_be_damaged(begins_at: int, desk: Desk) -> None:
    """It is set aside, which is said once, and all that was in it comes again."""
    desk.say(0, *(f"M-{number}" for number in range(60)))
    desk.exchange(0)
    desk.exchange(1)
    before, folder = desk.ids(1), desk.stores[1].folder
    path = folder / OTHERS_FILE
    data = path.read_bytes()
    damaged = data[:begins_at] + b"\xff" * (len(data) - begins_at)
    path.write_bytes(damaged)
    assert known_names(desk.stores[1]).own == desk.stores[1].station
    with pytest.raises(StoreError) as caught:
        desk.ids(1)
    (aside,) = folder.glob("archive.aside-*.sqlite")
    assert str(aside) in caught.value.sentence
    assert aside.read_bytes() == damaged
    assert desk.exchange(1).received == 61
    assert desk.ids(1) == before


def test_where_the_store_itself_is_damaged_the_file_of_the_others_stays(desk: Desk) -> None:
    store = desk.stores[0]
    desk.say(0, *(f"M-{number}" for number in range(60)))
    store.close()
    data = store.path.read_bytes()
    store.path.write_bytes(data[:4096] + b"\xff" * (len(data) - 4096))
    with pytest.raises(StoreError) as caught:
        desk.ids(0)
    assert str(store.path) in caught.value.sentence
    assert (store.folder / OTHERS_FILE).exists()


# What is left out


@pytest.mark.parametrize(
    "row",
    [
        made()._replace(module="M-07"),
        made()._replace(id="f" * 40),
        honest(module="M\u202e07"),
        honest(module=" "),
        honest(made_at="3000-01-01T00:00:00.000000+00:00"),
        honest(made_at="1970-01-01T00:00:00.000000+00:00"),
        honest(made_at="2026-01-01 00:00+00:00"),
        honest(station="x" * 64),
        honest(kind="Said new"),
        honest(content="[" * 100_000),
        made(text='{"is_new": 1}'),
        made(text="{"),
        made("visit", '{"port":"p","boot_count":256,"slots":[],"is_confirmed":true}'),
        made("visit", f'{{"port":"{"p" * 401}","boot_count":1,"slots":[],"is_confirmed":true}}'),
        made("trigger_record", f'{{"place":{2**70},"raw":"00"}}'),
        made("service", '{"service":"repack","on":"2026-99-99","due":null,"who":""}'),
        made("new_kind", "[]"),
        made("preflight_check", '{"verdict":"GO","is_void":false,"is_simulated":false,"document":"{}"}'),
        honest(content='{"is_new":true,"x":"' + "x" * 1_000_000 + '"}'),  # not even fetched
    ],
    ids=range(19),
)
@pytest.mark.promise("g")
def test_a_row_that_is_no_fact_is_left_out_and_named_once(row: Row, desk: Desk) -> None:
    desk.put(row, made(text='{"is_new":false}', module="M-67"))
    first = desk.exchange(0)
    assert first.left_out_count == 1
    assert [one.id for one in first.left_out] == [row.id]
    desk.put(made(module="M-67"))
    again = desk.exchange(0)
    assert (again.left_out, again.left_out_count, again.received) == ([], 1, 1)


def test_a_kind_of_a_newer_version_is_kept_and_passed_on(desk: Desk, tmp_path: Path) -> None:
    newer = made("new_kind", '{"more":[1,2.5,null]}')
    more = made(text='{"is_new":true,"why":"a newer version says more"}')
    desk.put(newer, more)
    assert desk.exchange(0).received == 2
    for number in (0, 1):
        desk.exchange(number, tmp_path / "next")
    assert {newer.id, more.id} <= desk.ids(1)


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
def test_a_file_with_anything_of_its_own_is_refused(statement: str, desk: Desk) -> None:
    desk.put(do=statement)
    with pytest.raises(UserError):
        desk.exchange(0)


@pytest.mark.promise("g")
def test_what_a_strangers_table_demands_of_its_rows_is_not_computed(desk: Desk) -> None:
    """It would take longer than anybody waits."""
    desk.put(do="CREATE TABLE evil (x CHECK (length(hex(zeroblob(30000000 + x))) > 0))")
    with closing(sqlite3.connect(desk.stick, isolation_level=None)) as file:
        file.execute("PRAGMA ignore_check_constraints = ON")
        file.executemany("INSERT INTO evil VALUES (?)", [(number,) for number in range(300)])
    with in_time(0.5), pytest.raises(UserError):
        desk.exchange(0)


@pytest.mark.promise("g")
def test_the_store_of_a_station_and_a_copy_of_it_take_nothing(desk: Desk) -> None:
    """All in them is that station's own, and decides there."""
    desk.say(0, "M-07")
    desk.say(1, "M-08")
    store = desk.stores[1].path
    copy_if_due(store, NOW)
    desk.stores[1].close()
    for path in (store, copies_of(store)[0]):
        with pytest.raises(UserError, match="the store of a station"):
            desk.exchange(0, path)


@pytest.mark.parametrize("content", [b"no database" * 100, b"SQLite format 3\x00" + b"\xff" * 5000])
def test_a_file_that_is_none_is_one_sentence_and_stays_as_it_was(content: bytes, desk: Desk) -> None:
    desk.stick.write_bytes(content)
    with pytest.raises(UserError) as caught:
        desk.exchange(0)
    assert str(desk.stick) in caught.value.sentence
    assert desk.stick.read_bytes() == content


@pytest.mark.promise("g")
def test_a_check_whose_record_says_something_else_is_left_out(desk: Desk) -> None:
    one = desk.stores[0]
    file_one(one, "M-07")
    desk.exchange(0)
    assert desk.exchange(1).left_out_count == 0
    (kept,) = one.read(lambda facts: facts.of_module(PreflightCheck, "M-07"))
    assert kept.content.verdict != "GO"
    assert not kept.content.is_simulated
    at = datetime.fromisoformat(kept.at)
    document = kept.content.document
    forged = [document.replace("M-07", "M-08"), document.replace('"version":5', '"version":6'), "{}", "\\ud800"]
    said: list[dict[str, Any]] = [
        {"verdict": "GO"},
        {"is_void": True},
        {"is_simulated": True},
        *({"document": text} for text in forged),
    ]
    texts = [content_text(replace(kept.content, **changed)) for changed in said]
    row = partial(made, "preflight_check", station=one.station, at=at)
    desk.put(
        *(row(text, "M-07") for text in texts),
        row(kept.row.content, "M-07", station=STRANGER),
        row(kept.row.content, "M-08"),
        row(kept.row.content, "M-07", at=at + timedelta(days=1)),
    )
    assert desk.exchange(2).left_out_count == len(texts) + 3


# Nothing decides but what is in this station's own store


@pytest.mark.promise("g")
def test_what_comes_from_outside_decides_nothing_here_whatever_station_it_names(desk: Desk) -> None:
    here = desk.stores[1]
    file_one(desk.stores[0], "M-07")
    desk.exchange(0)
    own = made(module="M-07", station=here.station)
    desk.put(own)
    assert desk.exchange(1).left_out_count == 0
    assert own.id in desk.ids(1)
    assert checks_of(here, "M-07") == ()
    assert here.read(lambda facts: KeptTriggers(facts).is_said_new("M-07")) is False
    assert here.read(lambda facts: facts.of_module(ModuleNamed, "M-07")) == []


def test_a_wrong_clock_counts_for_nothing_and_is_named_and_so_is_a_station_only_by_itself(desk: Desk) -> None:
    here = desk.stores[0]
    text = content_text(StationNamed(public_key=here.station, name="another"))
    desk.put(made(module="M-99", at=NOW + timedelta(days=3)), made("station", text, None, at=NOW + timedelta(hours=1)))
    assert desk.exchange(0).received == 2
    with all_facts(here) as facts:
        assert facts.of_module(SaidNew, "M-99") == []
    assert status_of(here).stations_ahead == [shown_key(STRANGER)]
    assert report(here, NOW) == []
    assert "another" not in [one.name for one in status_of(here).stations]


def test_an_own_row_that_was_altered_in_place_is_sent_to_nobody_who_believes_it(desk: Desk) -> None:
    desk.say(0, "M-07")
    tamper(desk.stores[0].path, "UPDATE facts SET module = 'M-08' WHERE module = 'M-07'")
    desk.exchange(0)
    assert desk.exchange(1).left_out_count == 1
