"""Acts on the Commands page: two clicks and one frame, refused with a reason, LOCK at one click; the smallest
screen.
"""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.procedures.act import Performed
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.ritual import Stage
from app.store.trouble import StoreFault, StoreTrouble
from protocol.messages import Source
from tests.gestures.gesture_bench import GestureBench
from tests.gestures.gesture_table import ACTS, go_to
from tests.support.window.controls import place
from tests.support.window.settings_bench import Desk, desk
from tests.support.window.steps import given, let_lay_out, notice_text, settle
from tests.ui.pages.commands.test_commands_page import audit, double_click
from ui.acts.outcomes import outcome_meaning
from ui.acts.ritual_widget import RitualWidget
from ui.style.theme import Choice as Theme
from ui.style.theme import Meaning
from ui.widgets.step_button import is_in_sight

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
        double_click(one, row.confirm.go)
        one.until(lambda act=act: bool(said(one, act)) and "…" not in said(one, act))  # type: ignore[misc]
        assert one.changes() == [*before, REQUESTS[act].encode()]
        assert set(audit(one)) == {*told, (act, Outcome.CONFIRMED)}
        if act is Act.ACTIVATE:
            one.click("lock_button")


@pytest.mark.promise("d")
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
        one.bench.set_world(tilt_deg=0)
        one.until(row.confirm.ask.isEnabled)
        one.ask(row.confirm)
        one.bench.set_world(tilt_deg=70)
        one.until(lambda: not row.confirm.is_asking)  # the question is withdrawn
        assert one.changes() == []


def test_what_is_open_before_zeroing_changes_no_height(one: Desk) -> None:
    zero = one.commands.acts[Act.ZERO]
    one.assembly.window.resize(1366, 768)
    for tilt_deg, is_open in ((0, False), (70, True)):
        one.bench.set_world(tilt_deg=tilt_deg)
        one.until(lambda: zero.confirm.ask.isEnabled() is not is_open)  # noqa: B023  called at once
        let_lay_out(one.commands)
        heights = [row.height() for row in one.commands.acts.values()]
        assert max(heights) - min(heights) <= 2


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


@pytest.mark.parametrize(
    ("theme", "whole"), [(Theme.LIGHT, (Act.ACTIVATE, Act.ZERO)), (Theme.SUNLIGHT, (Act.ACTIVATE,))], ids=str
)
@pytest.mark.promise("d")
def test_on_the_smallest_screen_the_first_acts_are_whole_and_nothing_moves_them(
    bench: GestureBench, theme: Theme, whole: tuple[Act, ...]
) -> None:
    bench.assembly.appearance.choose(theme)
    bench.window.resize(960, 540)
    bench.window.go_to("commands")
    page = bench.commands

    def places() -> list[QPoint]:
        bench.refresh()
        bench.turn()
        return [place(page.meaning).topLeft(), *(place(row).topLeft() for row in page.acts.values())]

    locked = places()
    for act in whole:
        assert is_in_sight(page.acts[act].confirm), act
    bench.settle_module(is_active=True)
    assert places() == locked
    bench.bench.module.fire(Source.SERIAL, bench.clock())
    bench.until(lambda: bench.device.fresh("triggered", bench.clock()) is True)
    assert places() == locked
    bench.bench.change(mute=True)
    bench.until(lambda: not bench.device.is_going)
    assert places() == locked
    assert "ready to fire" in page.meaning.text()


@pytest.mark.parametrize("theme", [Theme.LIGHT, Theme.SUNLIGHT])
@pytest.mark.promise("d")
def test_the_deploy_panel_keeps_its_place_at_every_step(bench: GestureBench, theme: Theme) -> None:
    bench.assembly.appearance.choose(theme)
    bench.window.resize(960, 540)
    go_to(bench, ACTS[-2])
    ritual = bench.commands.ritual

    def places() -> tuple[QRect, list[QPoint]]:
        bench.refresh()
        bench.turn()
        steps = (ritual.choose, ritual.rehearse, ritual.arm, ritual.hold, ritual.cancel)
        return place(ritual), [place(step).topLeft() for step in steps]

    bench.go_and_click(ritual.rehearse)
    bench.hand_s += 1.0
    bench.go_and_click(ritual.arm)
    assert ritual.ritual.stage is Stage.ARMED
    armed = places()
    bench.go_and_click(ritual.cancel)
    assert ritual.notice_bar.notice is not None
    assert places() == armed
    ritual._job.dismiss()
    assert places() == armed
    bench.go_and_click(ritual.choose)
    assert ritual.ritual.stage is Stage.CHOSEN
    assert places() == armed
    bench.settle_module(is_active=False)
    assert places() == armed


def test_a_new_deploy_panel_shows_only_its_first_step(bench: GestureBench) -> None:
    ritual = RitualWidget(bench.commands.ritual._services)
    ritual.show()
    bench.turn()
    shown = {one for one in (ritual.rehearse, ritual.choose, ritual.arm, ritual.hold, ritual.cancel, ritual.countdown)
             if one.isVisible()}  # fmt: skip
    ritual.close()
    assert shown == {ritual.rehearse, ritual.choose}
