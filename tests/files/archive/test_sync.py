"""Facts are exchanged with a file in both directions; nothing hostile is believed; only own facts decide."""

import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.archive.archive import OTHERS_FILE, Archive
from app.archive.places import FilePlace
from app.archive.sync import sync
from app.store.fact_store import Store
from app.store.rows import COLUMNS, ModuleNamed, PreflightCheck, SaidNew, StationNamed, content_text, make_row
from app.text.messages import UserError
from app.trigger_records.history import KeptTriggers
from tests.files.records.test_filing import file_one
from tests.support.patience import PATIENCE_S
from tests.support.records.kept_facts import tamper
from tests.support.records.stored import checks_of, open_store

STRANGER = "b" * 64
NOW = datetime.now(UTC)


@pytest.fixture
def stores(tmp_path: Path) -> Iterator[list[Store]]:
    with ExitStack() as stack:
        yield [stack.enter_context(closing(open_store(tmp_path / name))) for name in "ABC"]


@pytest.fixture
def stick(tmp_path: Path) -> Path:
    return tmp_path / "stick.dps-s"


def say(store: Store, module: str) -> None:
    store.add(SaidNew(is_new=True), module).result(PATIENCE_S)


def ids(store: Store) -> set[str]:
    query = "SELECT id FROM facts"
    return Archive(store).read(lambda facts: {id_ for (id_,) in facts.connection.execute(query)})


def row(**changed: object) -> tuple[object, ...]:
    """A fact of a stranger, with what is wrong in it."""
    text = content_text(SaidNew(is_new=True))
    made = make_row("said_new", text, module="M-66", station=STRANGER, at=NOW)
    return tuple(made._replace(**changed))  # type: ignore[arg-type]


def put(stick: Path, *rows: tuple[object, ...]) -> None:
    FilePlace(stick).close()
    with closing(sqlite3.connect(stick, isolation_level=None)) as connection:
        for one in rows:
            connection.execute(f"INSERT INTO facts ({COLUMNS}) VALUES (?, ?, ?, ?, ?, ?)", one)


def test_all_get_the_same_rows_through_one_file(stores: list[Store], stick: Path) -> None:
    for number, store in enumerate(stores):
        for module in range(number + 1):
            say(store, f"M-{module}")
    for store in (*stores, *stores):
        sync(Archive(store), str(stick))
    assert ids(stores[0]) == ids(stores[1]) == ids(stores[2])
    assert len(ids(stores[0])) == 3 + 6
    done = sync(Archive(stores[0]), str(stick))
    assert (done.sent, done.received, done.left_out_count) == (0, 0, 0)


def test_an_exchange_that_is_broken_off_goes_on_where_it_was(
    stores: list[Store], stick: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.archive.sync.PAGE_ROWS", 2)
    one, other, _third = stores
    for number in range(9):
        say(one, f"M-{number}")

    def break_off(_done: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sync(Archive(one), str(stick), break_off)
    assert Archive(one).exchanged(str(stick)).last_at is None
    assert sync(Archive(one), str(stick)).sent == 8
    with pytest.raises(KeyboardInterrupt):
        sync(Archive(other), str(stick), break_off)
    assert sync(Archive(other), str(stick)).received == 8
    assert Archive(one).exchanged(str(stick)).not_shared == 0
    say(one, "later")
    assert Archive(one).exchanged(str(stick)).not_shared == 1


def test_an_act_never_waits_for_a_page_of_an_exchange(stores: list[Store]) -> None:
    with Archive(stores[0]).opened() as here:
        here.execute("BEGIN IMMEDIATE")
        say(stores[0], "M-07")
        here.execute("ROLLBACK")


def test_the_file_of_the_others_may_be_lost(stores: list[Store], stick: Path) -> None:
    one, other, _third = stores
    say(one, "M-07")
    sync(Archive(one), str(stick))
    sync(Archive(other), str(stick))
    before = ids(other)
    path = other.folder / OTHERS_FILE
    path.write_bytes(b"SQLite format 3\x00" + b"\xff" * 3000)
    assert sync(Archive(other), str(stick)).received == 2
    assert ids(other) == before


# What is left out


@pytest.mark.parametrize(
    "changed",
    [
        {"content": '{"is_new":false}'},
        {"module": "M-07"},
        {"made_at": "2026-01-01T00:00:00.000000+00:00"},
        {"id": "f" * 40},
        {"module": "M\u202e07"},
        {"content": "[" * 100_000},
    ],
)
@pytest.mark.promise("g")
def test_a_row_that_is_no_fact_is_left_out_and_named_once(
    changed: dict[str, object], stores: list[Store], stick: Path
) -> None:
    good = make_row("said_new", '{"is_new":false}', module="M-67", station=STRANGER, at=NOW)
    put(stick, row(**changed), tuple(good))
    first = sync(Archive(stores[0]), str(stick))
    assert first.left_out_count == 1
    assert [one.id for one in first.left_out] == [row(**changed)[0]]
    put(stick, tuple(make_row("said_new", '{"is_new":true}', module="M-67", station=STRANGER, at=NOW)))
    again = sync(Archive(stores[0]), str(stick))
    assert (again.left_out, again.left_out_count, again.received) == ([], 1, 1)


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("said_new", '{"is_new": 1}'),
        ("said_new", "{"),
        ("visit", '{"port":"p","boot_count":256,"slots":[],"is_confirmed":true,"known":0}'),
        ("visit", f'{{"port":"{"p" * 401}","boot_count":1,"slots":[],"is_confirmed":true,"known":0}}'),
        ("visit", f'{{"port":"p","boot_count":1,"slots":[],"is_confirmed":true,"known":{2**70}}}'),
        ("service", '{"service":"repack","on":"2026-99-99","due":null,"who":""}'),
        ("new_kind", "[]"),
        ("preflight_check", '{"verdict":"GO","is_void":false,"is_simulated":false,"document":"{}"}'),
    ],
)
@pytest.mark.promise("g")
def test_a_content_that_no_station_writes_is_left_out(kind: str, text: str, stores: list[Store], stick: Path) -> None:
    put(stick, tuple(make_row(kind, text, module="M-66", station=STRANGER, at=NOW)))
    assert sync(Archive(stores[0]), str(stick)).left_out_count == 1


