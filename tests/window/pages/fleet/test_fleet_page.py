"""The Fleet page: no wrong row ever, LOCK for one and for all, several at once; the archive."""

import random
import sqlite3
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QPushButton
from pytestqt.qtbot import QtBot

from app.archive.archive import sync
from app.engine.target import Target
from app.preflight.checks import Person
from app.settings.profiles import NO_PROFILE, Profile
from app.store.rows import ActIntended, SaidNew, Serviced, ServiceKind, SettingsSeen, TriggerRecordSeen
from tests.files.records.test_filing import file_one
from tests.module.module import ACTIVATION, ATTITUDE, ATTITUDE_OFF, BY_PWM, FREEFALL_OFF, OUTPUT, Module
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import add, open_store
from tests.support.thorough import some
from tests.support.window.fakes_ui import ADAPTER, SECOND_ADAPTER, ListedPorts, page_entries, store_of
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, let_lay_out, notice_text
from ui.pages.fleet.archive_panel import ArchivePanel
from ui.pages.fleet.board import LOCK, MODULE, NEXT, STATE, TRIGGERS_CELL, VERDICT, Board
from ui.pages.fleet.members import target_of
from ui.pages.fleet.page import FleetPage
from ui.session.check import ENTRIES
from ui.session.port import Port
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning
from ui.widgets.notices import Notice


@dataclass
class Desk(Rig):
    """The Fleet page, and independent modules."""

    modules: list[tuple[Port, Module]] = field(default_factory=list)

    @cached_property
    def page(self) -> FleetPage:
        return self.find(FleetPage)

    @property
    def board(self) -> Board:
        return self.page.board

    @property
    def notice(self) -> str:
        return notice_text(self.page.notice_bar)

    def plug_in_more(self, count: int, settings: Mapping[int, int] = MappingProxyType({})) -> None:
        for number in range(len(self.modules), len(self.modules) + count):
            self.modules.append(self.plug_in(f"/dev/port{number}", settings))
        self.settle()

    def settle(self, seconds: float = 1.2) -> None:
        """What the modules say is heard and shown."""
        self.wait(seconds)
        self.page.refresh()

    def silence(self, number: int) -> None:
        """Until its conversation has ended."""
        port, module = self.modules[number]
        module.be_silent(self.clock(), 15.0)
        self.until(lambda: not port.module.is_going)
        self.settle(0.2)

    def row(self, number: int) -> int:
        """Of the module that was plugged in as this one, by the port that its row names."""
        names = [self.board.item(row, MODULE).text().split() for row in range(self.board.rowCount())]  # type: ignore[union-attr]
        return next(row for row, words in enumerate(names) if f"port{number}" in words)

    def cell(self, number: int, column: int) -> str:
        return given(self.board.item(self.row(number), column)).text()

    def lock(self, number: int) -> QPushButton:
        holder = given(self.board.cellWidget(self.row(number), LOCK))
        return given(holder.findChild(QPushButton))

    def untick(self, number: int) -> None:
        given(self.board.item(self.row(number), MODULE)).setCheckState(Qt.CheckState.Unchecked)

    def sets(self, *codes: int) -> list[int]:
        """How many settings of these codes each module was told, or of all but the stream."""
        told = [[entry.code for entry in module.log.sets()] for _port, module in self.modules]
        return [sum(code in codes or (not codes and code != OUTPUT) for code in one) for one in told]

    def press(self, key: str) -> None:
        """A button of the notice."""
        choices = given(self.page.notice_bar.notice).choices
        next(choice for choice in choices if choice.key == key).act()
        self.page.refresh()


THIRD_ADAPTER = ADAPTER._replace(device="/dev/ttyUSB7", description="CH340", serial_number="0007")


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    listed = ListedPorts(ADAPTER, SECOND_ADAPTER, THIRD_ADAPTER)
    with on_fake_time(Desk, qtbot, qapp, tmp_path, "unused", page_entries("fleet"), listed) as made:
        made.window.panel.hide()
        made.go_to("fleet")
        yield made


