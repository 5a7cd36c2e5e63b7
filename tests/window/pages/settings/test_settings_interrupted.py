"""What becomes of edits, writes and panels when the conversation ends, when the user leaves, or when another module is
shown."""

import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QLineEdit, QPushButton

from app.diagnosis.causes import NextStep
from app.settings.form import RowState
from protocol.catalogue import BY_NAME
from tests.support.line.frames import lose, refuse
from tests.support.window.desk import choose, notice, pick, say_name, state, type_into, write, written
from tests.support.window.rig import Rig
from tests.support.window.steps import given, notice_text

TILT, TIME = "attitude_threshold_deg", "freefall_time_s"
UNSENT = "Settings not written: 1"


def foot(one: Rig) -> str:
    one.assembly.window.attention.refresh()
    return notice_text(one.assembly.window.notice_bar)


def take_over(one: Rig) -> QPushButton:
    one.assembly.window.attention.refresh()
    return given(one.assembly.window.notice_bar.button("take_over"))


# Edits


def test_edits_of_an_ended_conversation_are_offered_beside_what_the_module_holds_now(one: Rig) -> None:
    say_name(one, "M-07")
    type_into(one, "freefall_time", "1.2")
    type_into(one, "light_threshold", "1.8")  # which it has already
    type_into(one, "attitude_threshold", "650")  # mistyped
    one.bench.module.memory.freefall_time = 150
    one.restart()
    assert one.settings.work.wanted == {}, "the next conversation begins without edits"
    one.settings.refresh()
    assert one.find(QLineEdit, "freefall_time_wanted").text() == "1.50"
    ports = one.assembly.ports
    number = ports.module.number
    choose(one, "name_other", one.assembly.window.notice_bar)
    one.until(lambda: ports.module.number > number and ports.module.is_read)
    one.until(lambda: "First say that it is M-07." in foot(one))
    for name in ("", "M-08", "M-07"):
        say_name(one, name)
        assert take_over(one).isEnabled() is (name == "M-07"), "by none that is not said to be it"
    assert "Free-fall time 1.50 s → 1.20 s" in foot(one)
    assert "650" in foot(one)
    one.click(take_over(one))
    assert one.settings.work.wanted == {TIME: 1.2, TILT: "650"}
    assert one.assembly.window.notice_bar.button("take_over") is None
    assert one.changes() == []
    one.click("attitude_threshold_discard")
    written(one)
    assert state(one, TIME) is RowState.VERIFIED
    assert len(one.changes()) == 1


def test_neither_an_accepted_risk_nor_a_measured_light_comes_over(one: Rig) -> None:
    """Another module may have taken the place of the first between the two measurements."""
    end = refuse(one.bench)
    type_into(one, "attitude_threshold", "40")
    written(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, TILT) is RowState.FAILED)
    end()
    one.settings.refresh()
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    one.until(lambda: not one.settings.calibration.job.is_running)
    one.restart()
    one.settings.refresh()
    assert one.settings.panel is None
    assert one.settings.write.isVisible(), "the table is shown again"
    one.click(take_over(one))
    before = len(one.changes())
    written(one)
    assert "55° or more" in notice(one)
    assert len(one.changes()) == before


def test_nothing_is_edited_pressed_or_sent_after_the_end(one: Rig) -> None:
    page, field = one.settings, one.find(QLineEdit, "freefall_time_wanted")
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "1.2")
    one.bench.unplug()
    one.until(lambda: not field.isEnabled())
    QApplication.processEvents()
    assert not isinstance(QApplication.focusWidget(), QAbstractButton), "who types presses nothing"
    assert QApplication.focusWidget() is not page.note
    assert not page.write.isEnabled()
    assert (page.code.text(), field.text(), state(one, TILT)) == ("Settings code: —", "1.2", RowState.STALE)
    page.work.fill({TILT: 70})
    page.work.write(one.assembly.armed)
    assert page.work.wanted == {TIME: 1.2}
    assert not one.changes()


# What was under way


def test_of_an_interrupted_write_it_is_said_what_became_of_each_setting(one: Rig) -> None:
    for name, text in (("light_threshold", "1.9"), ("attitude_threshold", "70"), ("freefall_time", "1.2")):
        type_into(one, name, text)
    end = lose(one.bench, BY_NAME["attitude_threshold"].code)
    write(one)
    one.until(lambda: len(one.changes()) == 2)  # the second one is not answered
    one.bench.unplug()
    kept = one.assembly.ports.current.interruptions
    one.until(lambda: kept.remainders)
    assert [remainder.drafts is None for remainder in kept.remainders] == [True, False]
    report = given(kept.remainders[0].text).translated()
    assert "Light threshold: verified then" in report
    assert "Attitude threshold: unknown" in report
    assert "Free-fall time: not sent" in report
    assert kept.remainders[1].drafts == {TILT: 70, TIME: 1.2}
    end()
    one.bench.plug()
    one.until(lambda: one.assembly.ports.module.is_going and one.assembly.ports.module.is_read)
    one.wait(3.0)
    assert len(one.changes()) == 2, "in the next conversation nothing goes on by itself"


