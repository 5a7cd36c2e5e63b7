"""Acts on the Commands page: two clicks and one frame, refused with a reason, LOCK at one click."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.store.database import StoreFault, StoreTrouble
from app.store.store import Store
from tests.support.window.settings_bench import Desk, desk
from tests.support.window.steps import let_lay_out, settle
from tests.ui.pages.commands.test_commands_page import audit, double_click
from ui.services.storage import Storage

DEPLOY = REQUESTS[Act.DEPLOY].encode()


def said(one: Desk, act: Act) -> str:
    notice = one.commands.acts[act].notice_bar.notice
    return "" if notice is None else notice.text


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
def test_an_act_takes_two_clicks_and_is_sent_once(qtbot: QtBot, act: Act, one: Desk) -> None:
    row = one.commands.acts[act]
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    assert row.confirm.cancel.hasFocus()
    qtbot.keyClick(row.confirm.cancel, Qt.Key.Key_Escape)
    assert not row.confirm.is_asking
    assert one.changes() == []
    one.ask(row.confirm)
    one.until(row.confirm.go.isVisible)
    settle(row.confirm.go)
    double_click(one, row.confirm.go)
    one.until(lambda: bool(said(one, act)) and "…" not in said(one, act))
    assert one.changes() == [REQUESTS[act].encode()]
    assert audit(one) == [(act, Outcome.CONFIRMED)]


def test_a_double_click_on_the_first_button_is_no_confirmation(qtbot: QtBot, qapp: QApplication, one: Desk) -> None:
    confirm = one.commands.acts[Act.ACTIVATE].confirm
    window = one.assembly.window
    one.until(confirm.ask.isEnabled)
    corner = confirm.ask.mapTo(window, confirm.ask.rect().center())
    one.ask(confirm)
    qapp.processEvents()
    assert window.childAt(corner) is not confirm.go
    qtbot.keyClick(confirm.cancel, Qt.Key.Key_Return)
    one.wait(0.1)
    assert one.changes() == []


def test_an_act_that_is_refused_names_the_open_condition(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "commands", tilt=70) as one:
        row = one.commands.acts[Act.ACTIVATE]
        one.until(lambda: "threshold 60°" in row.conditions.text())
        assert not row.confirm.ask.isEnabled()
        one.bench.set_tilt(0)
        one.until(row.confirm.ask.isEnabled)
        one.ask(row.confirm)
        one.bench.set_tilt(70)
        one.until(lambda: not row.confirm.is_asking)  # the question is withdrawn
        assert one.changes() == []


def test_what_is_open_before_zeroing_changes_no_height(one: Desk) -> None:
    zero = one.commands.acts[Act.ZERO]
    one.assembly.window.resize(1366, 768)
    for tilt_deg, is_open in ((0, False), (70, True)):
        one.bench.set_tilt(tilt_deg)
        one.until(lambda: zero.confirm.ask.isEnabled() is not is_open)  # noqa: B023  called at once
        let_lay_out(one.commands)
        heights = [row.height() for row in one.commands.acts.values()]
        assert max(heights) - min(heights) <= 2


@pytest.mark.parametrize("end", ["lock", "restart"])
def test_an_unanswered_activation_is_to_be_treated_as_active_until_it_is_locked_or_restarts(
    end: str, one: Desk
) -> None:
    row, connector = one.commands.acts[Act.ACTIVATE], one.assembly.connector
    one.click("lock_button")
    one.until(lambda: one.assembly.connector.current.lock.confirmed is not None)
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    one.bench.change(mute_codes=frozenset((0x10,)))
    one.click(row.confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE).startswith("Sent, not confirmed"))
    assert one.changes() == [REQUESTS[Act.LOCK].encode(), REQUESTS[Act.ACTIVATE].encode()]
    one.bench.change(mute_codes=frozenset())
    one.wait(0.6)
    assert connector.current.device.fresh("active", connector.clock()) is False
    assert said(one, Act.ACTIVATE).startswith("Sent, not confirmed"), "its report may be late"
    if end == "restart":
        one.bench.restart()
    else:
        one.click("lock_button")
    one.until(lambda: not said(one, Act.ACTIVATE))


def test_that_the_module_reports_active_is_not_said_while_it_is_silent(one: Desk) -> None:
    row = one.commands.acts[Act.ACTIVATE]
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    one.click(row.confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE) == "The module reports ACTIVE.")
    one.bench.change(drop=1.0, direction="both")
    one.until(lambda: not said(one, Act.ACTIVATE))


def test_lock_is_one_click(active: Desk) -> None:
    active.click("lock_button")
    active.until(lambda: not active.bench.module.state.is_active)
    active.until(lambda: audit(active) == [(Act.LOCK, Outcome.CONFIRMED)])


def test_without_a_log_nothing_dangerous_is_sent_and_locking_is(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_folder: Path | None) -> Store:
        raise StoreTrouble(StoreFault.READ_ONLY, tmp_path)

    monkeypatch.setattr("ui.services.storage.open_store", fail)
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as one:
        said_above = one.assembly.window.notice_bar.notice
        assert said_above is not None
        assert said_above.text == f"The program may not write into {tmp_path}."
        one.commands.refresh()
        assert "The audit log cannot be written" in one.commands.ritual.conditions.text()
        one.click("lock_button")
        one.until(lambda: not one.bench.module.state.is_active)
        assert one.changes() == [REQUESTS[Act.LOCK].encode()]


def test_a_store_that_cannot_be_had_is_said(qtbot: QtBot, tmp_path: Path) -> None:
    blocked = tmp_path / "a file, not a folder"
    blocked.write_text("", encoding="utf-8")
    storage = Storage(blocked)
    assert not isinstance(storage.store, Store)
    assert str(blocked) in (storage.notice or "")
    assert not storage.journal(None).is_ready
