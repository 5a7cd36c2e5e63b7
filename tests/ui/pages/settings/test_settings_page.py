"""The Settings page through real clicks and keys, the frames are counted, and what is called verified is what the
module holds."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import pytest
from PySide6.QtCore import QPoint, QPointF, QSize, Qt
from PySide6.QtGui import QFontMetricsF, QWheelEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QToolButton, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import How, Known
from app.settings.form import FormRow, RowState
from app.settings.values import value_text
from app.text.i18n import CHINESE, ENGLISH, tr
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT
from tests.support.pseudo_language import PSEUDO
from tests.support.records.stored import kept_settings
from tests.support.window import walk
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import page_entries, store_of, window
from tests.support.window.settings_bench import Desk, choose, desk, notice, reason, state, type_into, write
from tests.support.window.steps import find, given, let_lay_out
from tests.support.window.walk import SMALL_SCREEN
from ui.core.preferences import Preferences
from ui.forms.field_editors import NumberEditor
from ui.main import WindowOptions
from ui.pages.settings.page import SettingsPage
from ui.shell.main_window import FIRST_SIZE
from ui.style.theme import Choice, Meaning, Size, font
from ui.widgets.step_button import is_in_sight

TILT, TIME, LIGHT, FLAG = "attitude_threshold_deg", "freefall_time_s", "light_threshold_v", "attitude_trigger"


def test_edit_write_and_verify(one: Desk) -> None:
    code = one.settings.code.text()
    type_into(one, "freefall_time", "1.2")
    type_into(one, "freefall_acceleration", "0.4")
    one.click(one.find(QToolButton, "freefall_trigger_on"))
    one.settings.refresh()
    assert one.settings.write.text() == "Write 3 changes"
    assert not one.changes()
    write(one)
    one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    assert state(one, "freefall_acceleration_g") is RowState.VERIFIED
    assert state(one, "freefall_trigger") is RowState.ACKNOWLEDGED  # it cannot be read back: never "verified"
    assert (one.held("freefall_time"), one.held("freefall_acceleration")) == (1.2, 0.4)
    assert len(one.changes()) == 3
    assert notice(one) == "Read back as written: 2. Acknowledged, cannot be read: 1."
    assert one.settings.code.text() != code
    assert not one.settings.write.isEnabled()


def test_a_row_stays_failed_with_the_reason_until_it_is_written(one: Desk) -> None:
    one.bench.change(refuses=True)
    type_into(one, "attitude_threshold", "70")
    write(one)
    one.until(lambda: state(one, TILT) is RowState.FAILED)
    assert "refused" in reason(one, TILT)
    assert one.settings.rows[TILT].state.meaning is Meaning.DANGER
    assert "Not as written" in notice(one)
    one.bench.change(refuses=False)
    write(one)
    one.until(lambda: state(one, TILT) is RowState.VERIFIED)
    assert one.held("attitude_threshold") == 70


def test_a_row_says_what_its_value_means_and_its_tooltip_what_it_is_for(one: Desk) -> None:
    tilt, light = one.settings.rows[TILT], one.settings.rows[LIGHT]
    one.settings.refresh()
    assert tilt.command.explanation in tilt.toolTip()
    assert "Default 60° · Vendor advises: " in tilt.toolTip()
    assert "Vendor advises: " in light.toolTip()
    fall = one.settings.rows[TIME]
    assert "12.6\u00a0m" in fall.reason.text()
    type_into(one, "freefall_time", "0.8")
    one.settings.refresh()
    assert "3.14\u00a0m" in fall.reason.text()


def test_each_value_is_whole_at_twice_the_size_of_text(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = 200
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        for width in (1024, 1366):
            one.assembly.window.resize(width, 768)
            one.wait(0.3)
            for row in one.settings.rows.values():
                if isinstance(row.editor, NumberEditor):
                    line = row.editor.line
                    assert line.fontMetrics().horizontalAdvance(line.text()) + 8 <= line.width(), line.text()
                    assert row.editor.rect().contains(line.geometry()), row.command.name


def test_against_the_advice_needs_a_second_click(qtbot: QtBot, one: Desk) -> None:
    type_into(one, "attitude_threshold", "40")
    write(one)
    assert "55° or more" in notice(one)
    write(one)  # the same button again is no second click
    one.qtbot.mouseDClick(one.settings.write, Qt.MouseButton.LeftButton)
    assert not one.settings.work.job.is_running
    qtbot.keyClick(one.settings, Qt.Key.Key_Escape)
    assert notice(one) == ""
    write(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, TILT) is RowState.VERIFIED)
    assert len(one.changes()) == 1


def test_a_trigger_that_is_off_is_warned_of_also_once_it_is_written(one: Desk) -> None:
    one.click(one.find(QToolButton, "attitude_trigger_off"))
    one.settings.refresh()
    warning = one.settings.rows["attitude_trigger"].reason.text()
    assert warning
    write(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, "attitude_trigger") is RowState.ACKNOWLEDGED)
    row = one.settings.rows["attitude_trigger"]
    assert (row.reason.text(), row.reason.property("role")) == (warning, "attention")
    one.assembly.window.top_bar.refresh()
    assert one.assembly.window.top_bar.triggers.word == "tilt off"


@pytest.mark.promise("d")
def test_an_active_module_is_written_only_when_unlocked_for_this_once(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", active=True) as one:
        type_into(one, "freefall_time", "1.2")
        write(one)
        one.until(lambda: notice(one).startswith("Nothing was written. The module is ACTIVE"))
        assert not one.changes()
        choose(one, "unlock_once")
        one.until(lambda: state(one, TIME) is RowState.VERIFIED)
        type_into(one, "freefall_time", "1.3")
        write(one)  # once is not for ever
        one.until(lambda: notice(one).startswith("Nothing was written. The module is ACTIVE"))
        assert len(one.changes()) == 1


@pytest.mark.promise("h")
def test_what_is_refused_anyway_is_disabled_and_says_why(one: Desk) -> None:
    page = one.settings
    type_into(one, "freefall_time", "1.2")
    one.bench.power_off()
    one.until(lambda: "does not answer" in notice(one) and not page.work.job.is_running)
    assert not one.assembly.ports.module.is_going
    assert "does not answer" in page.baud.conditions.text()
    assert (page.work.can_write, page.write.isEnabled()) == (False, False)


def test_edits_are_discarded_one_or_all_and_defaults_are_edits(one: Desk) -> None:
    box, line = one.find(QLineEdit, "attitude_threshold_wanted"), one.find(QLineEdit, "freefall_time_wanted")
    number = one.find(QWidget, "freefall_time_wanted")
    type_into(one, "attitude_threshold", "75")
    type_into(one, "freefall_time", "1.1")
    one.settings.refresh()
    one.click("attitude_threshold_discard")
    assert (box.text(), line.text()) == ("60", "1.1")
    type_into(one, "attitude_threshold", "75")
    one.click("settings_revert")
    assert (box.text(), line.text(), number.property("role")) == ("60", "1.60", "muted")
    one.choose_rare("settings_defaults")
    assert (box.text(), line.text()) == ("60", "1.60")
    one.settings.refresh()
    assert one.settings.write.text() == "Write 2 changes"  # the two flags: nobody knows how they stand
    assert not one.changes()
    write(one)
    one.until(lambda: state(one, "attitude_trigger") is RowState.ACKNOWLEDGED)
    one.settings.refresh()  # nothing is left enabled that would do nothing
    page = one.settings
    able = [button.objectName() for button in (page.write, page.revert, *(row.discard for row in page.rows.values()))
            if button.isEnabled() and button.isVisible()]  # fmt: skip
    able += [action.objectName() for action in (page.defaults, page.as_found) if action.isEnabled()]
    assert (able, box.text(), number.property("role")) == ([], "60", "muted")


def test_initial_values_can_be_restored(one: Desk) -> None:
    assert not one.settings.as_found.isEnabled()
    for text in ("1.2", "1.3"):
        type_into(one, "freefall_time", text)
        write(one)
        one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    one.choose_rare("settings_as_found")
    write(one)
    one.until(lambda: one.held("freefall_time") == 1.6 and state(one, TIME) is RowState.VERIFIED)
    store = store_of(one.assembly.storage)
    assert [settings[TIME] for settings in kept_settings(store)] == [1.6]


def test_the_wheel_edits_no_number(qapp: QApplication, one: Desk) -> None:
    box = one.find(QLineEdit, "attitude_threshold_wanted")
    one.until(lambda: box.text() == "60")
    box.setFocus()
    here = QPointF(box.rect().center())
    qapp.sendEvent(
        box,
        QWheelEvent(here, QPointF(box.mapToGlobal(here)), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
                    Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False),
    )  # fmt: skip
    assert box.text() == "60"
    assert box.accessibleDescription() == "0° to 255°"


@pytest.mark.parametrize(
    ("name", "typed", "says"),
    [
        ("attitude_threshold", "650", "0° to 255°"), ("attitude_threshold", "300", "0° to 255°"),
        ("freefall_time", "16", "0.00 s to 2.55 s"), ("light_threshold", "0.55", "steps of 0.1 V"),
        ("attitude_threshold", "sixty", "0° to 255°"),
    ],
)  # fmt: skip
def test_what_cannot_be_sent_stays_as_typed_and_nothing_is_written(
    qtbot: QtBot, one: Desk, name: str, typed: str, says: str
) -> None:
    page, box = one.settings, one.find(QLineEdit, f"{name}_wanted")
    key = BY_NAME[name].key
    type_into(one, "freefall_acceleration", "0.4")  # that could be written by itself
    type_into(one, name, typed)
    one.wait(1.0)  # the page refreshes itself
    assert box.text() == typed
    assert box.property("role") == "wrong"
    assert state(one, key) is RowState.IMPOSSIBLE
    assert says in reason(one, key)
    assert tr(BY_NAME[name].title) in notice(one)
    assert not page.write.isEnabled()
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    page.work.write()
    one.wait(0.5)
    assert one.changes() == []
    assert one.assembly.window._services.pending_edits.count() == 2  # leaving the program asks
    one.click(f"{name}_discard")
    assert state(one, key) is RowState.READ
    assert box.property("role") == "muted"
    write(one)
    one.until(lambda: state(one, "freefall_acceleration_g") is RowState.VERIFIED)


def test_an_emptied_field_waits_for_another_number(qtbot: QtBot, one: Desk) -> None:
    box = one.find(QLineEdit, "attitude_threshold_wanted")
    one.until(lambda: box.text() == "60")
    box.setFocus()
    box.selectAll()
    qtbot.keyClick(box, Qt.Key.Key_Delete)
    one.wait(1.0)
    assert box.text() == ""
    assert not one.settings.write.isEnabled()
    qtbot.keyClicks(box, "75")
    assert one.settings.work.form.edited == {TILT: 75}


def test_the_shown_value_pasted_over_itself_is_an_edit(one: Desk, qapp: QApplication) -> None:
    """So is a stale value written again though nobody types another one first."""
    box = one.find(QLineEdit, "freefall_time_wanted")
    one.until(lambda: box.text() == "1.60")
    for pasted in ("1.60", "1.6", "1,60 s"):
        one.settings.work.form.revert()
        one.settings.refresh()
        assert TIME not in one.settings.work.form.edited
        qapp.clipboard().setText(pasted)
        box.selectAll()
        box.paste()
        assert one.settings.work.form.edited[TIME] == 1.6


@pytest.mark.parametrize(("behaviour", "says"), [("old", "are at 9600 baud"), ("restart", "Switch it off and on")])
def test_the_baud_rate_needs_two_clicks_and_the_port_follows(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, behaviour: str, says: str
) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", query=f"?baud_ack={behaviour}") as one:
        panel = one.settings.baud
        one.settings.scroll_area.ensureWidgetVisible(panel)
        assert not panel.confirm.ask.isEnabled()
        panel.editor.box.setCurrentIndex(panel.editor.box.findData(9600))
        panel.refresh()
        one.ask(panel.confirm)
        one.until(panel.confirm.cancel.hasFocus)
        qtbot.keyClick(panel.confirm.cancel, Qt.Key.Key_Escape)
        assert not panel.confirm.is_asking
        one.ask(panel.confirm)
        one.click(panel.confirm.go)
        one.until(lambda: panel.notice_bar.notice is not None and says in panel.notice_bar.notice.text)
        assert len(one.changes("baud_rate")) == 1
        assert one.assembly.ports.current.connection.baud_rate == one.bench.module.baud_rate
        one.bench.unplug()
        one.until(lambda: (panel.notice_bar.notice is None) is (behaviour == "old"))


@pytest.mark.parametrize("is_inverted", [False, True])
def test_the_light_threshold_by_measurement(is_inverted: bool, one: Desk) -> None:
    one.bench.change(light_inverted=is_inverted)
    one.click("light_threshold_measure")
    panel = one.settings.calibration
    one.click("calibration_closed_measure")
    one.until(panel.sides["open"].button.isEnabled)
    one.bench.set_world(bay_is_open=True)
    one.click("calibration_open_measure")
    one.until(panel.take.isEnabled)
    assert ("reads lower" in panel.detail.text()) is is_inverted
    one.click("calibration_take")
    row = given(one.settings.rows[LIGHT].row)
    assert row.edited is not None
    write(one)
    one.until(lambda: state(one, LIGHT) in (RowState.VERIFIED, RowState.READ))
    assert one.held("light_threshold") == row.edited


def test_acknowledged_is_not_cut_off(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Another page may switch the stream at any moment: the walk through the window meets this state by chance."""
    with window(qapp, tmp_path, options=WindowOptions(language=PSEUDO), entries=page_entries("settings")) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(SMALL_SCREEN)
        assembly.window.panel.hide()
        assembly.window.go_to("settings")
        page = find(assembly.window, SettingsPage)
        known = Known(value=True, how=How.ACKNOWLEDGED, at=assembly.ports.clock())
        row = FormRow(command=SERIAL_OUTPUT, module_value=known, edited=None, state=RowState.ACKNOWLEDGED)
        page.rows["serial_output"].show_row(row, known.at, is_editable=True)
        assert page.rows["serial_output"].state.word
        assert not cut_off(page)


