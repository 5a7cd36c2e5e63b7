"""The Flight logs page: reading, lists, map, proposal, use of thresholds."""

import ast
import csv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.flights.flight_log import FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import RuleReading
from app.flights.summary import summarise
from app.flights.thresholds import FireMap, FlightGroup, outcome_of
from app.recordings.markers import STATE_LOST, Marker
from app.settings.fingerprint import fingerprint
from app.settings.profile_file import read_profile
from tests.support.flights.made_flights import crash, made_flight, ordinary_flight, write_csv, write_logs
from tests.support.window.controls import moved, places
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.steps import await_child, choosing, drop, given, let_lay_out, notice_text, press
from ui.main import Assembly
from ui.pages.flights import controller
from ui.pages.flights.controller import Flight
from ui.pages.flights.lists import FlightColumn
from ui.pages.flights.page import FlightsPage
from ui.pages.flights.thresholds import cells_of
from ui.pages.flights.views import marks_of

ROOM = Path(controller.__file__).parent
UNSORTED, MUST_NOT, MUST = FlightGroup


@dataclass
class Desk:
    qtbot: QtBot
    assembly: Assembly
    page: FlightsPage

    def add(self, *logs: FlightLog, group: FlightGroup = MUST_NOT) -> None:
        """Adds flights as if they had been read."""
        self.page.work.flights |= {log.name: Flight(log.name, summary=summarise(log)) for log in logs}
        self.page.work.move([one.name for one in logs], group)
        self.wait_proposal()

    def wait_proposal(self) -> None:
        self.qtbot.waitUntil(lambda: not self.page.work.is_proposing)

    def wait_read(self) -> None:
        self.qtbot.waitUntil(lambda: not self.page.work.task.is_running)
        self.wait_proposal()

    def shown(self, group: FlightGroup) -> list[str]:
        return [row.name for row in self.page.lists.of[group].table.filter.shown()]

    def caption(self, group: FlightGroup) -> str:
        return self.page.lists.of[group].caption.text()

    def notice(self) -> str:
        return notice_text(self.page.strip)


