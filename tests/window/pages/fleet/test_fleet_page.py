"""The table of connected modules over fake ports: no wrong row ever, LOCK for one and for all."""

import random
from functools import partial

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication

from app.engine.target import Target
from app.preflight.checks import Person
from app.settings.profiles import NO_PROFILE
from protocol.events import EndReason
from tests.support.thorough import some
from tests.support.window.fake_ports import VALUES, stand
from tests.support.window.fakes_ui import ADAPTER, SECOND_ADAPTER
from tests.support.window.steps import given, let_lay_out
from tests.window.pages.fleet.conftest import Desk
from ui.core.port_watcher import PortWatcher
from ui.pages.fleet.archive_panel import target_of
from ui.pages.fleet.board import MODULE, NEXT, STATE, TRIGGERS_CELL, VERDICT
from ui.session.check import ENTRIES
from ui.style.theme import Meaning, current
from ui.widgets.notice_bar import Notice

THIRD_ADAPTER = ADAPTER._replace(device="/dev/ttyUSB7", description="CH340", serial_number="0007")


def test_with_no_module_the_page_says_what_to_do(desk: Desk) -> None:
    assert desk.page.empty.isVisible()
    assert not desk.page.lock_all.isEnabled()
    desk.plug_in(1)
    assert desk.board.isVisible()
    assert desk.page.lock_all.isEnabled()


def test_a_row_tells_what_its_module_reports(desk: Desk) -> None:
    desk.plug_in(2)
    desk.modules[0][1].say(charging=True, attitude_trigger=True, freefall_trigger=False)
    desk.modules[1][1].say(active=True, triggered=True)
    desk.settle()
    assert [desk.cell(0, column) for column in (MODULE, STATE, TRIGGERS_CELL, VERDICT)] == [
        "Unnamed\nport0\nShown",
        "LOCKED\nNOT TRIGGERED",
        "fall off\n4.00 V\ncharging",
        "not checked",
    ]
    assert [desk.cell(1, column) for column in (MODULE, STATE, TRIGGERS_CELL)] == [
        "Unnamed\nport1",
        "ACTIVE\nTRIGGERED",
        "not known\n4.00 V",
    ]
    assert desk.cell(1, NEXT).startswith("TRIGGERED")
    colours = []
    for triggered in (True, False):
        desk.modules[1][1].say(active=True, triggered=triggered)
        desk.settle()
        colours.append(given(desk.board.item(desk.row(1), STATE)).foreground().color())
    assert colours == [current().ink(Meaning.DANGER), current().ink(Meaning.ATTENTION)]


@pytest.mark.parametrize("seed", some(range(4), one_in=2))
@pytest.mark.promise("l")
def test_no_row_ever_shows_anything_of_another_module_or_of_before(desk: Desk, seed: int) -> None:
    """Values, losses, returns, LOCKs and choices in any order: every row is its own module's, and of now."""
    source = random.Random(seed)
    desk.plug_in(5)
    active = dict.fromkeys(range(5), False)
    plugged = set(range(5))
    for _ in range(120):
        number = source.randrange(5)
        connection, worker = desk.modules[number]
        match source.choice(("say", "say", "unplug", "return", "choose", "lock", "age")):
            case "say" if number in plugged:
                active[number] = source.random() < 0.5
                worker.say(**VALUES | {"active": active[number], "cell_voltage_v": 3 + number / 10})
            case "unplug" if number in plugged:
                worker.unplug()
                plugged.discard(number)
            case "return" if number not in plugged:
                connection.connect_to(given(connection.target))
                worker.say(**VALUES | {"active": active[number], "cell_voltage_v": 3 + number / 10})
                plugged.add(number)
            case "choose":
                desk.ports.ports.choose(connection)
            case "lock":
                desk.lock(number).click()
            case "age":
                desk.ports.now_s += source.choice((0.3, 2.0))
            case _:
                continue
        desk.settle()
        assert [desk.row(place) for place in range(5)] == list(range(5))
        for place in range(5):
            state = desk.cell(place, STATE)
            voltage = desk.cell(place, TRIGGERS_CELL).split("\n")[1]
            if place in plugged:
                assert voltage in ("unknown", "4.00 V", f"{3 + place / 10:.2f} V")
                assert state.startswith("LOCKED") <= (not active[place])
            else:
                assert voltage == "unknown"
                assert ("ACTIVE" in state) == active[place]
        shown = [place for place in range(5) if "Shown" in desk.cell(place, MODULE)]
        assert shown == [int(desk.ports.ports.current.key.removeprefix("/dev/port"))]


