"""The guided tests on a simulated module: each test end to end, and LOCK whatever happens to the one that activates."""

from collections.abc import Callable
from unittest.mock import patch

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QCloseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.guided.guided_tests import GUIDED_TESTS, PersonSteps
from app.guided.results import TITLES, GuidedKind, GuidedResult, GuidedVerdict
from app.safety.journal import REQUESTS, Act
from app.system.uncaught import UncaughtError
from app.text.messages import UserError
from tests.support.line.frames import at_frame
from tests.support.window.hand import Hand
from tests.support.window.steps import given, notice_text
from tests.unit.guided.hands import Hands
from ui.acts.act_row import ActRow
from ui.session.guided import Stage
from ui.style.theme import Meaning
from ui.widgets.step_button import bring_into_sight

KINDS = [test.kind for test in GUIDED_TESTS]
LOCK, ACTIVATE = REQUESTS[Act.LOCK], REQUESTS[Act.ACTIVATE]


@pytest.fixture
def bench(bench: Hand, monkeypatch: pytest.MonkeyPatch) -> Hand:
    monkeypatch.setattr("app.guided.guided_tests.SHAKEN_S", 2.0)
    bench.assembly.storage.open_store()
    bench.preflight.form.who.setText("Li")
    bench.assembly.ports.module.say_name("M-07")
    return bench


def confirm(bench: Hand) -> None:
    """As a careful person does it: ask, then confirm, each by a press of its own."""
    row: ActRow = bench.guided.activate
    bench.until(row.confirm.ask.isEnabled)
    for button in (row.confirm.ask, row.confirm.go):
        bring_into_sight(row)
        bench.until(button.isVisible)
        bench.wait(1.0)
        bench.click(button)


def run(bench: Hand, kind: GuidedKind) -> GuidedResult:
    """From Start to the result, with hands that do what the page says."""
    start(bench, kind)
    if bench.guided.work.test.is_active:
        confirm(bench)
    act_as_told(bench)
    outcome = bench.guided.work.outcome
    assert isinstance(outcome, GuidedResult), outcome
    return outcome


def kept(bench: Hand, kind: GuidedKind) -> None:
    """Until the store's thread has told the page."""
    bench.until(lambda: kind in bench.guided.work.last, limit_s=10_000.0)


def act_as_told(bench: Hand) -> None:
    """Until the test is over."""
    page, hands, ends_at = bench.guided, Hands(bench.bench, PersonSteps()), bench.clock.now_s + 300.0
    while page.work.is_running:
        assert bench.clock.now_s < ends_at, page.title.text()
        if page.work.report is not None:
            hands.hear(page.work.report)
        hands.move(bench.clock.now_s)
        if page.work.confirm_words:
            page.primary.click()
        bench.wait(0.1)


def start(bench: Hand, kind: GuidedKind) -> None:
    page = bench.guided
    bench.show_guided()
    page.work.choose(kind)
    bench.wait(0.3)
    if page.made_safe.isVisible():
        assert not page.primary.isEnabled()
        page.made_safe.click()
    bench.until(page.primary.isEnabled)
    bench.wait(1.0)
    bench.click(page.primary)
    bench.until(lambda: page.work.stage is not Stage.PREPARING)


def activated(bench: Hand) -> None:
    """In the middle of the tilt, on an active module."""
    start(bench, GuidedKind.TILT)
    confirm(bench)
    bench.until(lambda: bench.guided.work.stage is Stage.MEASURING)
    assert bench.bench.module.state.is_active


def is_locked(bench: Hand) -> bool:
    return not bench.bench.module.state.is_active


def said(bench: Hand) -> str:
    return notice_text(bench.guided.notice_bar)


@pytest.mark.promise("c")
def test_each_test_can_be_done_on_the_simulated_module(bench: Hand) -> None:
    acts = {GuidedKind.TILT: [ACTIVATE, LOCK]}
    page = bench.guided
    for number, kind in enumerate(KINDS, start=1):
        bench.requests.clear()
        bench.bench.set_world(tilt_deg=0)
        outcome = run(bench, kind)
        assert outcome.verdict is GuidedVerdict.PASSED, outcome
        bench.until(lambda: not page.work.owes_lock)
        assert is_locked(bench)
        assert list(dict.fromkeys(bench.acts)) == acts.get(kind, [])
        kept(bench, kind)
        last = page.work.last[kind]
        assert (last.verdict, last.who, last.is_simulated) == (GuidedVerdict.PASSED, "Li", True)
        assert len(page.work.last) == number
        assert "passed" in page.list.currentItem().text()
        assert (page.title.text(), page.verdict.text()) == (TITLES[kind], "Passed")