@contextmanager
def opened(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[Desk]:
    with window(qapp, folder, entries=page_entries("flights")) as assembly:
        page = await_child(qtbot, assembly.window, FlightsPage)
        assembly.window.panel.hide()
        yield Desk(qtbot, assembly, page)


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with opened(qtbot, qapp, tmp_path) as one:
        yield one


def tilted(name: str, tilt_deg: float, seconds: float = 2.0) -> FlightLog:
    """Level, tilted for a while, level; an acceleration of 1 g."""
    tilt = np.concatenate([np.zeros(100), np.full(round(seconds * 50), tilt_deg), np.zeros(100)])
    return made_flight(tilt, 1.0, name=name)


def test_logs_are_read_and_a_table_asks_for_its_columns(desk: Desk, tmp_path: Path) -> None:
    page = desk.page
    assert page.empty.isVisible()
    paths = write_logs(tmp_path / "logs")
    page.open_paths([tmp_path / "logs"])
    desk.wait_read()
    assert sorted(desk.shown(UNSORTED)) == sorted(str(path) for path in paths)
    assert desk.shown(MUST_NOT) + desk.shown(MUST) == []
    assert page.work.proposal is None
    assert [flight.head for flight in page.work.unread()] == [("w", "a", "g", "h")]
    assert "1 of 3 not read." in desk.notice()
    assert "t1.csv: No column is known to hold the time." in desk.notice()
    press(desk.qtbot, page.strip.button("columns"))
    form = page.form
    assert form.isVisible()
    assert desk.notice() == ""  # it leads to where one is
    assert "(columns: w, a, g, h)" in form.why.text()
    assert form.line.text() == "time_s=w"  # as it would be typed on the command line
    form.line.setText("speed=w")
    form.read.click()
    assert form.fault.text().startswith("“speed=w”: ROLE=COLUMN is needed")
    form.line.setText("time_s=w")
    form.read.click()
    desk.wait_read()
    press(desk.qtbot, page.strip.button("columns"))
    assert form.line.text().startswith("time_s=w tilt_deg=")  # what was said before stays
    form.line.setText("--column time_s=w tilt_deg=a 'acceleration_g=g'")
    form.read.click()
    desk.wait_read()
    assert page.work.unread() == []
    assert desk.notice() == ""


def test_a_notice_moves_nothing_and_problems_take_no_room_without_any(desk: Desk, tmp_path: Path) -> None:
    page = desk.page
    desk.add(tilted("calm", 20))
    assert page.lists.of[MUST_NOT].table.isColumnHidden(FlightColumn.PROBLEMS)
    let_lay_out(page)
    before, shapes = places(page), (page.map.geometry(), page.proposal.geometry())
    (tmp_path / "broken.ulg").write_bytes(b"ULog")
    page.open_paths([tmp_path / "broken.ulg"])
    desk.wait_read()
    let_lay_out(page)
    assert "not read" in desk.notice()
    assert moved(before, places(page)) == []
    assert (page.map.geometry(), page.proposal.geometry()) == shapes
    assert not any(one.table.isColumnHidden(FlightColumn.PROBLEMS) for one in page.lists.of.values())


def test_flights_already_read_keep_their_list(desk: Desk, tmp_path: Path) -> None:
    path = write_csv(tmp_path / "one.csv", tilted("", 20))
    desk.page.open_paths([path])
    desk.wait_read()
    desk.page.work.move([str(path)], MUST)
    desk.page.open_paths([path])
    desk.wait_read()
    assert desk.shown(MUST) == [str(path)]
    assert desk.notice() == "No new flight logs."


@pytest.mark.parametrize("is_without_port", [False, True])
def test_a_drop_opens_files_and_folders(desk: Desk, tmp_path: Path, is_without_port: bool) -> None:
    """On the page, and beside the ports, where somebody without a module begins."""
    write_logs(tmp_path / "logs")
    single = write_csv(tmp_path / "single.csv", tilted("", 20))
    panel = desk.assembly.window.panel
    panel.setVisible(is_without_port)
    target = panel.flights if is_without_port else desk.page
    assert drop(target, tmp_path / "logs", single)
    desk.wait_read()
    assert not panel.isVisible()
    assert str(single) in desk.shown(UNSORTED)
    assert len(desk.page.work.flights) == 4


def test_each_dropped_file_that_cannot_be_read_is_named_with_its_reason(desk: Desk, tmp_path: Path) -> None:
    """And nothing is proposed while one of the logs is missing."""
    single = write_csv(tmp_path / "single.csv", tilted("", 20))
    (tmp_path / "race.bbl").write_bytes(b"H Product:Blackbox flight data recorder\n")
    (tmp_path / "page.ulg").write_bytes(b"<html><body>not found</body></html>")
    assert drop(desk.page, single, tmp_path / "race.bbl", tmp_path / "page.ulg")
    desk.wait_read()
    assert "2 of 3 not read." in desk.notice()
    assert "race.bbl: This is a Betaflight or INAV blackbox log" in desk.notice()
    assert "page.ulg: This is a web page" in desk.notice()
    desk.page.work.move([str(single)], MUST_NOT)
    desk.wait_proposal()
    assert desk.page.proposal.head.text() == "No proposal: 2 of 3 not read"
    desk.page.work.remove([str(tmp_path / "race.bbl"), str(tmp_path / "page.ulg")])
    desk.wait_proposal()
    assert desk.page.proposal.head.text() == "The vendor's defaults hold: they fire in 0 of 1"


def test_without_a_port_a_click_leads_to_flight_logs(desk: Desk) -> None:
    panel = desk.assembly.window.panel
    panel.show()
    desk.qtbot.mouseClick(panel.flights, Qt.MouseButton.LeftButton)
    assert not panel.isVisible()
    assert desk.page.isVisible()


def test_flights_move_by_button_key_and_menu(desk: Desk) -> None:
    desk.add(tilted("a", 20), tilted("b", 30))
    first, second = desk.page.lists.of[MUST_NOT], desk.page.lists.of[MUST]
    assert not first.move_buttons[MUST].isEnabled()
    first.table.choose(lambda row: row.name == "a")
    desk.qtbot.mouseClick(first.move_buttons[MUST], Qt.MouseButton.LeftButton)
    assert (desk.shown(MUST_NOT), desk.shown(MUST)) == (["b"], ["a"])
    second.table.choose(lambda row: row.name == "a")
    second.table.setFocus()
    desk.qtbot.keyClick(second.table, Qt.Key.Key_N)
    assert sorted(desk.shown(MUST_NOT)) == ["a", "b"]
    first.table.choose(lambda row: row.name in {"a", "b"})
    actions = {action.objectName().partition("_menu_")[2]: action for action in first.table.actions()}
    assert not actions["open"].isEnabled()
    actions["to_must"].trigger()
    assert sorted(desk.shown(MUST)) == ["a", "b"]
    second.table.choose(lambda row: row.name == "a")
    desk.qtbot.keyClick(second.table, Qt.Key.Key_Delete)
    assert desk.shown(MUST) == ["b"]
    second.table.choose(lambda row: row.name == "b")
    desk.qtbot.keyClick(second.table, Qt.Key.Key_U)
    assert desk.shown(UNSORTED) == ["b"]
    desk.wait_proposal()


def test_flights_of_one_side_propose_nothing(desk: Desk) -> None:
    """A crash that nobody has sorted yet must not raise the thresholds: it once proposed 89°."""
    page = desk.page
    desk.add(tilted("calm", 20), tilted("crash", 88))
    assert page.proposal.head.text() == "The vendor's defaults fire in 1 of 2"
    lines = [line.text() for line in page.proposal.lines]
    assert lines[0] == "crash: did it crash? Then it must fire."
    assert not page.proposal.take.isEnabled()
    page.work.move(["crash"], MUST)
    desk.wait_proposal()
    assert page.proposal.head.text().startswith("Proposal: ")
    assert "55° to 80°" in page.proposal.lines[2].text()
    page.work.move(["calm"], UNSORTED)
    desk.wait_proposal()
    assert page.proposal.head.text() == "The vendor's defaults fire in all 1"
    assert not page.proposal.take.isEnabled()


def test_map_and_lists_follow_a_threshold(desk: Desk) -> None:
    desk.add(tilted("calm", 20), tilted("turn", 50))
    page = desk.page
    assert desk.caption(MUST_NOT) == "Must not fire: 0 of 2 fire"
    page.thresholds.tilt.box.selectAll()
    desk.qtbot.keyClicks(page.thresholds.tilt.box, "45")
    assert page.work.limits.attitude_threshold_deg == 45
    desk.qtbot.keyClicks(page.thresholds.tilt.box, "0")  # 450°
    assert (page.thresholds.tilt.box.text(), page.work.limits.attitude_threshold_deg) == ("450", 45)
    assert not page.proposal.use.isEnabled()
    desk.qtbot.keyClick(page.thresholds.tilt.box, Qt.Key.Key_Backspace)
    assert desk.caption(MUST_NOT) == "Must not fire: 1 of 2 fire"
    let_lay_out(page)
    assert page.map.mapTo(page, page.map.rect().bottomLeft()).y() < page.proposal.mapTo(page, QPoint()).y()  # in sight
    assert "1 of 2" in page.map.accessibleName()
    assert "45°" in page.map.accessibleName()
    assert desk.shown(MUST_NOT) == ["turn", "calm"]  # what is not as expected comes first
    page.thresholds.tilt.slider.setValue(60)
    assert page.map.numbers.toPlainText().startswith("60° · ")
    assert [line.value() for line in page.map.cross[2:]] == [60, page.work.limits.freefall_time_s]
    rows = page.map.image.image[:, -1]  # lowest tilt first: 50° fires up to a threshold of 50°, not above it
    assert (rows[0] == rows[len(rows) // 5]).all()
    assert (rows[0] != rows[len(rows) // 2]).any()


def test_a_place_is_dotted_where_the_readings_differ_in_either_group() -> None:
    fired = np.array([[1, 0], [1, 1]])
    shown = FireMap(2, 2, fired, fired)
    for other in (replace(shown, must_not_fired=fired.T), replace(shown, must_fired=fired.T)):
        assert cells_of(shown, other).differs.tolist() == [[False, True], [True, False]]
    assert not cells_of(shown, shown).differs.any()


def test_the_map_is_dragged_and_has_keys(desk: Desk) -> None:
    desk.add(tilted("turn", 50))
    page = desk.page
    place = page.map.view.mapViewToScene(QPointF(1.0, 40)).toPoint()
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=place)
    limits = page.work.limits
    assert abs(limits.attitude_threshold_deg - 40) <= 1
    assert abs(limits.freefall_time_s - 1.0) <= 0.05
    assert page.thresholds.time.value == pytest.approx(limits.freefall_time_s)
    page.work.choose(TriggerLimits())
    for key in (Qt.Key.Key_Up, Qt.Key.Key_PageDown, Qt.Key.Key_Right):
        desk.qtbot.keyClick(page.map, key)
    assert (page.work.limits.attitude_threshold_deg, page.work.limits.freefall_time_s) == (51, 1.65)
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=QPoint(-500, 5000))
    page.map.chosen.emit(*page.map.thresholds_at(QPointF(-500, 5000)))
    assert (page.work.limits.attitude_threshold_deg, page.work.limits.freefall_time_s) == (30, 0.2)


def test_the_proposal_separates_and_is_tried(desk: Desk) -> None:
    random = np.random.default_rng(1)
    desk.add(*(ordinary_flight(f"survey {number}", random, seconds=30) for number in range(3)))
    desk.add(*(crash(f"crash {number}", random, seconds=20) for number in range(2)), group=MUST)
    page = desk.page
    proposal = given(page.work.proposal)
    assert proposal.limits is not None
    assert page.proposal.head.text().startswith("Proposal: ")
    assert [line.text().partition(":")[0] for line in page.proposal.lines[:2]] == ["Must not fire", "Must fire"]
    page.work.choose(TriggerLimits(attitude_threshold_deg=30))
    page.proposal.take.click()
    assert page.work.limits == proposal.limits
    assert desk.caption(MUST_NOT) == "Must not fire: 0 of 3 fire"
    assert desk.caption(MUST) == "Must fire: 2 of 2 fire in time"
    assert not page.proposal.take.isEnabled()


def test_it_says_when_nothing_separates(desk: Desk) -> None:
    desk.add(tilted("rolls", 120))
    desk.add(tilted("crash", 40), group=MUST)
    assert desk.page.proposal.head.text() == "No thresholds separate the lists"
    assert "rolls: " in desk.page.proposal.lines[0].text()
    assert not desk.page.proposal.take.isEnabled()


def test_flights_that_depend_on_the_reading_are_shown(desk: Desk) -> None:
    """70° for 0.1 s: the readings of the rule differ."""
    desk.add(tilted("bump", 70, seconds=0.1))
    page = desk.page
    table = page.lists.of[MUST_NOT]
    assert table.table.filter.index(0, 1).data() == "unclear"
    assert table.detail.text() == "unclear: 1"
    assert desk.caption(MUST_NOT) == "Must not fire: 1 of 1 fire"
    page.thresholds.reading.setCurrentIndex(1)
    page.thresholds.reading.activated.emit(1)
    assert page.work.reading is RuleReading.DAMPED
    shown, other = page.work.maps()
    assert (shown.must_not_fired != other.must_not_fired).any()
    desk.add(tilted("steep", 80))
    assert [(maps.must_not_count, maps.must_count) for maps in page.work.maps()] == [(2, 0), (2, 0)]
    page.work.move(["steep"], MUST)
    assert [(maps.must_not_count, maps.must_count) for maps in page.work.maps()] == [(1, 1), (1, 1)]


def test_a_flight_shows_its_moment(desk: Desk, tmp_path: Path) -> None:
    path = write_csv(tmp_path / "crash.csv", crash("", np.random.default_rng(2), seconds=30))
    desk.page.open_paths([path])
    desk.wait_read()
    page = desk.page
    page.work.move([str(path)], MUST)
    page.lists.of[MUST].table.selectRow(0)
    desk.qtbot.keyClick(page.lists.of[MUST].table, Qt.Key.Key_Return)
    desk.qtbot.waitUntil(lambda: page.flight.chart.plot is not None)
    plot = given(page.flight.chart.plot)
    assert (outcome := page.work.outcome_of(page.work.flights[str(path)])) is not None
    assert "after the loss of control" in page.flight.verdict.text()
    assert "m lower" in page.flight.verdict.text()
    assert plot.time_range.cursor_s == pytest.approx(outcome.direct.at_s, abs=0.05)
    assert plot.time_range.span.start_s < outcome.direct.at_s < plot.time_range.span.end_s
    asked: list[tuple[str, Path, str]] = []
    for name, signal in (("v.csv", plot.save_values_wanted), ("p.svg", plot.save_picture_wanted)):
        page.flight.chart.saved.ask_path = choosing(tmp_path / name, asked)
        signal.emit()
        desk.qtbot.waitUntil(page.flight.chart.saved.isVisible)
        desk.qtbot.waitUntil(lambda: not page.flight.chart.saved.job.is_writing)
        page.flight.chart.saved.hide()
    assert path not in [place for _, place, _ in asked]  # the log itself
    rows = list(csv.DictReader((tmp_path / "v.csv").read_text("utf-8-sig").splitlines()))
    times = [float(row["time_s"]) for row in rows]
    assert plot.time_range.span.start_s <= times[0] < plot.time_range.span.start_s + 0.1
    assert plot.time_range.span.end_s - 0.1 < times[-1] <= plot.time_range.span.end_s + 1e-6
    assert max(float(row["tilt_deg"]) for row in rows if row["tilt_deg"]) > 60
    assert (tmp_path / "p.svg").read_text("utf-8").startswith("<?xml")
    assert page.on_escape()
    assert page.flight.chart.plot is None
    assert page.map.isVisible()


@pytest.mark.promise("i")
def test_thresholds_go_to_settings_as_edits(desk: Desk) -> None:
    exchange, page = desk.page._services.exchange, desk.page
    desk.add(tilted("turn", 50))
    page.proposal.refresh()
    assert not page.proposal.use.isEnabled()  # there is no module to write to
    exchange.can_use = lambda: True
    page.proposal.refresh()
    used: list[object] = []
    wanted: list[str] = []
    exchange.used.connect(used.append)
    page.page_wanted.connect(wanted.append)
    page.work.choose(TriggerLimits(62, 0.4, 1.25))
    page.proposal.use.click()
    assert used == [
        {"attitude_threshold_deg": 62, "freefall_acceleration_g": 0.4, "freefall_time_s": 1.25},
    ]
    assert wanted == ["settings"]


def test_thresholds_go_into_profiles(desk: Desk, tmp_path: Path) -> None:
    bar = desk.page.proposal
    path = tmp_path / "new.toml"
    bar.ask_save = choosing(path)
    desk.page.work.choose(TriggerLimits(62, 0.4, 1.25))
    bar.save_profile()
    assert read_profile(path).settings == {
        "attitude_threshold_deg": 62, "freefall_acceleration_g": 0.4, "freefall_time_s": 1.25,
    }  # fmt: skip
    assert desk.notice() == f"Saved to {path}."
    code = fingerprint({"attitude_threshold_deg": 70}).code
    path.write_text(
        f'format = 1\nname = "H6"\nairframe = "H6"\napproved_fingerprint = "{code}"\n'
        "[settings]\nattitude_threshold_deg = 70\nlight_threshold_v = 1.8\n[limits]\ncell_voltage_min_v = 3.9\n",
        encoding="utf-8",
    )
    before = read_profile(path)
    bar.ask_open = choosing(path)
    bar.add_to_profile()
    after = read_profile(path)
    assert after.settings == {**before.settings, **desk.page.work.settings()}
    assert after.settings["light_threshold_v"] == 1.8
    assert (after.name, after.airframe, after.limits) == (before.name, before.airframe, before.limits)
    assert after.approved_fingerprint is None
    assert "approved settings code was removed" in desk.notice()


@pytest.mark.promise("i")
def test_nothing_on_the_page_can_reach_a_module() -> None:
    """It has access to neither the connector nor the engine."""
    for path in ROOM.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        assert not names & {"connector", "lock"}, path.name
        modules = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        assert not any(
            module.startswith(("app.engine", "app.procedures", "app.safety", "ui.acts")) for module in modules
        )


def test_what_ends_a_fall_is_marked_as_what_it_is() -> None:
    """Not everything after which a module knows nothing of before is a restart."""
    outcome = outcome_of(summarise(made_flight(0.0, 1.0)), MUST, TriggerLimits())
    resets = [Marker(float(number), kind) for number, kind in enumerate(STATE_LOST)]
    expected = [(reset.time_s, reset.kind.value) for reset in resets]
    marks = [(mark.time_s, mark.word) for mark in marks_of(outcome, resets)]
    assert [mark for mark in marks if mark in expected] == expected