@pytest.mark.parametrize("seed", some(range(4), one_in=4))
@pytest.mark.promise("l")
def test_no_row_ever_shows_anything_of_another_module_or_of_before(desk: Desk, seed: int) -> None:
    """Values, losses, returns, LOCKs and choices in any order: every row is its own module's, and of now."""
    source = random.Random(seed)
    desk.plug_in_more(5)
    for number, (_, module) in enumerate(desk.modules):
        module.readings.cell = 150 + 5 * number  # 3.0 V, 3.1 V …
    desk.settle(5.0)
    was_active, plugged = [False] * 5, set(range(5))
    for _ in range(50):
        number = source.randrange(5)
        port, module = desk.modules[number]
        match source.choice(("say", "say", "unplug", "return", "choose", "lock")):
            case "say" if number in plugged:
                module.settings[ACTIVATION] = int(source.random() < 0.5)
            case "unplug" if number in plugged:
                desk.unplug(port)
                plugged.discard(number)
            case "return" if number not in plugged:
                port.connect_to(given(port.target))
                plugged.add(number)
            case "choose":
                desk.assembly.ports.choose(port)
            case "lock":
                desk.lock(number).click()
            case _:
                continue
        desk.settle()
        assert [desk.row(place) for place in range(5)] == list(range(5))
        for place, (_, module) in enumerate(desk.modules):
            state = desk.cell(place, STATE)
            voltage = desk.cell(place, TRIGGERS_CELL).split("\n")[1]
            if place in plugged:
                was_active[place] = module.settings[ACTIVATION] == 1
                assert voltage in ("unknown", f"{3 + place / 10:.2f} V")
                assert state.removeprefix("was ").startswith("ACTIVE" if was_active[place] else "LOCKED")
            else:
                assert voltage == "unknown"
                assert ("ACTIVE" in state) == was_active[place]
        shown = [place for place in range(5) if "Shown" in desk.cell(place, MODULE)]
        assert shown == [int(desk.port.key.removeprefix("/dev/port"))]


@pytest.mark.promise("l")
def test_lock_reaches_one_or_every_module_also_when_a_port_hangs(desk: Desk) -> None:
    desk.plug_in_more(3, {ACTIVATION: 1})
    desk.click(desk.lock(2))
    desk.settle()
    assert (desk.sets()[:2], desk.port) == ([0, 0], desk.modules[0][0]), "it chooses nothing"
    desk.modules[2][1].settings[ACTIVATION] = 1
    hung = desk.workers.pop(0)
    desk.click(desk.page.lock_all)
    desk.settle()
    assert [desk.cell(number, STATE).split()[0] for number in range(1, 3)] == ["LOCKED", "LOCKED"]
    assert "ACTIVE" in desk.cell(0, STATE)
    assert [desk.lock(number).property("role") or "" for number in range(3)] == ["primary", "", ""]
    assert [desk.lock(number).accessibleName() for number in range(3)] == [f"LOCK: port{n}" for n in range(3)]
    let_lay_out(desk.page)
    assert all(desk.lock(number).width() >= desk.lock(number).sizeHint().width() for number in range(3)), "it is cut"
    desk.workers.insert(0, hung)
    port, module = desk.modules[1]
    desk.unplug(port)
    module.settings[ACTIVATION] = 1
    desk.settle()
    desk.click(desk.lock(1))  # owed, until it answers
    port.connect_to(given(port.target))
    desk.settle()
    assert [module.settings[ACTIVATION] for _, module in desk.modules] == [0, 0, 0]


@pytest.mark.promise("l")
def test_no_lock_moves_under_a_hand(desk: Desk) -> None:
    """Where a module needs a person first, a text grows, a notice comes, or another module is added."""
    desk.plug_in_more(4)
    let_lay_out(desk.page)

    def places() -> list[QPoint]:
        return [desk.lock(number).mapTo(desk.page, QPoint()) for number in range(4)]

    before = places()
    desk.modules[3][1].trigger(desk.clock(), BY_PWM)
    desk.silence(1)
    desk.plug_in_more(2)
    desk.page.result.set_notice(Notice(Meaning.ATTENTION, "Failed. " * 12))
    let_lay_out(desk.page)
    assert desk.page.notice_bar.isVisible()
    assert places() == before


def test_the_next_step_has_room_at_any_width(desk: Desk) -> None:
    desk.plug_in_more(1)
    for width, is_narrow in ((1000, False), (600, True), (1000, False)):
        desk.board.resize(width, 300)
        assert [desk.board.isColumnHidden(column) for column in (VERDICT, NEXT)] == [is_narrow, False]