def test_what_was_written_under_a_name_is_what_was_last_read_of_it(one: Rig) -> None:
    """After a restart the question for the name says nothing of settings that this program wrote."""
    say_name(one, "M-07")
    type_into(one, "freefall_time", "1.2")
    written(one)
    one.restart()
    one.until(lambda: "Is it M-07?" in foot(one))
    assert "Settings:" not in foot(one)
    one.bench.module.memory.freefall_time = 150
    one.restart()
    one.until(lambda: "Free-fall time 1.50 s, was 1.20 s" in foot(one))


@pytest.mark.parametrize("is_sent", [False, True])
def test_what_is_said_of_a_change_of_the_baud_rate_that_was_broken_off(is_sent: bool, one: Rig) -> None:
    ports = one.assembly.ports
    pick(one, "baud_rate", 9600)
    one.settings.refresh()
    one.ask(one.settings.baud.confirm)
    if is_sent:
        lose(one.bench, BY_NAME["baud_rate"].code)
    else:
        one.bench.change(mute=True)
    one.click(one.settings.baud.confirm.go)
    if is_sent:
        one.until(lambda: one.changes("baud_rate"))
    one.bench.unplug()
    one.until(lambda: not ports.current.is_open and not ports.current.is_changing_rate)
    report = given(ports.current.interruptions.remainders[-1].text).translated()
    assert ("maybe at 9600 baud" if is_sent else "not sent") in report
    assert len(one.changes("baud_rate")) == is_sent


# Leaving


def test_losing_edits_is_confirmed_also_those_of_an_ended_conversation(one: Rig) -> None:
    ports, window, bar = one.assembly.ports, one.assembly.window, one.assembly.window.notice_bar
    type_into(one, "freefall_time", "1.2")
    opening = ports.current.connection.opening
    for leave in (window.disconnect_port, lambda: window.take_step(NextStep.CONNECT_AGAIN)):
        leave()
        assert UNSENT in notice_text(bar)
        choose(one, "stay", bar)
    assert (ports.current.is_open, ports.current.connection.opening) == (True, opening)
    assert one.settings.work.wanted == {TIME: 1.2}
    window.disconnect_port()
    choose(one, "drop_edits", bar)
    one.until(lambda: not ports.current.is_open)
    assert not ports.current.interruptions.remainders, "nobody has to be told of what was discarded"
    assert not one.changes()
    one.connect()
    type_into(one, "freefall_time", "1.2")
    one.restart()
    window.close()
    assert window.isVisible()
    assert UNSENT in notice_text(bar)
    choose(one, "drop_edits", bar)
    one.until(lambda: not window.isVisible())


@pytest.mark.module(active=True)
def test_edits_and_an_active_module_are_one_question(one: Rig) -> None:
    window, bar = one.assembly.window, one.assembly.window.notice_bar
    type_into(one, "freefall_time", "1.2")
    window.close()
    assert window.isVisible()
    assert "The module is ACTIVE" in notice_text(bar)
    assert UNSENT in notice_text(bar)
    choose(one, "lock_and_leave", bar)
    one.until(lambda: bar.button("drop_edits") is not None)
    assert "ACTIVE" not in notice_text(bar)
    choose(one, "drop_edits", bar)
    one.until(lambda: not window.isVisible())
    assert len(one.changes()) == 1  # LOCK, and no setting


def test_leaving_while_it_writes_is_confirmed_until_it_is_written(one: Rig) -> None:
    window, bar = one.assembly.window, one.assembly.window.notice_bar
    one.bench.change(lag_ms=100.0)
    type_into(one, "freefall_time", "1.2")
    write(one)
    one.until(lambda: one.settings.work.is_writing)
    one.settings.work.fill({TIME: 1.3, TILT: 80})
    assert one.settings.work.wanted == {TIME: 1.2}, "nothing can be edited while it writes"
    window.close()
    assert window.isVisible()
    assert UNSENT in notice_text(bar)
    one.settings.refresh()
    assert (one.settings.write.text(), one.settings.write.isEnabled()) == ("Write 1 change", False)
    one.bench.change(lag_ms=0.0)
    one.until(lambda: state(one, TIME) is RowState.VERIFIED and bar.notice is None)
    assert window.isVisible()
    window.close()
    assert not window.isVisible()


@pytest.mark.module(is_connected=False)
def test_edits_stay_with_their_module_and_are_asked_for_before_its_port_is_closed(one: Rig) -> None:
    leaving, bar = one.window.leaving, one.window.notice_bar
    first, _module = one.plug_in("/dev/port0")
    second, module = one.plug_in("/dev/port1")
    closed: list[object] = []
    second.module.settings.fill({TIME: 1.2})
    assert first.module.settings.count_unsent() == 0
    one.assembly.ports.choose(second)
    leaving.leave_port(lambda: closed.append(second))
    assert notice_text(bar) == f"{UNSENT}."
    given(bar.button("stay")).click()
    assert (closed, second.module.settings.count_unsent()) == ([], 1)
    module.be_silent(one.clock(), 20.0)
    one.until(lambda: not second.module.is_going)
    leaving.leave_port(lambda: closed.append(second))
    assert (closed, second.interruptions.count_drafts()) == ([second], 1), "its notice offers them on"
