"""The Commands page through real clicks and keys. The frames at the module are counted: never one too many."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.engine.target import Target
from app.procedures.act import Performed
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.ritual import Stage
from app.store.fact_store import StoreError
from app.system.uncaught import UncaughtError
from protocol.messages import Source
from tests.support.line.frames import lose
from tests.support.records.stored import audit as audited
from tests.support.window.desk import desk
from tests.support.window.fakes_ui import simulated, store_of
from tests.support.window.rig import Rig
from tests.support.window.steps import given, notice_text, settle
from ui.acts.act_row import ActRow, outcome_meaning
from ui.acts.ritual_widget import RitualWidget
from ui.style.theme import Meaning

DEPLOY, LOCK = REQUESTS[Act.DEPLOY].encode(), REQUESTS[Act.LOCK].encode()
HELD_S = 2.0


def said(one: Rig, act: Act) -> str:
    return notice_text(one.commands.acts[act].notice_bar)


def outcome(one: Rig) -> str:
    return notice_text(one.commands.ritual.notice_bar)


def audit(one: Rig) -> list[tuple[Act, Outcome]]:
    return [(entry.act, entry.outcome) for entry in audited(store_of(one.assembly.storage))]


def ask(one: Rig, act: Act) -> ActRow:
    row = one.commands.acts[act]
    one.until(row.confirm.ask.isEnabled)
    one.ask(row.confirm)
    return row


def choose(one: Rig) -> RitualWidget:
    ritual = one.commands.ritual
    one.until(ritual.choose.isEnabled)
    one.click(ritual.choose)
    assert ritual.ritual.stage is Stage.CHOSEN
    return ritual


def arm(one: Rig) -> RitualWidget:
    """Choose and arm by mouse."""
    ritual = choose(one)
    one.until(ritual.arm.isEnabled)
    one.click(ritual.arm)
    assert ritual.ritual.stage is Stage.ARMED
    assert ritual.cancel.hasFocus()
    settle(ritual.hold)
    return ritual


def press(one: Rig) -> None:
    one.qtbot.mousePress(one.commands.ritual.hold, Qt.MouseButton.LeftButton)


def release(one: Rig) -> None:
    one.qtbot.mouseRelease(one.commands.ritual.hold, Qt.MouseButton.LeftButton)


def stays_quiet(one: Rig, seconds: float = HELD_S + 0.7) -> None:
    """Time enough for a whole hold; nothing leaves, and the module has not fired."""
    one.wait(seconds)
    assert one.changes() == []
    assert not one.bench.module.is_triggered


# Acts of two clicks


@pytest.mark.promise("d")
def test_an_act_takes_two_clicks_and_is_sent_once(qtbot: QtBot, one: Rig) -> None:
    for act in (Act.ZERO, Act.FORBID_DEPLOY, Act.ACTIVATE, Act.SHUTDOWN):
        row = ask(one, act)
        before, told = one.changes(), audit(one)
        assert row.confirm.cancel.hasFocus()
        qtbot.keyClick(row.confirm.cancel, Qt.Key.Key_Tab)
        assert row.confirm.go.hasFocus(), "Tab leads from Cancel to the other answer"
        qtbot.keyClick(row.confirm.go, Qt.Key.Key_Escape)
        assert not row.confirm.is_asking
        assert one.changes() == before
        ask(one, act)
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


@pytest.mark.module(tilt=70)
def test_an_act_that_is_refused_names_the_open_condition(one: Rig) -> None:
    row = one.commands.acts[Act.ACTIVATE]
    one.until(lambda: "threshold 60°" in row.conditions.text())
    assert not row.confirm.ask.isEnabled()
    one.bench.set_world(tilt_deg=0)
    ask(one, Act.ACTIVATE)
    one.bench.set_world(tilt_deg=70)
    one.until(lambda: not row.confirm.ask.isEnabled())
    assert not row.confirm.is_asking, "the question is withdrawn, and not only after its time"
    assert one.changes() == []


@pytest.mark.parametrize("end", ["lock", "restart"])
def test_an_unanswered_activation_is_to_be_treated_as_active_until_it_is_locked_or_restarts(end: str, one: Rig) -> None:
    module = one.assembly.ports.module
    one.click("lock_button")
    one.until(lambda: one.assembly.ports.current.lock.confirmed is not None)
    row = ask(one, Act.ACTIVATE)
    end_loss = lose(one.bench, 0x10)
    one.click(row.confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE).startswith("Sent, not confirmed"))
    assert one.changes() == [LOCK, REQUESTS[Act.ACTIVATE].encode()]
    end_loss()
    one.wait(0.6)
    assert module.view.fresh("active", module.now_s) is False
    assert said(one, Act.ACTIVATE).startswith("Sent, not confirmed"), "its report may be late"
    if end == "restart":
        one.bench.restart()
    else:
        one.click("lock_button")
    one.until(lambda: not said(one, Act.ACTIVATE))


@pytest.mark.promise("l")
def test_that_the_module_reports_active_is_not_said_while_it_is_silent(one: Rig) -> None:
    one.click(ask(one, Act.ACTIVATE).confirm.go)
    one.until(lambda: said(one, Act.ACTIVATE) == "The module reports ACTIVE.")
    one.bench.change(mute=True)
    one.until(lambda: not said(one, Act.ACTIVATE))


@pytest.mark.promise("h")
def test_without_a_log_nothing_dangerous_is_sent_and_locking_is(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise StoreError("It cannot be used.")

    monkeypatch.setattr("app.store.fact_store.open_file", fail)
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as one:
        assert notice_text(one.assembly.window.notice_bar) == "It cannot be used."
        one.commands.refresh()
        assert "The audit log cannot be written" in one.commands.ritual.conditions.text()
        one.click("lock_button")
        one.until(lambda: not one.bench.module.state.is_active)
        assert one.changes() == [LOCK]


@pytest.mark.promise("h")
def test_the_tilt_is_read_afterwards_and_nothing_is_promised() -> None:
    for status in (StatusSample(0.0, 7, 1.0, False, False), None):
        done = Performed(act=Act.ZERO, outcome=Outcome.CONFIRMED, status=status)
        assert outcome_meaning(done) is Meaning.ATTENTION


# The ritual


def test_the_whole_ritual_sends_one_frame(active: Rig) -> None:
    ritual = arm(active)
    press(active)
    assert ritual.ritual.stage is Stage.HOLDING
    active.until(lambda: outcome(active) == "The module reports that it has fired.")
    active.wait(HELD_S)  # still held: one gesture is one frame
    assert active.changes() == [DEPLOY]
    assert audit(active) == [(Act.DEPLOY, Outcome.CONFIRMED)]
    assert active.assembly.armed.act is None


def test_the_whole_ritual_by_keyboard_alone(qtbot: QtBot, active: Rig) -> None:
    def focused() -> QWidget:
        return given(QApplication.focusWidget())

    ritual = active.commands.ritual
    active.until(ritual.choose.isEnabled)
    ritual.choose.setFocus()
    for step, following in ((ritual.choose, ritual.arm), (ritual.arm, ritual.hold)):
        settle(step)
        qtbot.keyClick(focused(), Qt.Key.Key_Space)
        assert focused() is ritual.cancel
        active.until(following.isEnabled)
        qtbot.keyClick(focused(), Qt.Key.Key_Tab)
        assert focused() is following
    settle(ritual.hold)
    qtbot.keyPress(focused(), Qt.Key.Key_Space)
    active.until(lambda: "has fired" in outcome(active))
    assert active.changes() == [DEPLOY]


def test_neither_a_double_click_nor_a_repeated_key_begins_the_hold(active: Rig) -> None:
    """The ritual relies on its button for that."""
    hold = arm(active).hold
    at = QPointF(hold.rect().center())
    hold.setFocus()
    left, none = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    for event in (
        QMouseEvent(QEvent.Type.MouseButtonDblClick, at, hold.mapToGlobal(at), left, left, none),
        QKeyEvent(QEvent.Type.KeyPress, Qt.Key.Key_Space, none, " ", True),
    ):
        QApplication.sendEvent(hold, event)
        stays_quiet(active)


def test_a_locked_module_is_neither_chosen_nor_armed(one: Rig) -> None:
    ritual = one.commands.ritual
    assert "LOCKED" in ritual.conditions.text()
    assert (ritual.conditions.isVisible(), ritual.choose.isEnabled()) == (True, False)
    one.bench.module.activate(is_active=True)
    one.until(ritual.choose.isEnabled)
    one.click(ritual.choose)
    one.until(ritual.arm.isEnabled)
    one.bench.module.activate(is_active=False)
    one.until(lambda: not ritual.arm.isEnabled())
    assert ritual.ritual.stage is Stage.CHOSEN
    assert "LOCKED" in ritual.conditions.text()


def test_letting_go_too_early_and_ten_seconds_end_it(active: Rig) -> None:
    ritual = arm(active)
    press(active)
    active.wait(0.2)
    release(active)
    assert ritual.ritual.stage is Stage.IDLE
    stays_quiet(active)
    arm(active)
    assert ritual.countdown.isVisible()
    active.until(lambda: ritual.ritual.stage is Stage.IDLE, 11)
    assert outcome(active) == "Disarmed: time is up. Nothing was sent."
    assert not ritual.hold.isVisible()
    stays_quiet(active, 0.2)


def look_elsewhere(one: Rig) -> None:
    other = QWidget()
    other.show()
    other.activateWindow()
    one.wait(0.1)
    other.close()
    one.assembly.window.activateWindow()


def sleep(one: Rig) -> None:
    one.clock.now_s += 60.0


OF_THE_PERSON: dict[str, tuple[Callable[[Rig], None], str]] = {
    "focus": (lambda one: one.assembly.window.navigation.setFocus(), "focus lost"),
    "focus, not held": (lambda one: one.assembly.window.navigation.setFocus(), "focus lost"),
    "page": (lambda one: one.assembly.window.go_to("settings"), "Disarmed"),
    "escape": (lambda one: one.qtbot.keyClick(one.commands.ritual.hold, Qt.Key.Key_Escape), "cancelled"),
    "cancel": (lambda one: one.click(one.commands.ritual.cancel), "cancelled"),
    "another window": (look_elsewhere, "window left"),
    "window": (lambda one: one.assembly.window.hide(), "window left"),  # the last one
}
OF_THE_MODULE: dict[str, tuple[Callable[[Rig], None], str]] = {
    "locked meanwhile": (lambda one: one.bench.module.activate(is_active=False), "a condition is not met"),
    "restart": (lambda one: one.bench.restart(), "Disarmed"),
    "sleep of the computer": (sleep, "Disarmed"),
    "unplugged": (lambda one: one.bench.unplug(), "Disarmed"),  # the last one
}


@pytest.mark.promise("j")
@pytest.mark.parametrize("ends", [OF_THE_PERSON, OF_THE_MODULE], ids=["person", "module"])
@pytest.mark.module("commands", "settings", active=True)
def test_whatever_happens_instead_disarms(one: Rig, ends: dict[str, tuple[Callable[[Rig], None], str]]) -> None:
    for why, (act, text) in ends.items():
        one.go_to("commands")
        one.bench.module.activate(is_active=True)
        ritual = arm(one)
        assert text not in outcome(one), why
        if "not held" not in why:
            press(one)
        one.wait(0.3)
        act(one)
        # What comes over the line takes its way first: a restart is two heartbeats, 50 ms apart.
        one.until(lambda: ritual.ritual.stage is Stage.IDLE, 1.0 if ends is OF_THE_PERSON else 10.0)  # noqa: B023
        assert one.assembly.armed.act is None, why
        assert text in outcome(one), why
        stays_quiet(one, 0.3)
        release(one)


@pytest.mark.promise("c")
def test_an_error_anywhere_in_the_window_disarms(active: Rig) -> None:
    for prepare in (choose, arm):
        ritual = prepare(active)
        active.assembly.window.attention.report(UncaughtError("a fault of ours", ""))
        active.until(lambda: ritual.ritual.stage is Stage.IDLE, 0.1)  # noqa: B023
        assert "program error" in outcome(active)
    assert "a fault of ours" in notice_text(active.assembly.window.notice_bar)
    ritual = arm(active)
    active.assembly.armed.act = None  # by an error in another thread
    active.until(lambda: ritual.ritual.stage is Stage.IDLE, 1.0)
    stays_quiet(active, 0.3)


# What is said


def test_after_a_trigger_it_says_fired_until_the_module_says_otherwise(active: Rig) -> None:
    meaning, until_locked = active.commands.meaning, "Treat it as ready to fire until it reports LOCKED."
    active.until(lambda: meaning.text() == "Ready to fire: lock it before you touch it.")
    active.bench.module.fire(Source.SERIAL, active.assembly.ports.clock())
    active.until(lambda: meaning.text() == f"Fired. {until_locked}")
    active.bench.module.state.is_active = False  # LOCK would end the trigger, too
    active.until(lambda: meaning.text() == "Fired. Find out why (Triggers), repack, restart.")
    active.bench.change(mute=True)
    active.until(lambda: meaning.text() == f"Fired. {until_locked}")  # silent: it may be active by now
    active.bench.change(mute=False)
    active.bench.restart()
    active.until(lambda: meaning.text() == "The module is LOCKED.")


def test_what_was_said_of_one_module_is_not_said_of_the_next_nor_of_a_port_that_is_gone(one: Rig) -> None:
    page = one.commands
    with simulated("next"):
        for _ in range(2):
            row = ask(one, Act.ZERO)
            assert row.notice_bar.notice is None, "nor of the next act"
            one.click(row.confirm.go)
            one.until(lambda: "Acknowledged" in said(one, Act.ZERO))
        one.assembly.ports.connect_to(Target("sim://next", 115200))
        one.until(lambda: not said(one, Act.ZERO))
        one.assembly.ports.current.disconnect_port()
        one.until(lambda: not one.assembly.ports.current.is_open)
        one.wait(3.0)
        labels = [*(row.conditions for row in page.acts.values()), page.ritual.conditions]
        assert {label.text() for label in labels} == {"Not connected"}