@pytest.mark.promise("i")
def test_what_can_fire_is_said_and_confirmed_each_time_and_start_sends_nothing_but_questions(
    bench: Hand,
) -> None:
    page = bench.guided
    bench.show_guided()
    for kind in KINDS:
        page.work.choose(kind)
        assert page.safety.isVisible()
        assert page.made_safe.isVisible() is (kind is GuidedKind.TILT)
    page.work.choose(GuidedKind.TILT)
    page.made_safe.click()
    bench.until(page.primary.isEnabled)
    page.work.choose(GuidedKind.BAY)
    page.work.choose(GuidedKind.TILT)
    assert not page.made_safe.isChecked()
    for kind in KINDS:
        start(bench, kind)
        bench.guided.work.choose(next(other for other in KINDS if other is not kind))
        assert (bench.guided.work.kind, bench.guided.work.is_running) == (kind, True)
        assert bench.acts == []
        bench.guided.work.cancel()
    assert bench.guided.work.owes_lock is False


@pytest.mark.promise("c")
def test_an_active_module_is_not_tested_and_one_that_becomes_active_in_somebodys_hands_is_locked(
    bench: Hand,
) -> None:
    bench.settle_module(is_active=True)
    bench.show_guided()
    bench.guided.work.choose(GuidedKind.BAY)
    bench.wait(0.5)
    assert not bench.guided.primary.isEnabled()
    assert "ACTIVE" in notice_text(bench.guided.notice_bar)
    bench.settle_module(is_active=False)
    for kind in KINDS[1:3]:
        start(bench, kind)
        bench.bench.module.activate(is_active=True)
        bench.until(lambda: not bench.guided.work.is_running)
        bench.until(lambda: is_locked(bench))
        assert "ACTIVE" in bench.guided.verdict.text()
        bench.until(lambda: not bench.guided.work.owes_lock)


def _minimise(bench: Hand) -> None:
    bench.window.setWindowState(Qt.WindowState.WindowMinimized)
    bench.look()
    bench.window.setWindowState(Qt.WindowState.WindowNoState)


def _choose_another_module(bench: Hand) -> None:
    ports = bench.assembly.ports
    tested = ports.current
    ports.choose(ports.add())
    bench.wait(1.0)
    assert is_locked(bench)
    ports.choose(tested)


def _error_in_the_procedure(bench: Hand) -> None:
    with patch("app.guided.guided_tests.ask_report", side_effect=RuntimeError("a mistake of ours")):
        bench.wait(0.5)
    assert "program error" in bench.guided.verdict.text()


def _done(bench: Hand) -> None:
    bench.bench.module.state.attitude_is_enabled = False
    act_as_told(bench)


WAYS_OUT: dict[str, Callable[[Hand], object]] = {
    "cancel": lambda bench: bench.guided.cancel.click(),
    "escape": lambda bench: QTest.keyClick(bench.window, Qt.Key.Key_Escape),
    "another page": lambda bench: bench.window.go_to("commands"),
    "minimised": _minimise,
    "error": _error_in_the_procedure,
    "another module": _choose_another_module,
    "nobody": lambda bench: bench.wait(6.0),
    "done": _done,
    "closed": lambda bench: QApplication.sendEvent(bench.window, QCloseEvent()),  # the last one
}


