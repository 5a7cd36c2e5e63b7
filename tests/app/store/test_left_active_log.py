"""What the audit log leaves ACTIVE: a table of what was logged and what is said at the next start."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.left_active import left_active, note_locked, note_report
from app.store.store import Store, open_store

USB, OTHER = "/dev/ttyUSB0", "/dev/ttyUSB1"
CONFIRMED, REFUSED, UNKNOWN, NOT_SENT = Outcome
ACTIVE, LOCK_IN_DOUBT = "ACTIVE", "LOCK?"
Row = tuple[Act, Outcome | None, str, str]
"""Act, outcome, module, run of the program."""


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = open_store(tmp_path)
    yield opened
    opened.close()


def left(store: Store) -> list[tuple[str, str]]:
    found = left_active(store)
    return [(one.module or one.port, LOCK_IN_DOUBT if one.is_lock_unconfirmed else ACTIVE) for one in found]


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
    note_report(store, port=USB, adapter="", module=module, origin="window", is_active=is_active)


def wait(store: Store) -> None:
    store.queue.submit(lambda: None).result(5)


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