def test_in_sunlight_values_and_chosen_flags_are_whole(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, options=WindowOptions(language=ENGLISH), entries=page_entries("settings")) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.appearance.choose(Choice.SUNLIGHT)
        assembly.window.panel.hide()
        assembly.window.go_to("settings")
        page = find(assembly.window, SettingsPage)
        shown, advised, rows = page.rows["attitude_trigger"], page.rows[TILT], page.rows.values()
        row = FormRow(command=shown.command, module_value=None, edited=False, state=RowState.EDITED)
        bold, small = QFontMetricsF(font(Size.BODY, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        for size, least in (((960, 540), 4), ((1024, 600), 5), ((1366, 768), 7)):
            assembly.window.resize(*size)
            shown.show_row(row, 0.0, is_editable=True)
            let_lay_out(page)
            assert not [fault for fault in cut_off(page) if shown.command.name in fault], size
            assert sum(is_in_sight(row) for row in rows) >= least, size
            edited = replace(row, command=advised.command, edited=30)
            with patch.object(page.work.form, "rows", partial(_only, edited)):
                page.refresh()
                let_lay_out(page)
                assert not [fault for fault in cut_off(page) if advised.command.name in fault], size
            heights = [row.height() for row in rows if not row.reason.isVisible()]
            assert max(heights) - min(heights) <= 1, size  # fields are as high as buttons
            assert bold.horizontalAdvance(value_text(BAUD_RATE, 115200)) <= page.baud.value_label.width()
            assert small.horizontalAdvance(shown.value_label.note) <= shown.value_label.width()


def _only(row: FormRow, *_known: object) -> tuple[FormRow, ...]:
    return (row,)


@pytest.mark.parametrize("spoken", [ENGLISH, CHINESE], indirect=True)
def test_a_reason_is_whole_at_the_first_and_at_the_smallest_size(spoken: str, one: Desk) -> None:
    for name, text in (("attitude_threshold", "5"), ("freefall_acceleration", "1.1"), ("light_threshold", "0")):
        type_into(one, name, text)
    one.click(one.find(QToolButton, "freefall_trigger_off"))
    for size in (FIRST_SIZE, QSize(1024, 600)):
        one.assembly.window.resize(size)
        one.settings.refresh()
        let_lay_out(one.settings)
        reasons = [row.reason for row in one.settings.rows.values() if row.reason.isVisible()]
        assert len(reasons) >= 4
        assert all(label.height() >= label.heightForWidth(label.width()) for label in reasons)
        assert all("…" not in label.text() for label in reasons)


@pytest.mark.parametrize(("width", "height", "least"), [(1366, 768, 8), (1024, 600, 6)])
def test_the_table_is_dense_and_its_rows_never_move(width: int, height: int, least: int, one: Desk) -> None:
    """All eight settings in sight at 1366×768, six at 1024×600; a state moves nothing in its row or above it, and at
    1366×768 nothing at all."""
    one.assembly.window.resize(width, height)
    page = one.settings
    rows = [*page.rows.values(), page.baud]

    def places() -> list[QPoint]:
        page.refresh()
        let_lay_out(page)
        editors = [row.editor for row in page.rows.values()][: None if width > 1024 else 4]
        return [editor.mapTo(page, QPoint()) for editor in editors]

    one.until(lambda: sum(is_in_sight(row) for row in rows) >= least)
    before = places()
    for button in (page.write, page.revert, page.read):
        assert is_in_sight(button), button.objectName()
    assert page.scroll_area.horizontalScrollBar().maximum() == 0
    type_into(one, "freefall_time", "9999")
    assert places() == before
    type_into(one, "freefall_time", "0.1")
    one.click(one.find(QToolButton, "freefall_trigger_off"))
    assert places() == before
    write(one)
    one.until(lambda: page.strip.notice is not None)
    assert places() == before


@pytest.mark.parametrize("spoken", [ENGLISH, CHINESE], indirect=True)
def test_on_the_smallest_screen_all_is_in_sight_and_nothing_scrolls_sideways(
    spoken: str, tmp_path: Path, one: Desk
) -> None:
    """Otherwise the next page begins too wide, with Cancel of the deploy panel out of sight."""
    main, page = one.assembly.window, one.settings
    main.resize(1024, 600)
    page.refresh()
    let_lay_out(page)
    for widget in (page.baud, page.files.open, page.files.recent, page.files.save, page.code, page.write):
        assert is_in_sight(widget), widget.objectName()
    for width in (1024, 940):
        main.resize(width, 600)
        let_lay_out(main)
        assert main.area.horizontalScrollBar().maximum() == 0, width
    profile = tmp_path / "H6.toml"
    main.resize(1366, 768)
    profile.write_text(walk.PROFILE, encoding="utf-8")
    one.settings.open_file(profile)
    main.resize(1024, 600)
    let_lay_out(main)
    assert main.area.horizontalScrollBar().maximum() == 0