@pytest.mark.promise("c")
def test_the_module_is_locked_whatever_ends_the_tilt(bench: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.guided.guided_tests.PERSON_LIMIT_S", 5.0)
    for way, leave in WAYS_OUT.items():
        bench.requests.clear()
        activated(bench)
        leave(bench)
        bench.wait(1.0)
        assert is_locked(bench), way
        assert LOCK in bench.acts, way
        assert not bench.guided.work.is_running, way
        bench.until(lambda: not bench.guided.work.owes_lock)
        assert bench.acts.count(ACTIVATE) == 1, way
        bench.bench.module.state.attitude_is_enabled = True
        bench.bench.set_world(tilt_deg=0)


@pytest.mark.promise("c")
def test_an_error_anywhere_in_the_window_locks(bench: Hand) -> None:
    activated(bench)
    bench.assembly.window.attention.report(UncaughtError("a mistake of ours", ""))
    bench.wait(1.0)
    assert is_locked(bench)
    assert "program error" in bench.guided.verdict.text()


@pytest.mark.promise("l")
def test_that_the_module_reports_locked_is_not_said_while_it_is_silent(bench: Hand) -> None:
    activated(bench)
    bench.guided.work.cancel()
    reported = "The module reports LOCKED."
    bench.until(lambda: said(bench) == reported)
    # What was cancelled stood beside a success bar.
    assert "cancelled" in bench.guided.verdict.text()
    assert given(bench.guided.notice_bar.notice).meaning is not Meaning.GOOD
    bench.bench.change(mute=True)
    bench.wait(8.0)
    assert said(bench) != reported


@pytest.mark.promise("cl")
def test_a_pulled_plug_is_said_and_lock_waits_for_the_port(bench: Hand) -> None:
    activated(bench)
    port = bench.assembly.ports.current
    bench.bench.unplug()
    bench.wait(1.0)
    assert isinstance(bench.guided.work.outcome, UserError)
    bench.until(lambda: "LOCK not confirmed: treat the module as ACTIVE" in said(bench))
    assert LOCK not in bench.acts
    (report,) = port.interruptions.remainders
    assert (report.text is not None, report.module) == (True, "M-07")
    bench.bench.plug()
    bench.assembly.ports.connect_to(given(port.target))
    bench.until(lambda: is_locked(bench))
    bench.until(lambda: not port.lock.is_owed)
    work = bench.guided.work
    assert (port.module.name, work.kind, work.stage) == ("", GuidedKind.TILT, Stage.READY), "it stays chosen"
    assert port.interruptions.remainders == (report,), "until a person closes it"


@pytest.mark.promise("c")
def test_an_activation_that_is_not_confirmed_locks(bench: Hand) -> None:
    start(bench, GuidedKind.TILT)
    at_frame(bench.bench, 1, lambda: bench.bench.change(mute=True), code=ACTIVATE.command.code)
    confirm(bench)
    bench.wait(16.0)
    assert isinstance(bench.guided.work.outcome, UserError)
    assert bench.acts.count(LOCK) > 1
    assert is_locked(bench)
    assert bench.assembly.ports.current.lock.failed is not None


def test_an_order_that_was_refused_leaves_the_test_where_it_is(bench: Hand) -> None:
    """Tilted beyond the threshold it may not be activated; levelled it may, and never if it is cancelled between the
    confirmation and the frame."""
    start(bench, GuidedKind.TILT)
    row = bench.guided.activate
    bench.bench.set_world(tilt_deg=80)
    bench.until(lambda: not row.confirm.ask.isEnabled())
    assert "80°" in row.conditions.text()
    bench.bench.set_world(tilt_deg=0)
    confirm(bench)
    bench.guided.work.cancel()
    bench.wait(3.0)
    assert ACTIVATE not in bench.acts
    assert is_locked(bench)


def test_a_result_stays_that_of_the_name_under_which_it_was_measured(bench: Hand) -> None:
    work, say_name = bench.guided.work, bench.guided.module.say_name
    say_name("")
    run(bench, GuidedKind.LINK)
    bench.until(lambda: said(bench) == "Without a name the result counts for no check.")
    assert not work.last
    say_name("M-07")
    run(bench, GuidedKind.LINK)
    kept(bench, GuidedKind.LINK)
    assert said(bench) == ""
    say_name("M-08")
    bench.until(lambda: said(bench) == "The result is that of M-07.")
    assert not work.last


def test_a_step_is_confirmed_by_the_pointer_that_pressed_start_and_a_double_click_is_one(bench: Hand) -> None:
    """It looked enabled, and was dead until the pointer had left: held for hung."""
    page = bench.guided
    start(bench, GuidedKind.BAY)
    bench.until(lambda: page.work.confirm_words == "Bay closed")
    bench.click()
    bench.press(is_double=True)
    bench.release()
    while page.work.stage is Stage.MEASURING and page.work.confirm_words != "Bay open":
        assert page.work.step == 0, "as long as it measures, the bay stays closed"
        bench.wait(0.1)
    bench.bench.set_world(bay_is_open=True)
    assert page.work.steps.is_waiting
    bench.click()
    bench.until(lambda: page.work.stage is Stage.DONE)
    assert isinstance(page.work.outcome, GuidedResult)
    assert page.work.outcome.verdict is GuidedVerdict.PASSED


@pytest.mark.promise("l")
def test_beside_a_doubt_the_test_says_what_the_top_bar_says(bench: Hand) -> None:
    port = bench.assembly.ports.current
    bench.settle_module(is_active=True)
    before = port.module.number
    bench.bench.restart()
    bench.until(lambda: port.module.number > before and port.module.is_read)
    assert port.firing_doubt.is_open
    activated(bench)
    bench.until(lambda: "may have fired" in bench.guided.live.text())
    assert "not triggered" not in bench.guided.live.text()
    # Nor does the banner contradict the test that makes the module fire; ended, nobody else says what comes next.
    bar, module = bench.window.notice_bar, bench.assembly.ports.module
    bench.bench.set_world(tilt_deg=70)
    bench.until(lambda: module.view.fresh("triggered", bench.clock.now_s))
    bench.wait(1.0)
    assert "TRIGGERED" in bench.guided.live.text()
    assert "has triggered" not in notice_text(bar)
    bench.guided.work.cancel()
    bench.until(lambda: "has triggered" in notice_text(bar))
