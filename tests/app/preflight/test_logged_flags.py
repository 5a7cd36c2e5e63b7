"""What the audit log says of a trigger that cannot be read, and when it says nothing."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.device import StatusSample
from app.preflight.evidence import Disturbance, Evidence, FlagState, TriggerFlag
from app.preflight.logged_flags import with_logged_flags
from app.preflight.verdict import Void
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.store import Store, open_store
from app.text.messages import UserMessage
from protocol.catalogue import BAUD_RATE, BY_NAME
from protocol.fields import Value
from tests.support.check_pace import hurry_check
from tests.support.journals import FakeJournal
from tests.support.window.preflight_window import name_module, on_bench
from ui.pages.preflight.controller import Standing

PORT, ADAPTER = "/dev/ttyUSB0", "0403:6001 A1"
TRIGGER = BY_NAME["attitude_trigger"]
SETTINGS: Mapping[str, Value] = {
    "attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6, "light_threshold_v": 1.8,
}  # fmt: skip
DETAIL: Mapping[str, object] = {"boot_count": 37, "settings": SETTINGS, "adapter": ADAPTER, "module": "M-07"}
AT = datetime(2026, 5, 4, 8, 0, tzinfo=UTC)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    found = open_store(tmp_path, clock=lambda: AT)
    yield found
    found.close()


def _log(
    store: Store, act: Act, frame: bytes, outcome: Outcome | None, *, port: str = PORT, is_acknowledged: bool = True,
    **detail: object,
) -> None:  # fmt: skip
    entry = store.begin(act, frame, {**DETAIL, **detail}, port=port, origin="test")
    if outcome is not None:
        store.settle(entry, outcome, {"acknowledged": is_acknowledged})


def _enable(store: Store, outcome: Outcome | None = Outcome.CONFIRMED, *, port: str = PORT,
            is_acknowledged: bool = True, **detail: object) -> None:  # fmt: skip
    frame = TRIGGER.set(True).encode()
    _log(store, Act.WRITE, frame, outcome, port=port, is_acknowledged=is_acknowledged, **detail)


def _seen(
    *, boots: int = 37, is_active: bool = True, fate: FlagState = FlagState.NEVER_SET, **settings: Value
) -> Evidence:
    return Evidence(
        port=PORT, ended_at=1.0, values={**SETTINGS, **settings, "boot_count": boots},
        flags={TRIGGER.key: TriggerFlag(fate)}, status=StatusSample(0.0, 0, 10, triggered=False, active=is_active),
    )  # fmt: skip


def _fate(store: Store, evidence: Evidence | None = None, *, adapter: str = ADAPTER, module: str | None = "M-07",
          minutes: float = 3.0) -> FlagState:  # fmt: skip
    at = AT + timedelta(minutes=minutes)
    found = with_logged_flags(evidence or _seen(), store, adapter=adapter, module=module, at=at)
    return found.flags[TRIGGER.key].state


def test_the_last_set_counts_with_its_age(store: Store) -> None:
    _enable(store)
    seen = _seen()
    found = with_logged_flags(seen, store, adapter=ADAPTER, module="M-07", at=AT + timedelta(minutes=3)).flags
    assert found[TRIGGER.key].state is FlagState.ENABLED
    assert found[TRIGGER.key].logged == (1, 180.0)
    assert seen.flags[TRIGGER.key] == TriggerFlag()
    assert _fate(store, module=None) is FlagState.ENABLED
    assert _fate(store, _seen(fate=FlagState.NOT_SENT)) is FlagState.ENABLED


@pytest.mark.parametrize("fate", [FlagState.DISABLED, FlagState.REFUSED, FlagState.UNANSWERED])
def test_what_the_module_said_to_this_program_is_never_replaced(store: Store, fate: FlagState) -> None:
    _enable(store)
    assert _fate(store, _seen(fate=fate)) is fate
    assert _fate(store, _seen(fate=FlagState.NOT_SENT, is_active=False)) is FlagState.NOT_SENT


@pytest.mark.parametrize("evidence", [
    _seen(boots=38), _seen(boots=36), _seen(freefall_time_s=1.5), replace(_seen(), values={**SETTINGS}),
    replace(_seen(), values={"boot_count": 37}), replace(_seen(), disturbance=Disturbance.RESTARTED),
    replace(_seen(), ended_at=None), replace(_seen(), port="/dev/ttyUSB1"),
])  # fmt: skip
def test_another_start_other_settings_or_another_port_say_nothing(store: Store, evidence: Evidence) -> None:
    _enable(store)
    assert _fate(store, evidence) is FlagState.NEVER_SET


def test_another_adapter_another_name_or_an_old_entry_say_nothing(store: Store) -> None:
    _enable(store)
    assert _fate(store, adapter="") is FlagState.NEVER_SET
    assert _fate(store, module="M-08") is FlagState.NEVER_SET
    assert _fate(store, minutes=15.1) is FlagState.NEVER_SET
    assert _fate(store, minutes=-1) is FlagState.NEVER_SET
    assert _fate(store, minutes=14.9) is FlagState.ENABLED


def _no_frame(store: Store) -> None:
    _log(store, Act.WRITE, b"x", Outcome.CONFIRMED)


@pytest.mark.parametrize("spoil", [
    lambda store: _log(store, Act.WRITE, TRIGGER.set(False).encode(), Outcome.CONFIRMED),
    lambda store: _log(store, Act.WRITE, TRIGGER.set(False).encode(), Outcome.CONFIRMED, port="/dev/ttyUSB1"),
    lambda store: _enable(store, boot_count=None),  # written by an older version
    lambda store: _log(store, Act.ACTIVATE, b"", Outcome.UNKNOWN),
    lambda store: _log(store, Act.CHANGE_BAUD, BAUD_RATE.set(9600).encode(), Outcome.UNKNOWN),
    lambda store: _log(store, Act.SHUTDOWN, b"", Outcome.CONFIRMED),
    _no_frame,
    lambda store: store.database.write("UPDATE audit SET origin = 'x' WHERE id = 1"),
    lambda store: _enable(store, None), lambda store: _enable(store, Outcome.REFUSED),
    lambda store: _enable(store, is_acknowledged=False), lambda store: _enable(store, port="/dev/ttyUSB1"),
])  # fmt: skip
def test_what_comes_after_it_casts_doubt(
    store: Store, spoil: Callable[[Store], None], caplog: pytest.LogCaptureFixture
) -> None:
    _enable(store)
    assert _fate(store) is FlagState.ENABLED
    spoil(store)
    assert _fate(store) is FlagState.NEVER_SET
    assert ("The audit log does not tell" in caplog.text) is (spoil is _no_frame)


def test_what_never_left_and_what_was_done_to_another_module_change_nothing(store: Store) -> None:
    _enable(store)
    _log(store, Act.WRITE, TRIGGER.set(False).encode(), Outcome.NOT_SENT)
    _log(store, Act.WRITE, TRIGGER.set(False).encode(), Outcome.CONFIRMED, port="/dev/ttyUSB1", boot_count=12)
    _log(store, Act.ACTIVATE, b"", Outcome.CONFIRMED)
    _log(store, Act.LOCK, b"", Outcome.CONFIRMED)
    assert _fate(store) is FlagState.ENABLED


def test_in_the_window_it_becomes_go_and_an_unconfirmed_set_ends_it(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hurry_check(monkeypatch, still_s=0.2)
    with on_bench(qtbot, qapp, tmp_path, "logged") as bench:
        work, connector = bench.preflight.work, bench.assembly.connector
        name_module(bench, "M-07")
        assert bench.check() is Standing.READY
        connector.disconnect_port()
        bench.connect()
        name_module(bench, "M-07")
        bench.bench.module.activate(is_active=True)
        qtbot.waitUntil(lambda: work.can_check and bool(work.reported_active), timeout=8000)
        assert bench.check(is_enabling=False) is Standing.GO
        bench.bench.module.activate(is_active=False)
        bench.wait_standing(Standing.READY)
        write = bench.bench.wire.write
        monkeypatch.setattr(
            bench.bench.wire, "write", lambda data, now_s: None if data[2] == TRIGGER.code else write(data, now_s)
        )
        disabled = SettingChange(TRIGGER, False)
        connector.run(
            write_all([disabled], WriteContext(journal=FakeJournal(), accepted_risks=frozenset((disabled,)))),
            lambda _job: None,
        )
        bench.wait_standing(Standing.VOID)
        assert work.void == Void(Disturbance.CHANGED, UserMessage(TRIGGER.title))
