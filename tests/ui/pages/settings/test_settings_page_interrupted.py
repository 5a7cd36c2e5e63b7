"""The Settings page when the user leaves or the link is lost: losing edits is confirmed, nothing unproven is shown."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from app.engine.identity import Trust
from app.settings.form import RowState
from app.store.store import Store
from protocol.link_states import Presence
from tests.support.window.settings_bench import Desk, choose, desk, notice, state, type_into, write
from tests.support.window.steps import notice_text
from ui.style.painted_widget import Freshness

TILT, TIME = "attitude_threshold_deg", "freefall_time_s"


def test_losing_edits_is_confirmed(one: Desk) -> None:
    connector, window, bar = one.assembly.connector, one.assembly.window, one.assembly.window.notice_bar
    type_into(one, "freefall_time", "1.2")
    window.disconnect_port()
    assert "Settings not written: 1" in notice_text(bar)
    choose(one, "stay", bar)
    opening = connector.current.connection.opening
    window._connect_again()
    assert "Settings not written: 1" in notice_text(bar)
    choose(one, "stay", bar)
    assert (connector.current.is_open, connector.current.connection.opening) == (True, opening)
    assert float(one.find(QLineEdit, "freefall_time_wanted").text()) == 1.2
    window.close()
    assert window.isVisible()
    window._connect_again()
    choose(one, "drop_edits", bar)
    one.until(lambda: connector.current.connection.opening > opening and connector.current.is_open)
    type_into(one, "freefall_time", "1.2")
    window.disconnect_port()
    choose(one, "drop_edits", bar)
    one.until(lambda: not connector.current.is_open)
    one.settings.refresh()
    assert one.find(QWidget, "freefall_time_number").property("role") == "muted"
    assert not one.changes()


def test_edits_and_an_active_module_are_two_questions(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", active=True) as one:
        window, bar = one.assembly.window, one.assembly.window.notice_bar
        type_into(one, "freefall_time", "1.2")
        window.close()
        assert bar.button("drop_edits") is not None
        window.close()  # a second attempt is an answer to the first question, not to the next
        assert window.isVisible()
        assert bar.button("lock_and_leave") is not None
        choose(one, "stay", bar)
        window.close()
        choose(one, "drop_edits", bar)
        assert window.isVisible()
        choose(one, "leave_active", bar)
        one.until(lambda: not window.isVisible())
        assert one.changes() == []


def test_a_lost_link_keeps_edits_and_makes_values_stale(one: Desk) -> None:
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    shown = one.settings.rows[TILT].value_label
    one.until(lambda: shown.freshness is Freshness.STALE)
    assert "before the link was lost" in shown.note
    one.settings.refresh()
    assert float(one.find(QLineEdit, "freefall_time_wanted").text()) == 1.2
    assert not one.settings.write.isEnabled()
    one.bench.plug()
    one.until(lambda: shown.freshness is Freshness.FRESH)
    say_same(one)
    write(one)
    one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    assert len(one.changes()) == 1


def say_same(one: Desk) -> None:
    """A person says that what came back is the same module."""
    bar = one.assembly.window.notice_bar
    one.until(lambda: bar.button("identity_same") is not None)
    choose(one, "identity_same", bar)
    one.until(lambda: one.assembly.connector.current.is_open and one.assembly.connector.current.identity.is_settled)


def test_writing_waits_for_the_identity_of_a_returned_module(one: Desk) -> None:
    connector = one.assembly.connector
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.bench.change(delay_ms=100.0)
    one.bench.plug()
    one.until(lambda: connector.current.is_open and connector.current.device.presence is Presence.ONLINE)
    assert connector.current.identity.trust is Trust.OPEN
    one.settings.refresh()
    assert not one.settings.write.isEnabled()
    assert "same module" in notice(one)


def test_leaving_while_it_writes_is_confirmed_until_it_is_written(one: Desk) -> None:
    window, bar = one.assembly.window, one.assembly.window.notice_bar
    one.bench.change(delay_ms=100.0)
    type_into(one, "freefall_time", "1.2")
    write(one)
    one.until(lambda: one.settings.work.form.is_writing)
    window.close()
    assert window.isVisible()
    assert "Settings not written: 1" in notice_text(bar)
    assert (one.settings.write.text(), one.settings.write.isEnabled()) == ("Write 1 change", False)
    one.bench.end_faults()
    one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    one.until(lambda: bar.notice is None)
    assert window.isVisible()
    window.close()
    assert not window.isVisible()


@pytest.mark.parametrize("is_sent", [False, True])
def test_a_change_of_the_baud_rate_that_was_broken_off_is_in_doubt_only_until_the_module_answers(
    is_sent: bool, one: Desk
) -> None:
    panel, connector = one.settings.baud, one.assembly.connector
    panel.editor.box.setCurrentIndex(panel.editor.box.findData(9600))
    panel.refresh()
    one.ask(panel.confirm)
    one.bench.change(**({"mute_codes": frozenset((0x24,))} if is_sent else {"mute": True}))
    one.click(panel.confirm.go)
    one.until(lambda: one.changes("baud_rate") if is_sent else panel.notice_bar.notice is not None)
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.until(lambda: ("maybe at 9600" if is_sent else "Nothing was sent") in notice_text(panel.notice_bar))
    one.bench.change(mute=False)
    one.bench.plug()
    say_same(one)
    if is_sent:
        one.until(lambda: notice_text(panel.notice_bar) == "The module answers at 115200 baud.")
    store = one.assembly.storage.store
    assert isinstance(store, Store)
    one.until(lambda: not store.pending_bauds())
    assert len(one.changes("baud_rate")) == is_sent


@pytest.mark.parametrize("answer", ["identity_same", "identity_new"])
def test_edits_wait_until_it_is_known_whether_it_is_the_same_module(answer: str, one: Desk) -> None:
    connector, work = one.assembly.connector, one.settings.work
    bar, box = one.assembly.window.notice_bar, one.find(QLineEdit, "freefall_time_wanted")
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    memory = one.bench.module.memory
    memory.boot_count -= 20
    memory.freefall_time, memory.attitude_threshold = 120, 85  # it holds the edited value already
    one.bench.restart()
    one.bench.plug()
    one.until(lambda: connector.current.identity.trust is Trust.REFUTED and bar.button(answer) is not None)
    one.until(lambda: state(one, TILT) is RowState.READ)
    one.until(lambda: connector.current.device.known("freefall_time_s", connector.clock()) is not None)
    assert (state(one, TIME), work.count_unsent()) == (RowState.EDITED, 1)
    choose(one, answer, bar)
    if answer == "identity_new":
        assert "Settings not written: 1" in notice_text(bar)
        choose(one, "stay", bar)
        assert (connector.current.identity.trust, float(box.text())) == (Trust.REFUTED, 1.2)
        choose(one, answer, bar)
        choose(one, "drop_edits", bar)
        one.until(lambda: connector.current.identity.is_settled)
        one.until(lambda: state(one, TIME) is RowState.READ)
        assert (one.find(QWidget, "freefall_time_number").property("role"), state(one, TILT)) == (
            "muted",
            RowState.READ,
        )
    else:
        one.until(lambda: state(one, TILT) is RowState.CHANGED)
        assert (float(box.text()), work.count_unsent()) == (1.2, 0)
    assert one.changes() == []