@pytest.mark.promise("l")
def test_a_check_that_is_void_on_its_page_is_void_here(desk: Desk) -> None:
    """Pre-flight said READY where Fleet said "not checked" of the same module."""
    desk.plug_in(2)
    connection, _ = desk.modules[0]
    check = connection.module.begin_check(NO_PROFILE, Person(), is_enabling=False)
    desk.settle()
    assert desk.cell(0, VERDICT) == "Checking…"
    stand(check, desk.filed())
    desk.settle()
    assert desk.cell(0, VERDICT).startswith("NO-GO")
    assert desk.cell(0, NEXT).startswith("Not met: ")
    check.set_void(ENTRIES)
    desk.settle()
    assert desk.cell(0, VERDICT).startswith("void")
    assert desk.cell(0, NEXT).startswith("Check again: ")
    assert desk.cell(1, VERDICT) == "not checked"


@pytest.mark.promise("l")
def test_lock_all_reaches_every_module_also_when_one_port_hangs(desk: Desk) -> None:
    desk.plug_in(5, active=True)
    desk.click(desk.page.lock_all)
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1] * 5
    for _, worker in desk.modules[1:]:  # the first one hangs: its job never ends
        worker.say(active=False)
    desk.settle()
    assert [desk.cell(number, STATE).partition("\n")[0] for number in range(5)] == ["ACTIVE", *["LOCKED"] * 4]
    desk.modules[1][1].unplug()
    desk.settle()
    assert desk.lock(1).isEnabled()
    desk.click(desk.lock(1))  # owed, until it answers
    assert len(desk.modules[1][1].wanted(is_urgent=True)) == 2
    desk.click(desk.page.lock_all)
    assert len(desk.modules[1][1].wanted(is_urgent=True)) == 3


def test_the_lock_of_a_row_is_for_that_module_alone_and_chooses_nothing(desk: Desk) -> None:
    desk.plug_in(3, active=True)
    desk.click(desk.lock(2))
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [0, 0, 1]
    assert desk.ports.ports.current is desk.modules[0][0]
    desk.modules[2][1].say(active=False)
    desk.settle()
    assert [desk.lock(number).property("role") or "" for number in range(3)] == ["primary", "primary", ""]
    assert [desk.lock(number).accessibleName() for number in range(3)] == [f"LOCK: port{n}" for n in range(3)]
    let_lay_out(desk.page)
    assert all(desk.lock(number).width() >= desk.lock(number).sizeHint().width() for number in range(3)), "it is cut"


@pytest.mark.promise("l")
def test_no_lock_moves_under_a_hand(desk: Desk) -> None:
    """Where a module needs a person first, a text grows, a notice comes, or another module is added."""
    desk.plug_in(4)
    let_lay_out(desk.page)

    def places() -> list[QPoint]:
        return [desk.lock(number).mapTo(desk.page, QPoint()) for number in range(4)]

    before = places()
    desk.modules[3][1].say(triggered=True)
    desk.modules[1][1].end(EndReason.SILENT)
    desk.page.result.set_notice(Notice(Meaning.ATTENTION, "Failed. " * 12))
    desk.plug_in(2)
    let_lay_out(desk.page)
    assert desk.page.notice_bar.isVisible()
    assert places() == before


