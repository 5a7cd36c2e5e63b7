"""The Commands page through real clicks and keys. The frames at the module are counted: never one too many."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.ritual import Stage
from protocol.messages import Source
from tests.support.line.odd_module import end_faults
from tests.support.records.stored import audit as audited
from tests.support.window.fakes_ui import simulated, store_of
from tests.support.window.settings_bench import Desk, desk
from tests.support.window.steps import given, notice_text, settle
from ui.acts.ritual_widget import RitualWidget

DEPLOY = REQUESTS[Act.DEPLOY].encode()
HELD_MS = 2000


def wait_disarmed(one: Desk, ritual: RitualWidget) -> None:
    one.until(lambda: ritual.ritual.stage is Stage.IDLE, 1.0)


def outcome(one: Desk) -> str:
    return notice_text(one.commands.ritual.notice_bar)


def audit(one: Desk) -> list[tuple[Act, Outcome]]:
    store = store_of(one.assembly.storage)
    return [(entry.act, entry.outcome) for entry in audited(store)]


def arm(one: Desk, *, is_rehearsal: bool = False) -> RitualWidget:
    """Choose and arm by mouse."""
    ritual = one.commands.ritual
    first = ritual.rehearse if is_rehearsal else ritual.choose
    one.until(first.isEnabled)
    one.click(first)
    one.until(ritual.arm.isEnabled)
    one.click(ritual.arm)
    assert ritual.ritual.stage is Stage.ARMED
    assert ritual.cancel.hasFocus()
    settle(ritual.hold)
    return ritual


def press(one: Desk) -> None:
    one.qtbot.mousePress(one.commands.ritual.hold, Qt.MouseButton.LeftButton)


def release(one: Desk) -> None:
    one.qtbot.mouseRelease(one.commands.ritual.hold, Qt.MouseButton.LeftButton)


def stays_quiet(one: Desk, ms: int = HELD_MS + 700) -> None:
    """Time enough for a whole hold; nothing leaves, and the module has not fired."""
    one.wait(ms / 1000)
    assert one.changes() == []
    assert not one.bench.module.is_triggered


def test_the_whole_ritual_sends_one_frame(active: Desk) -> None:
    ritual = arm(active)
    press(active)
    assert ritual.ritual.stage is Stage.HOLDING
    active.until(lambda: active.bench.module.is_triggered)
    active.until(lambda: outcome(active) == "The module reports that it has fired.")
    active.wait(HELD_MS / 1000)  # still held: one gesture is one frame
    assert active.changes() == [DEPLOY]
    assert audit(active) == [(Act.DEPLOY, Outcome.CONFIRMED)]
    assert active.commands.ritual._services.armed.act is None


def test_the_whole_ritual_by_keyboard_alone(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    def focused() -> QWidget:
        return given(QApplication.focusWidget())

    with desk(qtbot, qapp, tmp_path, "commands", active=True) as one:
        ritual = one.commands.ritual
        one.until(ritual.choose.isEnabled)
        settle(ritual.choose)
        ritual.choose.setFocus()
        qtbot.keyClick(focused(), Qt.Key.Key_Space)
        assert focused() is ritual.cancel
        one.until(ritual.arm.isEnabled)
        qtbot.keyClick(focused(), Qt.Key.Key_Tab)
        assert focused() is ritual.arm
        settle(ritual.arm)
        qtbot.keyClick(focused(), Qt.Key.Key_Space)
        assert (focused(), ritual.ritual.stage) == (ritual.cancel, Stage.ARMED)
        qtbot.keyClick(focused(), Qt.Key.Key_Tab)
        assert focused() is ritual.hold
        settle(ritual.hold)
        qtbot.keyPress(focused(), Qt.Key.Key_Space)
        one.until(lambda: one.bench.module.is_triggered)
        one.until(lambda: "has fired" in outcome(one))
        assert one.changes() == [DEPLOY]


def test_a_rehearsal_needs_no_module_that_is_ready(one: Desk) -> None:
    ritual = one.commands.ritual
    assert "LOCKED" in ritual.conditions.text()
    assert ritual.conditions.isVisible()
    assert not ritual.choose.isEnabled()  # in earnest it would be refused
    arm(one, is_rehearsal=True)
    assert not ritual.conditions.isVisible()  # they are none of a rehearsal
    press(one)
    one.until(lambda: "42 61 11 02 01 14 was not sent" in outcome(one))
    assert (one.changes(), audit(one)) == ([], [])


def test_letting_go_too_early_sends_nothing(active: Desk) -> None:
    ritual = arm(active)
    press(active)
    active.wait(0.2)
    release(active)
    assert ritual.ritual.stage is Stage.IDLE
    stays_quiet(active)


def test_the_ten_seconds_run_out(active: Desk) -> None:
    ritual = arm(active)
    assert ritual.countdown.isVisible()
    active.until(lambda: ritual.ritual.stage is Stage.IDLE, 11)
    assert outcome(active) == "Disarmed: time is up. Nothing was sent."
    assert not ritual.hold.isVisible()
    stays_quiet(active, 200)


OF_THE_PERSON: dict[str, tuple[Callable[[Desk], None], str]] = {
    "focus": (lambda one: one.assembly.window.navigation.setFocus(), "focus lost"),
    "page": (lambda one: one.assembly.window.go_to("settings"), "Disarmed"),
    "escape": (lambda one: one.qtbot.keyClick(one.commands.ritual.hold, Qt.Key.Key_Escape), "cancelled"),
    "cancel": (lambda one: one.click(one.commands.ritual.cancel), "cancelled"),
    "window": (lambda one: one.assembly.window.hide(), "window left"),  # the last one
}
OF_THE_MODULE: dict[str, tuple[Callable[[Desk], None], str]] = {
    "locked meanwhile": (lambda one: one.bench.module.activate(is_active=False), "a condition is not met"),
    "restart": (lambda one: one.bench.restart(), "Disarmed"),
    "unplugged": (lambda one: one.bench.unplug(), "Disarmed"),  # the last one
}


@pytest.mark.promise("j")
def test_whatever_a_person_does_instead_disarms(full_desk: Desk) -> None:
    for why, (act, text) in OF_THE_PERSON.items():
        full_desk.go_to("commands")
        ritual = arm(full_desk)
        assert text not in outcome(full_desk), why
        press(full_desk)
        full_desk.wait(0.3)
        act(full_desk)
        wait_disarmed(full_desk, ritual)
        assert ritual._services.armed.act is None, why
        assert text in outcome(full_desk), why
        stays_quiet(full_desk, 300)
        release(full_desk)


@pytest.mark.promise("j")
def test_whatever_becomes_of_the_module_disarms(active: Desk) -> None:
    ritual = active.commands.ritual
    for why, (act, text) in OF_THE_MODULE.items():
        active.bench.module.activate(is_active=True)
        arm(active)
        assert text not in outcome(active), why
        press(active)
        active.wait(0.3)
        act(active)
        # What comes over the line takes its way first: a restart is two heartbeats, 50 ms apart.
        active.until(lambda: ritual.ritual.stage is Stage.IDLE)
        assert ritual._services.armed.act is None, why
        assert text in outcome(active), why
        stays_quiet(active, 300)
        release(active)


def test_a_sleep_of_the_computer_disarms_before_a_hold_is_complete(active: Desk) -> None:
    ritual = arm(active)
    press(active)
    active.wait(0.3)
    active.clock.now_s += 60.0
    active.until(lambda: ritual.ritual.stage is Stage.IDLE)
    assert ritual._services.armed.act is None
    assert "Disarmed" in outcome(active)
    stays_quiet(active, HELD_MS)


@pytest.mark.promise("c")
def test_an_error_anywhere_in_the_window_disarms(qtbot: QtBot, active: Desk) -> None:

    def fail() -> None:
        raise RuntimeError("a fault of ours")

    with qtbot.capture_exceptions() as faults:
        ritual = arm(active)
        press(active)
        timer = QTimer(active.assembly.window, singleShot=True)
        timer.timeout.connect(fail)
        timer.start(0)
        wait_disarmed(active, ritual)
    assert [str(one_fault[1]) for one_fault in faults] == ["a fault of ours"]
    assert "program error" in outcome(active)
    ritual = arm(active)
    active.assembly.armed.act = None  # by an error in another thread
    wait_disarmed(active, ritual)
    stays_quiet(active, 300)


def test_of_a_port_that_is_gone_nothing_arrives_late(active: Desk) -> None:
    active.bench.unplug()
    active.until(lambda: not active.assembly.ports.current.is_open)
    active.wait(3.0)
    page = active.commands
    labels = [*(row.conditions for row in page.acts.values()), page.ritual.conditions]
    texts = [label.text() for label in labels]
    assert set(texts) == {"Not connected"}


def test_after_a_trigger_it_says_fired_until_the_module_says_otherwise(active: Desk) -> None:
    meaning, until_locked = active.commands.meaning, "Treat it as ready to fire until it reports LOCKED."
    active.until(lambda: meaning.text() == "Ready to fire: lock it before you touch it.")
    active.bench.module.fire(Source.SERIAL, active.assembly.ports.clock())
    active.until(lambda: meaning.text() == f"Fired. {until_locked}")
    active.bench.module.state.is_active = False  # LOCK would end the trigger, too
    active.until(lambda: meaning.text() == "Fired. Find out why (Triggers), repack, restart.")
    active.bench.change(drop=1.0, direction="both")
    active.until(lambda: meaning.text() == f"Fired. {until_locked}")  # silent: it may be active by now
    end_faults(active.bench)
    active.bench.restart()
    active.until(lambda: meaning.text() == "The module is LOCKED.")


def test_what_was_said_of_one_module_is_not_said_of_the_next(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "commands") as one, simulated("next"):
        row = one.commands.acts[Act.ZERO]
        for _ in range(2):
            one.until(row.confirm.ask.isEnabled)
            one.ask(row.confirm)
            assert row.notice_bar.notice is None, "nor of the next act"
            one.click(row.confirm.go)
            one.until(lambda: (notice := row.notice_bar.notice) is not None and "Acknowledged" in notice.text)
        one.assembly.ports.connect_to(Target("sim://next", 115200))
        one.until(lambda: row.notice_bar.notice is None)


def test_a_restart_of_an_active_module_is_shown_on_every_page_until_a_person_closes_it(full_desk: Desk) -> None:
    full_desk.go_to("commands")
    bar = full_desk.assembly.window.notice_bar
    full_desk.bench.restart()
    for text in ("may have fired before the restart", "Interrupted at"):
        full_desk.until(lambda text=text: text in notice_text(bar))  # type: ignore[misc]
        given(given(bar.notice).dismiss)()
    full_desk.until(lambda: bar.notice is None)