def test_a_row_is_shown_on_all_pages_and_what_was_edited_stays_with_the_former(desk: Desk) -> None:
    desk.plug_in_more(3)
    (first, _), (second, _), (third, _) = desk.modules
    first.module.settings.fill({"freefall_time_s": 1.2})
    desk.board.cellDoubleClicked.emit(desk.row(1), NEXT)
    assert desk.port is second
    desk.board.setFocus()
    desk.board.selectRow(desk.row(2))
    desk.qtbot.keyClick(desk.board, Qt.Key.Key_Return)
    assert desk.port is third
    assert (first.module.settings.count_unsent(), third.module.settings.count_unsent()) == (1, 0)


def test_the_adapters_that_are_plugged_in_are_added_one_by_one_or_all(desk: Desk) -> None:
    desk.until(lambda: len(desk.assembly.watcher.ports) == 3)
    for device in (ADAPTER.device, SECOND_ADAPTER.device, THIRD_ADAPTER.device, "socket://10.0.0.7:4001"):
        desk.devices[device] = (Module(now=desk.clock()),)
    menu = desk.page.add.menu()
    all_ports = ["ttyUSB0 CP2102 USB to UART", "ttyACM0 USB Single Serial", "ttyUSB7 CH340"]
    for place, offered in ((1, all_ports), (2, [all_ports[0], all_ports[2]])):
        menu.aboutToShow.emit()
        assert [action.text() for action in menu.actions()[: len(offered) + 1]] == [*offered, "Connect all ports"]
        menu.actions()[place].trigger()
        desk.settle(0.2)
    menu.aboutToShow.emit()
    assert menu.actions()[0].text() == "Simulated module"
    targets = [connection.target for connection in desk.page.members.connections]
    assert targets == [target_of(port) for port in (SECOND_ADAPTER, ADAPTER, THIRD_ADAPTER)]
    desk.page.add.ask_text = lambda _parent, _title, _label, then: then(" socket://10.0.0.7:4001 ")
    menu.aboutToShow.emit()
    menu.actions()[-1].trigger()
    assert given(desk.page.members.connections[-1].target).device == "socket://10.0.0.7:4001"
    count = len(desk.page.members.connections)
    desk.page.members.connect_port(Target("socket://10.0.0.7:4001", 115200))
    assert len(desk.page.members.connections) == count  # no second row


def test_what_is_disconnected_has_no_row_and_another_takes_the_place(desk: Desk) -> None:
    desk.plug_in_more(2)
    (first, _), (second, _) = desk.modules
    first.disconnect_port()
    desk.settle()
    assert desk.page.members.connections == (second,)
    assert desk.board.rowCount() == 1
    third, _module = desk.plug_in("/dev/port2")
    assert third is first
    desk.settle()
    assert desk.page.members.connections == (third, second)
    for port in (second, third):
        port.disconnect_port()
    desk.settle()
    assert desk.page.members.connections == ()
    assert (desk.page.empty.isVisible(), desk.page.lock_all.isEnabled()) == (True, False)


def test_a_name_is_kept_in_sight_while_its_module_is_off_and_asked_for_when_one_answers(desk: Desk) -> None:
    desk.plug_in_more(2)
    port, _module = desk.modules[1]
    port.module.say_name("M-07")
    desk.settle()
    assert desk.cell(1, MODULE) == "M-07\nport1"
    desk.silence(1)
    assert desk.cell(1, MODULE) == "M-07 (offline)\nport1"
    desk.until(lambda: port.module.is_going)
    desk.settle()
    assert desk.cell(1, MODULE) == "Unnamed\nport1"
    assert desk.cell(1, NEXT) == "M-07 again? Read its label."


# Several at once


STEEPER = Profile(name="Show", settings={"attitude_threshold_deg": 70})


def open_profile(desk: Desk, profile: Profile = STEEPER) -> None:
    desk.page.result.dismiss()
    desk.page.profile.open(profile)
    desk.page.refresh()


