"""The panel "Would it have fired?" on Live, through real clicks and keys: live, recorded, and with Settings."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QCheckBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QScrollArea,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.engine.device import StatusSample
from app.engine.target import Target
from app.firing.what_if import MAX_FIRINGS
from app.firing.what_if_drafts import ATTITUDE_TRIGGER, FREEFALL_TRIGGER
from app.settings.form import RowState
from app.text.i18n import CHINESE, ENGLISH, set_language
from protocol.catalogue import Hazard
from protocol.frame import decode_request
from tests.support.records.recordings_made import HEADING, batch, device, opened, recorder_in, written_at_once
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import connect, page_entries, simulated, wait_online, window
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.steps import find, let_lay_out
from ui.pages.live import what_if_panel
from ui.pages.live.page import LivePage
from ui.pages.settings.page import SettingsPage
from ui.style.theme import Choice

FREEFALL_TIME = "fired_freefall_time_wanted"
ATTITUDE = "fired_attitude_threshold_wanted"


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setattr(what_if_panel, "PACE", 0)
    with live_bench(qtbot, qapp) as bench:
        yield bench


def tell(bench: Bench, *tilts: int, weights: tuple[float, ...] = (), active: bool = True) -> None:
    """Reports of the last seconds, 50 a second."""
    weights = weights or (1.0,) * len(tilts)
    rows = zip(tilts, weights, strict=True)
    start_s = bench.now_s - len(tilts) / 50
    samples = [StatusSample(start_s + n / 50, tilt, weight, False, active) for n, (tilt, weight) in enumerate(rows)]
    bench.say(*samples, active=active, freefall_time_s=1.6)


def toggle(bench: Bench) -> None:
    bench.click("live_would_fire")


def retype(bench: Bench, name: str, text: str) -> None:
    box = bench.find(QLineEdit, name)
    box.setFocus()
    box.selectAll()
    bench.qtbot.keyClicks(box, text)
    bench.page.refresh()


def judged(bench: Bench) -> None:
    """Until what is shown answers the question."""
    bench.page.refresh()
    bench.qtbot.waitUntil(lambda: not bench.page.fired._judging.is_running)
    bench.page.refresh()


def head(bench: Bench) -> str:
    judged(bench)
    return str(bench.find(QLabel, "fired_head").text())


def details(bench: Bench) -> str:
    judged(bench)
    return str(bench.find(QLabel, "fired_details").text())


def rows(bench: Bench) -> list[str]:
    judged(bench)
    listed = bench.find(QListWidget, "fired_list")
    return [listed.item(n).text()[11:] for n in range(listed.count())]  # without the time of the day


# What it says


def test_the_modules_values_are_tried_first(live: Bench) -> None:
    tell(live, 0, 20, 57, 20, 0)
    assert not live.page.fired.isVisible()
    toggle(live)
    assert live.page.fired.isVisible()
    assert head(live) == "Would not have fired (0.1 s judged)."
    assert "nearest 57°, 3° below" in details(live)
    assert "3° below" in details(live)
    assert "Free fall: none; lowest 1.0 g" in details(live)
    assert rows(live) == ["near miss: 57°, 3° below"]
    assert live.find(QLineEdit, ATTITUDE).text() == "60"


def test_the_list_fits_its_rows_at_another_size_of_text(live: Bench) -> None:
    tell(live, 0, 20, 57, 20, 0)
    toggle(live)
    judged(live)
    listed = live.find(QListWidget, "fired_list")
    listed.setStyleSheet("font-size: 40px")
    live.page.refresh()
    assert listed.height() >= listed.sizeHintForRow(0) > 40


def test_another_threshold_is_judged_as_it_is_typed(live: Bench) -> None:
    tell(live, 0, 20, 57, 20, 0)
    toggle(live)
    retype(live, ATTITUDE, "55")
    assert head(live) == "Would have fired 1×."
    assert rows(live) == ["would fire: attitude, 57°"]
    live.click("fired_as_module")
    assert head(live).startswith("Would not have fired")
    assert not live.find(QPushButton, "fired_as_module").isEnabled()


def test_new_reports_are_judged(live: Bench) -> None:
    tell(live, 0, 0, 0)
    toggle(live)
    live.pass_time(0.1)
    tell(live, 0, 70, 70)
    live.until(lambda: head(live) == "Would have fired 1×.")
    live.pass_time(0.1)
    tell(live, 0, 70, 0)
    live.until(lambda: head(live) == "Would have fired 2×.")


def test_a_fall_that_was_too_short(live: Bench) -> None:
    tell(live, *[0] * 70, weights=(*[1.0] * 5, *[0.1] * 51, *[1.0] * 14))
    toggle(live)
    retype(live, FREEFALL_TIME, "1.20")
    assert rows(live) == ["near miss: 1.00 s, 0.20 s below"]
    retype(live, FREEFALL_TIME, "1.02")
    assert rows(live) == ["too close to tell: 1.00 s, 0.02 s below"]
    assert head(live).startswith("Too close to tell")
    retype(live, FREEFALL_TIME, "1.00")
    assert rows(live) == ["would fire: free fall, 0.1 g"]


def test_unknown_thresholds_are_not_judged(live: Bench) -> None:
    live.say(StatusSample(live.now_s, 80, 1.0, False, True), leave_out="attitude_threshold_deg")
    live.say(StatusSample(live.now_s + 0.1, 80, 1.0, False, True), leave_out="attitude_threshold_deg")
    toggle(live)
    assert head(live) == "Enter the thresholds."
    assert "Attitude threshold: enter a value" in details(live)
    assert "Attitude trigger: not judged" in details(live)
    retype(live, ATTITUDE, "60")
    assert head(live) == "Would have fired 1×."
    assert "Attitude trigger: assumed enabled" in details(live)


def test_a_trigger_that_is_switched_off(live: Bench) -> None:
    tell(live, 0, 70, 0)
    toggle(live)
    live.click("fired_attitude_trigger_off")
    assert head(live).startswith("Would not have fired")
    assert "Attitude trigger: disabled" in details(live)
    live.click("fired_freefall_trigger_off")
    assert head(live) == "Both triggers are disabled."
    live.click("fired_attitude_trigger_off")  # pressed again it is wanted no more
    assert head(live) == "Would have fired 1×."


def test_while_it_was_locked(live: Bench) -> None:
    tell(live, 0, 0, 70, 0, 0, 0, active=False)
    toggle(live)
    assert head(live) == "Would have fired 1×."
    assert "judged as active" in details(live)
    box = live.find(QCheckBox, "fired_locked")
    live.qtbot.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))
    live.page.refresh()
    assert not box.isChecked()
    assert head(live) == "Nothing to judge."
    assert "Not judged: locked for 0.1 s." in details(live)


def test_only_the_first_results_are_listed(live: Bench) -> None:
    tell(live, *[0, 70] * (MAX_FIRINGS + 1))
    toggle(live)
    assert head(live) == f"Would have fired {MAX_FIRINGS + 1}×."
    assert f"First {MAX_FIRINGS} only." in details(live)
    assert len(rows(live)) == MAX_FIRINGS


def test_pauses_are_named(live: Bench) -> None:
    tell(live, *[0] * 10)
    live.pass_time(8.0)
    tell(live, *[0] * 10)
    toggle(live)
    assert "Not judged: pauses, 8 s in all, longest 8 s at " in details(live)
    live.pass_time(4.0)
    tell(live, *[0] * 10)
    assert "Not judged: pauses, 12 s in all, longest 8 s at " in details(live)


# The plots


def test_a_click_on_a_row_shows_it_in_the_plots(live: Bench) -> None:
    tell(live, 0, 0, 70, 0)
    at_s = live.now_s - 2 / 50
    live.pass_time(30.0)
    tell(live, 0, 0, 0, 0)
    toggle(live)
    judged(live)
    listed = live.find(QListWidget, "fired_list")
    live.find(QScrollArea, "fired_scroll").ensureWidgetVisible(listed)
    place = listed.visualItemRect(listed.item(0)).center()
    live.qtbot.mouseClick(listed.viewport(), Qt.MouseButton.LeftButton, pos=place)
    plot = live.page.plot
    assert not plot.time_range.is_live
    assert plot.time_range.cursor_s == pytest.approx(at_s, abs=0.02)


def test_drafts_are_lines_in_the_plots(live: Bench) -> None:
    tell(live, 0, 0, 0)
    toggle(live)
    lines = live.page.fired.lines
    assert lines.attitude.value is None
    retype(live, ATTITUDE, "75")
    assert lines.attitude.value == 75
    (line,) = (line for line in live.page.plot.canvas.lanes[0].limits if line.limit.is_draft)
    assert line.getData()[0].tolist() == [-60, 0]  # all over
    assert line.getData()[1].tolist() == [75, 75]
    retype(live, ATTITUDE, "60")  # what the module has
    assert lines.attitude.value is None
    retype(live, ATTITUDE, "75")
    live.qtbot.keyClick(live.find(QLineEdit, ATTITUDE), Qt.Key.Key_Escape)
    assert not live.page.fired.isVisible()
    assert lines.attitude.value is None
    toggle(live)
    retype(live, ATTITUDE, "75")
    live.connector.current.treat_as_new()
    live.page.refresh()
    assert lines.attitude.value is None


# The place on the page


def test_the_numbers_and_the_plots_stay_in_sight_beside_it(live: Bench) -> None:
    live.page.resize(876, 500)
    tell(live, 0, 0, 0)
    toggle(live)
    plots = live.find(QWidget, "live_plots")
    assert live.page.panel.isVisible()
    assert plots.isVisible()
    assert live.page.rect().contains(plots.mapTo(live.page, plots.rect().bottomRight()))


def test_by_keyboard(live: Bench) -> None:
    live.page.window().activateWindow()
    tell(live, 0, 57, 0)
    live.qtbot.keyClick(live.page, Qt.Key.Key_T, Qt.KeyboardModifier.ControlModifier)
    live.qtbot.waitUntil(live.page.fired.isVisible)
    box = live.find(QLineEdit, ATTITUDE)
    live.qtbot.waitUntil(box.hasFocus)
    for _ in range(5):
        live.qtbot.keyClick(box, Qt.Key.Key_Down)
    live.page.refresh()
    assert box.text() == "55"
    assert head(live) == "Would have fired 1×."
    listed = live.find(QListWidget, "fired_list")
    listed.setFocus()
    live.qtbot.keyClick(listed, Qt.Key.Key_Home)
    live.qtbot.keyClick(listed, Qt.Key.Key_Return)
    assert not live.page.plot.time_range.is_live


def test_how_it_is_judged_is_said_in_the_language_in_use(live: Bench) -> None:
    tell(live, 0, 0, 0)
    toggle(live)
    rules = live.find(QLabel, "fired_rules")
    assert not rules.isVisible()
    live.page.fired.about.click()
    assert rules.isVisibleTo(live.page)
    english = rules.text()
    assert "activated while tilted, it fires at once" in english
    set_language(CHINESE)
    QApplication.sendEvent(live.page, QEvent(QEvent.Type.LanguageChange))
    assert rules.text() != english
    set_language(ENGLISH)
    QApplication.sendEvent(live.page, QEvent(QEvent.Type.LanguageChange))
    assert rules.text() == english


# A recording


def test_a_recording_is_judged_with_its_own_thresholds(live: Bench, tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.recorder.begin(*HEADING)
        had = device(1000.0, attitude_threshold_deg=50, freefall_acceleration_g=0.4)
        tilts = [0] * 50 + [55] * 10 + [0] * 50
        samples = [StatusSample(1000.0 + n / 50, tilt, 1.0, False, True) for n, tilt in enumerate(tilts)]
        bench.feed(batch(samples[-1].at, *samples, view=had))
        bench.finish()
        folder = bench.path
    tell(live, 0, 0, 0)
    toggle(live)
    live.page.show_recording(opened(folder))
    assert "Free-fall time: enter a value" in details(live)
    assert head(live) == "Would have fired 1×."
    assert rows(live) == ["would fire: attitude, 55°"]
    assert live.find(QLineEdit, ATTITUDE).text() == "50"
    live.page.back_to_live()
    assert head(live).startswith("Would not have fired")
    assert live.find(QLineEdit, ATTITUDE).text() == "60"


def test_a_recording_is_closed_while_it_is_judged(live: Bench, tmp_path: Path) -> None:
    folder = written_at_once(tmp_path, 1_000_000)
    tell(live, 0, 0, 0)
    toggle(live)
    retype(live, FREEFALL_TIME, "0.50")
    for _ in range(3):
        live.page.show_recording(opened(folder))
        live.page.refresh()
    live.page.back_to_live()
    assert head(live).startswith("Would not have fired")


# With Settings


def test_drafts_move_between_settings_and_live_without_sending(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    name = f"fired{tmp_path.name}"
    with simulated(name) as bench, window(qapp, tmp_path, entries=page_entries("live", "settings")) as assembly:
        changes: list[bytes] = []
        write = bench.wire.write

        def watched(data: bytes, now_s: float) -> None:
            frames = (data[at : at + 6] for at in range(0, len(data), 6))
            changes.extend(one for one in frames if decode_request(one).hazard is not Hazard.NONE and one[2] != 0x13)
            write(data, now_s)

        bench.wire.write = watched  # type: ignore[method-assign]
        window_ = assembly.window
        with qtbot.waitSignal(window_.pages_made):
            pass
        connect(qtbot, assembly, f"sim://{name}")
        connector = assembly.connector
        qtbot.waitUntil(lambda: connector.current.device.known("freefall_time_s", connector.clock()) is not None)
        live, settings = find(assembly.window, LivePage), find(assembly.window, SettingsPage)
        assert isinstance(live, LivePage)
        assert isinstance(settings, SettingsPage)
        window_.go_to("settings")
        settings.work.edit(lambda: settings.work.form.choose("attitude_threshold_deg", 70))
        settings.try_out.trigger()
        qtbot.waitUntil(live.fired.isVisible)
        box = find(live, QLineEdit, ATTITUDE)
        assert box.text() == "70"
        qtbot.keyClick(box, Qt.Key.Key_Up)
        live.fired.use.click()
        qtbot.waitUntil(settings.isVisible)
        states = {row.command.key: row for row in settings.work.form.rows(connector.current.device, connector.clock())}
        row = states["attitude_threshold_deg"]
        assert (row.state, row.edited) == (RowState.EDITED, 71)
        assert not changes
        settings.work.discard()
        connector.current.disconnect_port()


def test_in_sunlight_a_switch_stands_beside_its_name(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("sunny"), window(qapp, tmp_path, entries=page_entries("live")) as assembly:
        assembly.appearance.choose(Choice.SUNLIGHT)
        assembly.window.resize(960, 540)
        assembly.window.connect_to(Target("sim://sunny", 115200))
        wait_online(qtbot, assembly)
        live = assembly.window.findChildren(LivePage)[0]
        qtbot.waitUntil(lambda: not live.is_empty)
        live.fired.button.click()
        fields = live.fired.fields
        for command in (ATTITUDE_TRIGGER, FREEFALL_TRIGGER):
            editor = fields.editors[command.key]
            editor.findChildren(QAbstractButton)[0].click()  # the check mark needs room too
            let_lay_out(fields)
            label = fields.findChildren(QLabel, f"fired_{command.name}_label")[0]
            assert label.geometry().right() < editor.x()
            assert editor.y() <= label.geometry().center().y() <= editor.geometry().bottom()
        assert not cut_off(fields)
