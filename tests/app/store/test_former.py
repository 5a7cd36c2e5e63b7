"""A store and an archive of a former layout are taken over whole, and kept as they were."""

import sqlite3
import zipfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import Archive
from app.guided.guided_store import last_tests
from app.guided.results import GuidedKind, GuidedVerdict
from app.records.check_store import CheckStore
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.database import FILE_NAME, StoreTrouble
from app.store.facts import FactKind
from app.store.left_active import left_active
from app.store.store import Store, open_store
from app.trigger_records.history import Judgement
from tests.support.records.kept_facts import tamper

LAYOUT_8 = Path(__file__).parents[2] / "support" / "records" / "layout-8.zip"
"""Made by version 4a8b7c4c on the simulated module: checks, records, judgements, a guided test, acts; all exchanged."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with zipfile.ZipFile(LAYOUT_8) as packed:
        packed.extractall(tmp_path)
    return tmp_path


@pytest.fixture
def store(folder: Path) -> Iterator[Store]:
    with closing(open_store(folder)) as opened:
        yield opened


@pytest.fixture
def former(folder: Path) -> Iterator[sqlite3.Connection]:
    """The store as it was."""
    with closing(sqlite3.connect(folder / "former.sqlite")) as connection:
        with closing(sqlite3.connect(folder / FILE_NAME)) as source:
            source.backup(connection)
        yield connection


def test_nothing_is_lost(former: sqlite3.Connection, store: Store, folder: Path) -> None:
    def rows(query: str) -> list[Any]:
        return former.execute(query).fetchall()

    checks = CheckStore(store.database)
    modules = rows("SELECT name, adapter FROM modules ORDER BY last_seen_at DESC")
    assert [(module.name, module.adapter) for module in store.modules()] == modules
    for name, *_ in modules:
        of_module = f"WHERE module_id = (SELECT id FROM modules WHERE name = '{name}')"
        kept = [(record.place, record.raw.hex(), record.first_seen_at, record.judgement, record.note)
                for record in checks.records(name)]  # fmt: skip
        assert kept == [
            (*row, None if judgement is None else Judgement(judgement), note)
            for *row, judgement, note in rows(
                f"SELECT place, raw, first_seen_at, judgement, note FROM trigger_records {of_module} ORDER BY place"
            )
        ]
        assert checks.checks(name) == ()  # records of former versions are not read
    assert len(store.facts.select(FactKind.VISIT)) == rows("SELECT count(*) FROM visits")[0][0]
    assert [fact.content["settings"] for fact in store.facts.select(FactKind.SNAPSHOT)][-1] == {"freefall_time_s": 1.6}
    assert store.evidence("M-07").boot_count == 37
    tests = last_tests(store.facts, "M-07", counts_simulated=True)
    assert {kind: test.verdict for kind, test in tests.items()} == {
        GuidedKind.TILT: GuidedVerdict.PASSED, GuidedKind.BAY: GuidedVerdict.FAILED,
    }  # fmt: skip
    acts = rows("SELECT id, at, act, coalesce(outcome, 'unknown') FROM audit ORDER BY id DESC")
    assert [(one.id, one.at, one.act.value, one.outcome.value) for one in store.audit()] == acts
    assert [one.at for one in left_active(store)] == [acts[1][1]]
    assert [(pending_baud.old_rate, pending_baud.new_rate) for pending_baud in store.pending_bauds()] == [(9600, 19200)]
    assert len(store.facts.select(FactKind.BAUD)) == 2
    stream = store.facts.state("stream:usb 9")
    assert stream is not None
    assert (stream["boot_count"], store.facts.state("stream:other")) == (4, None)
    assert store.facts.faults() == []
    with closing(sqlite3.connect(folder / "dps-s.version-8.sqlite")) as kept_file:
        assert kept_file.execute("SELECT * FROM audit").fetchall() == rows("SELECT * FROM audit")


def test_it_goes_on_where_it_ended(store: Store) -> None:
    checks = CheckStore(store.database)
    held = [record.raw for record in checks.records("M-07")]
    visit = checks.store_visit("M-07", held, port="p", boot_count=38, is_confirmed=True)
    assert visit.new == frozenset()
    assert checks.past("M-07", held).boot_count == 38
    store.settle(store.begin(Act.LOCK, b"B", {"module": "M-07", "adapter": "usb 1"}, port="/dev/ttyUSB0",
                             origin="window"), Outcome.CONFIRMED, {})  # fmt: skip
    assert left_active(store) == ()
    (pending,) = store.pending_bauds()
    store.settle(pending.id, Outcome.CONFIRMED, {"end": "changed"})
    assert store.pending_bauds() == ()
    assert store.facts.faults() == []


@pytest.fixture
def archive(store: Store) -> Iterator[Archive]:
    with closing(Archive(store)) as opened:
        yield opened


@pytest.mark.parametrize(
    ("check", "kept"),
    [
        ("verdict = 'GO'", ["bench test", None, "reviewed"]),
        ("verdict = 'GO', is_void = 1", ["bench test", None, None]),
        ("verdict = 'NO-GO'", ["bench test", None, None]),
    ],
)
def test_a_check_that_passed_had_reviewed_what_nobody_judged(folder: Path, check: str, kept: list[str | None]) -> None:
    """The judgement of the second record was withdrawn, which is a person's word too."""
    tamper(folder / FILE_NAME, f"UPDATE preflight_checks SET {check}")
    with closing(open_store(folder)) as store:
        records = CheckStore(store.database).records("M-07")
        assert [record.judgement and record.judgement.value for record in records] == kept