@pytest.mark.parametrize("is_enabling", [False, True])
@pytest.mark.promise("l")
def test_those_that_are_ticked_are_checked_and_enabled_only_where_that_was_pressed(
    desk: Desk, is_enabling: bool
) -> None:
    """The check itself enables the triggers on a locked module only."""
    desk.plug_in_more(4)
    desk.untick(3)
    if is_enabling:
        desk.page.enable.trigger()
    else:
        desk.click(desk.page.check)
    desk.settle()
    desk.unplug(desk.modules[0][0])
    desk.settle(0.2)
    assert desk.notice == "Checking… (1 of 3)"  # one that is lost stops none of the others
    desk.until(lambda: not desk.page.is_checking)
    desk.settle()
    assert desk.notice == ""
    assert [desk.cell(number, VERDICT).split()[0] in ("READY", "NO-GO") for number in range(3)] == [False, True, True]
    assert desk.sets(ATTITUDE_OFF, FREEFALL_OFF)[1:] == [2 * is_enabling, 2 * is_enabling, 0]
    assert desk.sets(ACTIVATION) == [0] * 4


def test_a_profile_is_opened_and_what_is_wrong_with_a_file_is_said(desk: Desk, tmp_path: Path) -> None:
    desk.plug_in_more(1, {ATTITUDE: 70})
    path = tmp_path / "show.toml"
    desk.page.ask_profile = lambda _parent, _folder, then: then(path)
    path.write_text('name = "Show"\nattitude_threshold_deg = "steep"\n', encoding="utf-8")
    desk.click(desk.page.open_profile)
    desk.page.refresh()
    assert "show.toml" in desk.notice
    assert desk.page.profile.profile is None
    path.write_text('name = "Show"\n[settings]\nattitude_threshold_deg = 70\n', encoding="utf-8")
    desk.click(desk.page.open_profile)
    desk.page.refresh()
    assert desk.notice.startswith("Profile: Show · ")
    assert desk.cell(0, NEXT) == "unchanged"
    assert [choice.is_enabled for choice in given(desk.page.notice_bar.notice).choices] == [True, False]
    assert desk.page.on_escape()
    desk.page.refresh()
    assert desk.notice == ""
    assert desk.cell(0, NEXT) == "Start the check."


def test_a_module_that_is_being_checked_already_is_not_checked_beside_that(desk: Desk) -> None:
    desk.plug_in_more(2)
    (first, _), (second, _) = desk.modules
    second.module.begin_check(NO_PROFILE, Person(), is_enabling=True)
    desk.page._check()
    desk.page.refresh()
    assert not desk.page.check.isEnabled()
    assert (first.module.check, first.module.is_busy, second.module.is_busy) == (None, False, True)
    desk.silence(1)
    desk.until(lambda: second.module.is_going and second.module.is_read)
    enabled = desk.sets()
    desk.settle(20.0)
    assert desk.sets() == enabled, "it enables nothing of another module"


@pytest.mark.promise("g")
def test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any(desk: Desk) -> None:
    desk.plug_in_more(3)
    open_profile(desk, Profile(name="Bench", settings={"attitude_trigger": False, "attitude_threshold_deg": 70}))
    desk.press("write")
    assert desk.notice == "Attitude trigger: No protection when it tips over."
    desk.press("not_now")
    desk.press("write")
    anyway = given(desk.page.notice_bar.notice).choices[1].act
    open_profile(desk, Profile(name="Bench", settings={"attitude_trigger": False, "freefall_trigger": False}))
    anyway()  # of the former question: what is written now was not all in it
    desk.settle()
    assert desk.sets() == [0, 0, 0]
    assert "Free-fall trigger: No protection in free fall." in desk.notice
    desk.press("write_anyway")
    assert [desk.cell(number, NEXT) for number in range(3)] == ["writing"] * 3
    desk.until(lambda: not desk.page.profile.is_running)
    assert desk.sets() == [2, 2, 2]


