"""Acts on the Commands page: two clicks and one frame, refused with a reason, LOCK at one click; the smallest
screen.
"""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.procedures.act import Performed
from app.safety.journal import REQUESTS, Act, Outcome
from app.store.fact_store import StoreFault, StoreTrouble
from tests.support.window.settings_bench import Desk, desk
from tests.support.window.steps import given, notice_text, settle
from tests.window.pages.commands.test_commands_page import audit
from ui.acts.act_row import outcome_meaning
from ui.style.theme import Meaning

DEPLOY = REQUESTS[Act.DEPLOY].encode()


def said(one: Desk, act: Act) -> str:
    return notice_text(one.commands.acts[act].notice_bar)


@pytest.mark.promise("d")
def test_an_act_takes_two_clicks_and_is_sent_once(qtbot: QtBot, one: Desk) -> None:
    for act in (Act.ZERO, Act.FORBID_DEPLOY, Act.ACTIVATE, Act.SHUTDOWN):
        row = one.commands.acts[act]
        one.until(row.confirm.ask.isEnabled)
        before, told = one.changes(), audit(one)
        one.ask(row.confirm)
        assert row.confirm.cancel.hasFocus()
        qtbot.keyClick(row.confirm.cancel, Qt.Key.Key_Escape)
        assert not row.confirm.is_asking
        assert one.changes() == before
        one.ask(row.confirm)
        one.until(row.confirm.go.isVisible)
        settle(row.confirm.go)
        qtbot.mouseClick(row.confirm.go, Qt.MouseButton.LeftButton)
        if row.confirm.go.isVisible():  # the second press of a double click
            qtbot.mouseDClick(row.confirm.go, Qt.MouseButton.LeftButton)
        one.until(lambda act=act: bool(said(one, act)) and "…" not in said(one, act))  # type: ignore[misc]
        assert one.changes() == [*before, REQUESTS[act].encode()]
        assert set(audit(one)) == {*told, (act, Outcome.CONFIRMED)}
        if act is Act.ACTIVATE:
            one.click("lock_button")


def test_an_act_that_is_refused_names_the_open_condition(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "commands", tilt=70) as one:
        row = one.commands.acts[Act.ACTIVATE]
        one.until(lambda: "threshold 60°" in row.conditions.text())
        assert not row.confirm.ask.isEnabled()
        one.bench.set_world(tilt_deg=0)
        one.until(row.confirm.ask.isEnabled)
        one.ask(row.confirm)
        one.bench.set_world(tilt_deg=70)
        one.until(lambda: not row.confirm.is_asking)  # the question is withdrawn
        assert one.changes() == []


@pytest.mark.parametrize("end", ["lock", "restart"])
def test_an_unanswered_activation_is_to_be_treated_as_active_until_it_is_locked_or_restarts(
    end: str, one: Desk
) -> None:
    row, connector = one.commands.acts[Act.ACTIVATE], one.assembly.ports
    one.click("lock_button")
    one.until(lambda: one.assembly.ports.current.lock.confirmed is not None)
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    one.bench.change(mute_codes=frozenset((0x10,)))
    one.click(row.confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE).startswith("Sent, not confirmed"))
    assert one.changes() == [REQUESTS[Act.LOCK].encode(), REQUESTS[Act.ACTIVATE].encode()]
    one.bench.change(mute_codes=frozenset())
    one.wait(0.6)
    assert connector.current.module.view.fresh("active", connector.clock()) is False
    assert said(one, Act.ACTIVATE).startswith("Sent, not confirmed"), "its report may be late"
    if end == "restart":
        one.bench.restart()
    else:
        one.click("lock_button")
    one.until(lambda: not said(one, Act.ACTIVATE))


@pytest.mark.promise("l")
def test_that_the_module_reports_active_is_not_said_while_it_is_silent(one: Desk) -> None:
    row = one.commands.acts[Act.ACTIVATE]
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    one.click(row.confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE) == "The module reports ACTIVE.")
    one.bench.change(drop=1.0, direction="both")
    one.until(lambda: not said(one, Act.ACTIVATE))


@pytest.mark.promise("l")
def test_lock_is_one_click(active: Desk) -> None:
    active.click("lock_button")
    active.until(lambda: not active.bench.module.state.is_active)
    active.until(lambda: audit(active) == [(Act.LOCK, Outcome.CONFIRMED)])


@pytest.mark.promise("h")
def test_without_a_log_nothing_dangerous_is_sent_and_locking_is(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise StoreTrouble(StoreFault.READ_ONLY, tmp_path)

    monkeypatch.setattr("app.store.fact_store.open_file", fail)
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as one:
        said_above = given(one.assembly.window.notice_bar.notice)
        assert said_above.text == f"The program may not write into {tmp_path}."
        one.commands.refresh()
        assert "The audit log cannot be written" in one.commands.ritual.conditions.text()
        one.click("lock_button")
        one.until(lambda: not one.bench.module.state.is_active)
        assert one.changes() == [REQUESTS[Act.LOCK].encode()]


@pytest.mark.promise("h")
def test_the_tilt_is_read_afterwards_and_nothing_is_promised() -> None:
    for status in (StatusSample(0.0, 7, 1.0, False, False), None):
        done = Performed(act=Act.ZERO, outcome=Outcome.CONFIRMED, status=status)
        assert outcome_meaning(done) is Meaning.ATTENTION