def test_the_layout_after_it_is_taken_over_too(folder: Path) -> None:
    tamper(folder / FILE_NAME, "ALTER TABLE modules ADD COLUMN said_new_at TEXT",
           "UPDATE modules SET said_new_at = last_seen_at", "PRAGMA user_version = 9")  # fmt: skip
    with closing(open_store(folder)) as store:
        assert (len(store.modules()), len(store.audit()), store.facts.faults()) == (3, 11, [])
        assert CheckStore(store.database).is_said_new("M-08")
    assert (folder / "dps-s.version-9.sqlite").exists()


def test_an_older_layout_is_left_as_it_is(folder: Path) -> None:
    tamper(folder / FILE_NAME, "DROP TABLE module_settlements", "PRAGMA user_version = 7")
    with pytest.raises(StoreTrouble, match=r"FAILED"):
        open_store(folder)
    with closing(sqlite3.connect(folder / FILE_NAME)) as file:
        assert file.execute("SELECT count(*) FROM audit").fetchone() == (11,)


@pytest.mark.parametrize(
    ("alteration", "expected"),
    [
        ("UPDATE audit SET act = 'lock' WHERE id = 1", [(1, "ALTERED")]),
        ("UPDATE audit SET outcome = 'unknown' WHERE id = 2", [(2, "ALTERED")]),
        ("DELETE FROM audit WHERE id = 2", [(2, "MISSING")]),
        ("INSERT INTO audit SELECT 99, NULL, 'p', 'o', at, act, '', '{}', NULL, NULL, NULL FROM audit WHERE id = 1",
         [(99, "FOREIGN")]),
        ("DELETE FROM audit_chain WHERE id = 4", [(2, "ALTERED"), (3, "BROKEN")]),
    ],
)  # fmt: skip
def test_what_was_altered_in_the_former_log_is_still_said(
    folder: Path, alteration: str, expected: list[tuple[int, str]]
) -> None:
    tamper(folder / FILE_NAME, alteration)
    with closing(open_store(folder)) as store:
        assert [(fault.entry, fault.fault.name) for fault in store.facts.faults()] == expected


def test_what_is_altered_after_it_was_taken_over_is_found(folder: Path) -> None:
    open_store(folder).close()
    tamper(folder / FILE_NAME, "UPDATE facts SET payload = replace(payload, 'tipped', 'kicked') WHERE number > 1")
    with closing(open_store(folder)) as store:
        assert "ALTERED" in [fault.fault.name for fault in store.facts.faults()]


@pytest.mark.parametrize(
    "odd",
    [
        "UPDATE visits SET slots = 'no list'",
        "UPDATE visits SET at = 'soon'",
        "UPDATE guided_tests SET measured = '[NaN, 1e999]'",
        "UPDATE trigger_records SET raw = 'zz'",
        "UPDATE preflight_checks SET record = '{'",
        "UPDATE audit SET detail = '[]', frame = 'zz'",
        "UPDATE modules SET adapter = CAST(x'ff' AS TEXT)",
        "UPDATE module_states SET settings = '['",
        """UPDATE module_settlements SET content = '{"module": [], "x": 1e999}'""",
        """UPDATE module_settlements SET content = '{"module": []}'""",
    ],
)
def test_a_row_that_nobody_can_read_keeps_none_from_being_taken_over(folder: Path, odd: str) -> None:
    tamper(folder / FILE_NAME, odd)
    with closing(open_store(folder)) as store:
        assert store.database.notice is None
        assert len(store.modules()) == 3
        with closing(Archive(store)) as archive:
            archive.collect()


@pytest.mark.parametrize("error", [sqlite3.OperationalError("disk I/O error"), sqlite3.IntegrityError(), KeyError("x")])
def test_a_takeover_that_fails_changes_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    """Neither is the file called damaged."""

    def full(*_: object) -> None:
        raise error

    with monkeypatch.context() as broken:
        broken.setattr("app.store.former.add_migrated", full)
        with pytest.raises(StoreTrouble):
            open_store(folder)
    with closing(sqlite3.connect(folder / FILE_NAME)) as file:
        assert file.execute("SELECT count(*) FROM audit").fetchone() == (11,)
        assert file.execute("PRAGMA user_version").fetchone() == (8,)
    with closing(open_store(folder)) as store:
        assert len(store.audit()) == 11
    assert not list(folder.glob("*.part"))