@pytest.mark.promise("l")
def test_a_profile_is_written_only_where_it_may_and_who_is_not_written_to_is_named(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """ "Write (4)" was followed by "2 written, 1 refused" where one was ACTIVE and one was off."""
    desk.plug_in_more(5)
    for number, (port, _module) in enumerate(desk.modules):
        port.module.say_name(f"M-0{number}")
    desk.untick(4)
    desk.modules[0][1].options.refused_sets.add(ATTITUDE)
    desk.modules[1][1].settings[ACTIVATION] = 1
    desk.silence(2)
    open_profile(desk)
    assert given(desk.page.notice_bar.notice).choices[1].text == "Write (2)"
    assert desk.cell(0, NEXT) == desk.cell(3, NEXT) == "Attitude threshold 60° → 70°"
    assert "ACTIVE" in desk.cell(1, NEXT)
    kept: list[str] = []
    monkeypatch.setattr(ShownModule, "keep", lambda module: kept.append(module.name))
    desk.press("write")
    port, _module = desk.modules[3]
    desk.unplug(port)
    desk.page.refresh()
    assert desk.cell(0, NEXT) == "writing"
    assert desk.cell(3, NEXT) == "FAILED: Attitude threshold: not sent: The port was lost."
    (report,) = (one.text.in_english() for one in port.interruptions.remainders if one.text is not None)
    assert report.startswith("Profile: Attitude threshold: not sent: The port was lost.")
    port.connect_to(given(port.target))
    desk.until(lambda: port.module.is_going and port.module.is_read)
    desk.page.refresh()
    assert desk.cell(3, NEXT) == "Attitude threshold 60° → 70°"  # another module may be there
    desk.until(lambda: not desk.page.profile.is_running)
    desk.page.refresh()
    assert desk.sets()[1:3] == [0, 0]
    assert desk.sets()[4] == 0
    assert "1 refused: M-01 (The module is ACTIVE" in desk.notice
    assert "1 offline: M-02" in desk.notice
    assert "2 FAILED: M-00" in desk.notice  # it is told until the next writing
    assert "M-04" not in desk.notice, "it is not ticked"
    assert set(kept) - {""} == {"M-00"}, "what was written is no word against its name, and of M-03 nothing is known"


@pytest.mark.promise("l")
def test_a_check_that_is_void_on_its_page_is_void_here(desk: Desk) -> None:
    """Pre-flight said READY where Fleet said "not checked" of the same module."""
    desk.plug_in_more(4)
    desk.click(desk.page.check)
    desk.settle(0.2)
    assert desk.cell(0, VERDICT) == "checking…"
    desk.until(lambda: not desk.page.is_checking)
    desk.page.refresh()
    assert desk.cell(0, VERDICT).startswith("NO-GO")
    assert desk.cell(0, NEXT).startswith("Not met: ")
    (first, _), (second, _), (third, _), _ = desk.modules
    desk.silence(1)
    desk.until(lambda: second.module.is_going)  # perhaps another module
    third.disconnect_port()
    given(first.module.check).set_void(ENTRIES)
    desk.settle()
    assert desk.cell(0, VERDICT).startswith("void")
    assert desk.cell(0, NEXT).startswith("Check again: ")
    assert desk.cell(1, VERDICT) == "not checked"
    assert desk.cell(3, VERDICT).startswith("NO-GO")
    assert second.module.check is None


def shown(desk: Desk) -> ArchivePanel:
    desk.window.go_to("archive")
    assert desk.page.archive.isVisible()
    return desk.page.archive


def test_a_file_brings_what_another_station_knows(desk: Desk, tmp_path: Path) -> None:
    stick = tmp_path / "all.dps-s"
    with closing(open_store(tmp_path / "other")) as store:
        file_one(store, "M-07", port="/dev/ttyUSB0")
        add(store, TriggerRecordSeen(place=0, raw="41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"), "M-07").result()
        sync(store, str(stick))
    add(store_of(desk.assembly.storage), SaidNew(is_new=True), "M-01").result(PATIENCE_S)
    desk.assembly.window.resize(1024, 600)
    panel = shown(desk)
    panel.ask_file = lambda *given, **_options: given[-1](stick)
    desk.until(panel.carry.isEnabled)
    let_lay_out(desk.assembly.window)
    before = [table.geometry() for table in (panel.modules, panel.life)]
    panel.carry.click()
    model = panel.modules.model()
    desk.until(lambda: "Received: " in panel.state.text())  # the list may be read before the exchange has ended
    desk.until(lambda: model.rowCount() == 2)
    rows = [[model.index(row, column).data() for column in range(model.columnCount())] for row in range(2)]
    assert [row[0] for row in rows] == ["M-01", "M-07"]
    assert "READY" in rows[1][1]
    assert "Unjudged trigger records: 1." in rows[1][3]
    let_lay_out(desk.assembly.window)
    assert [table.geometry() for table in (panel.modules, panel.life)] == before, "a table moved under the hand"
    panel.modules.selectRow(1)
    desk.until(lambda: panel.life.model().rowCount() > 2)
    with closing(sqlite3.connect(stick)) as altered, altered:
        row = "SELECT ?, kind, module, station, made_at, content FROM facts LIMIT 1"
        altered.execute(f"INSERT INTO facts {row}", ("f" * 40,))
    panel.carry.click()
    desk.until(lambda: "ffffffffffff: altered." in panel.state.text())


def test_a_long_history_does_not_hold_the_window_and_what_is_in_sight_of_it_wraps(desk: Desk) -> None:
    """Two thousand entries held it for seconds, LOCK with it, as each was measured several times."""
    intents = [
        ActIntended(act="write", port="p", frame="", detail={"attitude_threshold_deg": number % 90}, note="why " * 60)
        for number in range(2000)
    ]
    store_of(desk.assembly.storage).write(lambda facts: [facts.add(intent, "M-07") for intent in intents]).result()
    panel = shown(desk)
    longest_s, ends_at = 0.0, time.monotonic() + PATIENCE_S
    while panel.life.model().rowCount() < len(intents) and time.monotonic() < ends_at:
        began_s = time.thread_time()
        QApplication.processEvents()
        longest_s = max(longest_s, time.thread_time() - began_s)
    assert longest_s < 0.5
    least_px = panel.life.verticalHeader().defaultSectionSize()
    for place in (0, panel.life.verticalScrollBar().maximum() // 2):
        panel.life.verticalScrollBar().setValue(place)
        let_lay_out(panel)
        assert panel.life.rowHeight(panel.life.rowAt(1)) > least_px


def test_a_service_is_kept_under_the_module_for_which_it_was_begun(desk: Desk) -> None:
    store = store_of(desk.assembly.storage)
    for name in ("M-01", "M-02"):
        add(store, SaidNew(is_new=True), name).result(PATIENCE_S)
    panel = shown(desk)
    desk.until(lambda: panel.modules.model().rowCount() == 2)
    panel.modules.selectRow(1)
    panel.enter_service.click()
    assert "M-02" in panel.service.title.text()
    panel.service.who.setText("Li Wei")
    add(store, SaidNew(is_new=True), "M-00").result(PATIENCE_S)  # the table is read again meanwhile
    panel.service.save.click()
    kept = lambda: store.read(lambda facts: facts.of_module(Serviced, "M-02"))  # noqa: E731
    desk.until(lambda: len(kept()) == 1)
    assert (kept()[0].content.service, kept()[0].content.who) == (ServiceKind.REPACK, "Li Wei")
    desk.until(lambda: panel.modules.model().rowCount() == 3)
    assert [row.name for row in panel.modules.chosen()] == ["M-02"]


def test_a_password_is_refused_and_a_server_that_is_away_is_said(desk: Desk) -> None:
    told: list[str] = []
    desk.assembly.ports.notified.connect(told.append)
    panel = shown(desk)
    desk.until(panel.sync.isEnabled)
    panel.server.setText("postgresql://li:secret@127.0.0.1:1/x")
    panel.sync.click()
    assert "pgpass" in panel.state.text()
    panel.server.setText("postgresql://li@127.0.0.1:1/x")
    panel.sync.click()
    desk.until(lambda: "cannot be used" in panel.state.text())
    desk.until(lambda: any("cannot be used" in text for text in told))  # on every page
    assert "secret" not in panel.state.text() + "".join(told)
    desk.assembly.window.close_now()
    files = [path for path in desk.assembly.storage.folder.rglob("*") if path.is_file()]
    assert all(b"secret" not in path.read_bytes() for path in files)


def test_earlier_settings_are_compared_and_used_as_edits(desk: Desk) -> None:
    store = store_of(desk.assembly.storage)
    for count, angle in ((4, 60), (5, 65)):
        seen = SettingsSeen(port="P", boot_count=count, settings={"attitude_threshold_deg": angle})
        add(store, seen, "M-07").result(PATIENCE_S)
    panel = shown(desk)
    desk.until(lambda: panel.life.model().rowCount() == 2)
    assert panel.settings.text().startswith("Choose an entry")
    assert not panel.use.isEnabled(), "none is chosen"
    panel.life.selectRow(1)
    assert not panel.use.isEnabled(), "no module answers"
    used: list[object] = []
    exchange = panel._services.exchange
    exchange.used.connect(used.append)
    exchange.can_use = lambda: True
    panel.life.selectAll()
    assert panel.settings.text() == "Attitude threshold 60° → 65°"
    assert not panel.use.isEnabled()
    panel.life.selectRow(1)
    panel.use.click()
    assert used == [{"attitude_threshold_deg": 60}]