def test_a_kind_of_a_newer_version_is_kept_and_passed_on(stores: list[Store], stick: Path, tmp_path: Path) -> None:
    newer = make_row("new_kind", '{"more":[1,2.5,null]}', module="M-66", station=STRANGER, at=NOW)
    more = make_row(
        "said_new", '{"is_new":true,"why":"a newer version says more"}', module="M-66", station=STRANGER, at=NOW
    )
    put(stick, tuple(newer), tuple(more))
    assert sync(Archive(stores[0]), str(stick)).received == 2
    sync(Archive(stores[0]), str(tmp_path / "next"))
    assert sync(Archive(stores[1]), str(tmp_path / "next")).received >= 2
    assert {newer.id, more.id} <= ids(stores[1])


@pytest.mark.promise("g")
def test_a_row_that_is_too_large_is_not_even_fetched(stores: list[Store], stick: Path) -> None:
    put(stick, row(content='{"is_new":true,"x":"' + "x" * 1_000_000 + '"}'))
    assert [one.why for one in sync(Archive(stores[0]), str(stick)).left_out] == ["too large"]


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
def test_a_file_with_anything_of_its_own_is_refused(statement: str, stores: list[Store], stick: Path) -> None:
    put(stick)
    with closing(sqlite3.connect(stick, isolation_level=None)) as connection:
        connection.execute(statement)
    with pytest.raises(UserError):
        sync(Archive(stores[0]), str(stick))


@pytest.mark.parametrize("content", [b"no database" * 100, b"SQLite format 3\x00" + b"\xff" * 5000])
def test_a_file_that_is_none_is_one_sentence_and_stays_as_it_was(
    content: bytes, stores: list[Store], stick: Path
) -> None:
    stick.write_bytes(content)
    with pytest.raises(UserError) as caught:
        sync(Archive(stores[0]), str(stick))
    assert str(stick) in caught.value.sentence
    assert stick.read_bytes() == content


@pytest.mark.promise("g")
def test_a_check_whose_record_says_something_else_is_left_out(stores: list[Store], stick: Path) -> None:
    one, other, third = stores
    file_one(one, "M-07")
    sync(Archive(one), str(stick))
    assert sync(Archive(other), str(stick)).left_out_count == 0
    (kept,) = one.read(lambda facts: facts.of_module(PreflightCheck, "M-07"))
    assert kept.content.verdict != "GO"
    text = content_text(PreflightCheck(verdict="GO", is_void=False, is_simulated=False, document=kept.content.document))
    at = datetime.fromisoformat(kept.at)
    forged = [
        make_row("preflight_check", text, module="M-07", station=one.station, at=at),
        make_row("preflight_check", kept.row.content, module="M-07", station=STRANGER, at=at),
        make_row("preflight_check", kept.row.content, module="M-08", station=one.station, at=at),
        make_row("preflight_check", kept.row.content, module="M-07", station=one.station, at=at + timedelta(days=1)),
    ]
    put(stick, *map(tuple, forged))
    assert sync(Archive(third), str(stick)).left_out_count == len(forged)


# Nothing decides but what is in this station's own store


@pytest.mark.promise("g")
def test_what_comes_from_outside_decides_nothing_here_whatever_station_it_names(
    stores: list[Store], stick: Path
) -> None:
    one, other, _third = stores
    file_one(one, "M-07")
    say(one, "M-07")
    own = make_row("said_new", '{"is_new":true}', module="M-07", station=other.station, at=NOW)
    sync(Archive(one), str(stick))
    put(stick, tuple(own))
    assert sync(Archive(other), str(stick)).left_out_count == 0
    assert own.id in ids(other)
    assert checks_of(other, "M-07") == ()
    assert other.read(lambda facts: KeptTriggers(facts).is_said_new("M-07")) is False
    assert other.read(lambda facts: facts.of_module(ModuleNamed, "M-07")) == []


def test_a_wrong_clock_counts_for_nothing_and_is_named(stores: list[Store], stick: Path) -> None:
    late = make_row("said_new", '{"is_new":true}', module="M-99", station=STRANGER, at=NOW + timedelta(days=3))
    put(stick, tuple(late))
    archive = Archive(stores[0])
    assert sync(archive, str(stick)).received == 1
    assert archive.read(lambda facts: facts.of_module(SaidNew, "M-99")) == []
    assert archive.status().ahead == [STRANGER]


def test_stations_are_known_by_the_names_that_they_give_themselves_only(stores: list[Store], stick: Path) -> None:
    text = content_text(StationNamed(public_key=stores[0].station, name="another"))
    put(stick, tuple(make_row("station", text, module=None, station=STRANGER, at=NOW + timedelta(hours=1))))
    archive = Archive(stores[0])
    sync(archive, str(stick))
    assert "another" not in archive.status().stations.values()


def test_an_own_row_that_was_altered_in_place_is_sent_to_nobody_who_believes_it(
    stores: list[Store], stick: Path
) -> None:
    one, other, _third = stores
    say(one, "M-07")
    tamper(one.path, "UPDATE facts SET module = 'M-08' WHERE module = 'M-07'")
    sync(Archive(one), str(stick))
    assert sync(Archive(other), str(stick)).left_out_count == 1