def test_a_row_is_shown_on_all_pages_and_what_was_edited_stays_with_the_former(desk: Desk) -> None:
    desk.plug_in(3)
    (first, _), (second, _), (third, _) = desk.modules
    first.module.settings.choose("freefall_time_s", 1.2)
    desk.board.cellDoubleClicked.emit(desk.row(1), NEXT)
    assert desk.ports.ports.current is second
    desk.board.setFocus()
    desk.board.selectRow(desk.row(2))
    desk.qtbot.keyClick(desk.board, Qt.Key.Key_Return)
    assert desk.ports.ports.current is third
    assert (first.module.settings.count_unsent(), third.module.settings.count_unsent()) == (1, 0)


def test_any_port_that_connect_takes_can_be_added(desk: Desk) -> None:
    desk.page.add.ask_text = lambda _parent, _title, _label, then: then(" socket://10.0.0.7:4001 ")
    desk.page.add.menu().aboutToShow.emit()
    desk.page.add.menu().actions()[-1].trigger()
    desk.settle()
    (connection,) = desk.page.members.connections
    assert given(connection.target).device == "socket://10.0.0.7:4001"
    assert given(desk.board.item(0, MODULE)).text().replace("\u200b", "") == "Unnamed\nsocket://10.0.0.7:4001\nShown"
    assert desk.page.members.connect_port(Target("socket://10.0.0.7:4001", 115200)) is connection  # no second row


def test_the_adapters_that_are_plugged_in_are_added_one_by_one_or_all(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    connector = desk.ports.ports
    monkeypatch.setattr(PortWatcher, "ports", (ADAPTER, SECOND_ADAPTER, THIRD_ADAPTER))
    monkeypatch.setattr(connector, "add", partial(connector.add, desk.ports.make))
    menu = desk.page.add.menu()
    all_ports = ["ttyUSB0 CP2102 USB to UART", "ttyACM0 USB Single Serial", "ttyUSB7 CH340"]
    for place, offered in ((1, all_ports), (2, [all_ports[0], all_ports[2]])):
        menu.aboutToShow.emit()
        assert [action.text() for action in menu.actions()[: len(offered) + 1]] == [*offered, "Connect all ports"]
        menu.actions()[place].trigger()
        desk.settle()
    menu.aboutToShow.emit()
    assert menu.actions()[0].text() == "Simulated module"
    targets = [connection.target for connection in desk.page.members.connections]
    assert targets == [target_of(port) for port in (SECOND_ADAPTER, ADAPTER, THIRD_ADAPTER)]


def test_what_is_disconnected_has_no_row_and_another_takes_the_place(desk: Desk) -> None:
    desk.plug_in(2)
    second, worker = desk.modules[1]
    desk.board.selectRow(desk.row(0))
    desk.page.disconnect_marked.trigger()
    desk.settle()
    assert desk.ports.ports.current is second
    assert desk.page.members.connections == (second,)
    assert desk.board.rowCount() == 1
    desk.page.members.disconnect_port(second)
    worker.hand_over()
    desk.settle()
    assert desk.page.members.connections == ()
    assert desk.page.empty.isVisible()


def test_a_name_is_kept_in_sight_while_its_module_is_off_and_asked_for_when_one_answers(desk: Desk) -> None:
    desk.plug_in(2)
    port, worker = desk.modules[1]
    port.module.say_name("M-07")
    desk.settle()
    assert desk.cell(1, MODULE) == "M-07\nport1"
    worker.end(EndReason.SILENT)
    desk.settle()
    assert desk.cell(1, MODULE) == "M-07 (offline)\nport1"
    worker.begin(**VALUES)
    desk.settle()
    assert desk.cell(1, MODULE) == "Unnamed\nport1"
    assert desk.cell(1, NEXT) == "M-07 again? Read its label."
    worker.end(EndReason.SILENT)
    desk.settle()
    assert desk.cell(1, MODULE) == "Unnamed\nport1", "nobody said that it is M-07"
    worker.begin(**VALUES)
    desk.settle()
    port.module.say_name("M-07")
    QApplication.processEvents()
    desk.settle()
    assert desk.cell(1, MODULE) == "M-07\nport1"
