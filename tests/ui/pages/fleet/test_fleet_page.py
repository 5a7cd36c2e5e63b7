"""The fleet board over fake ports: no wrong card ever, LOCK for one and for all."""

import random
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from functools import partial

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication

from app.engine.target import Target
from app.fleet.card import Card, Need
from app.modules.service import ServiceKind, service_due, serviced
from app.preflight.findings import Person
from app.preflight.verdict import assess
from app.records.filing import Filed, local_now
from app.records.record import make_record
from app.safety.last_known import Activation
from app.safety.ritual import Input
from app.settings.profiles import NO_PROFILE
from protocol.events import EndReason
from tests.support.records.preflight_rig import check
from tests.support.thorough import some
from tests.support.window.fake_ports import SETTINGS, VALUES, stand
from tests.support.window.fakes_ui import ADAPTER, SECOND_ADAPTER, store_of
from tests.support.window.steps import given, let_lay_out
from tests.ui.pages.fleet.conftest import Desk
from ui.acts.ritual_widget import RitualWidget
from ui.core.port_watcher import PortWatcher
from ui.pages.fleet.card_widget import CardWidget
from ui.pages.fleet.members import DUE_EVERY_S, target_of
from ui.session.check import ENTRIES
from ui.session.port import Port
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice

THIRD_ADAPTER = ADAPTER._replace(device="/dev/ttyUSB7", description="CH340", serial_number="0007")


def test_with_no_module_the_page_says_what_to_do(desk: Desk) -> None:
    assert desk.page.stack.currentWidget() is desk.page.empty
    assert not desk.page.lock_all.isVisible()
    desk.plug_in(1)
    assert desk.page.stack.currentWidget() is desk.page.view
    assert desk.page.lock_all.isVisible()


def test_a_card_says_that_its_voltage_is_the_chargers(desk: Desk) -> None:
    desk.plug_in(1)
    ((connection, worker),) = desk.modules
    cell = desk.page._widgets[connection].cell
    for is_charging, note in ((False, ""), (True, "charging")):
        worker.say(cell_voltage_v=4.0, charging=is_charging)
        desk.settle()
        assert (cell.text, cell.note) == ("4.00", note)


@pytest.mark.parametrize("seed", some(range(4), one_in=2))
@pytest.mark.promise("l")
def test_no_card_ever_shows_anything_of_another_module_or_of_before(desk: Desk, seed: int) -> None:
    """Values, losses, returns, LOCKs and choices in any order: every card is its own module's, and of now."""
    source = random.Random(seed)
    desk.plug_in(6)

    def fresh(card: Card, key: str) -> object:
        return card.conversation.fresh(key, desk.ports.now_s)

    said: dict[Port, dict[str, object]] = {one: dict(VALUES) for one, _ in desk.modules}
    plugged = {one for one, _ in desk.modules}
    was_active: set[Port] = set()
    for _ in range(150):
        number = source.randrange(len(desk.modules))
        connection, worker = desk.modules[number]
        match source.choice(("say", "say", "unplug", "return", "choose", "lock", "age")):
            case "say" if connection in plugged:
                tilt, active = number * 10 + source.randrange(10), source.random() < 0.5
                worker.say(tilt_deg=tilt, active=active, cell_voltage_v=3.9)
                said[connection] |= {"tilt_deg": tilt, "active": active, "cell_voltage_v": 3.9}
                (was_active.add if active else was_active.discard)(connection)
            case "unplug" if connection in plugged:
                worker.unplug()
                plugged.discard(connection)
            case "return" if connection not in plugged:
                connection.connect_to(given(connection.target))
                worker.say(**{key: value for key, value in said[connection].items() if key != "x"})  # type: ignore[arg-type]
                plugged.add(connection)
            case "choose":
                desk.ports.ports.choose(connection)
            case "lock":
                desk.page._widgets[connection].lock.click()
            case "age":
                desk.ports.now_s += source.choice((0.3, 2.0))
            case _:
                continue
        desk.settle()
        for place, (one, _) in enumerate(desk.modules):
            card = given(desk.page._widgets[one].card)
            assert card.port == f"port{place}"
            if one not in plugged:
                assert fresh(card, "tilt_deg") is fresh(card, "cell_voltage_v") is None
                assert card.need in (Need.LINK, Need.WAS_ACTIVE, Need.NOT_LOCKED)
                assert (one in was_active) <= card.activation.may_fire
            else:
                assert fresh(card, "tilt_deg") in (None, said[one]["tilt_deg"])
                if card.activation.state is Activation.LOCKED:
                    assert said[one]["active"] is False
        shown = [card for card in (desk.page._widgets[one].card for one, _ in desk.modules) if card and card.is_shown]
        assert [card.port for card in shown] == [desk.ports.ports.current.key.removeprefix("/dev/")]


def filed(desk: Desk) -> Filed:
    """A check that ended now, of which everything that a fake module reports still holds."""
    case = check().assessment.case
    values = case.evidence.values | {key: value for key, value in VALUES.items() if key in case.evidence.values}
    evidence = replace(case.evidence, flags={}, ended_at=desk.ports.now_s, values=values | SETTINGS)
    assessment = assess(replace(case, evidence=evidence))
    return Filed(assessment, make_record(assessment, at=local_now()), None)


@pytest.mark.promise("l")
def test_a_bay_that_was_open_while_the_page_was_hidden_voids_the_check(desk: Desk) -> None:
    desk.plug_in(2)
    connection, worker = desk.modules[1]
    desk.page.hide()
    stand(connection.module.begin_check(NO_PROFILE, Person(), is_enabling=False), filed(desk))
    for light_v in (9.0, 0.3):
        worker.say(light_v=light_v)
        QApplication.processEvents()
    desk.page.show()
    card = given(desk.page._widgets[connection].card)
    assert card.next_step(desk.ports.now_s) == "Check again: Changed: Light."


@pytest.mark.promise("l")
def test_a_check_that_is_void_on_its_page_is_void_here(desk: Desk) -> None:
    desk.plug_in(1)
    connection, _ = desk.modules[0]
    checked = connection.module.begin_check(NO_PROFILE, Person(), is_enabling=False)
    needs = []
    for happens in (lambda: stand(checked, filed(desk)), lambda: checked.set_void(ENTRIES)):
        happens()
        desk.settle()
        card = given(desk.page._widgets[connection].card)
        needs.append(card.need)
    assert needs == [Need.NO_GO, Need.VOID]


def test_what_is_void_of_a_set_is_neither_said_nor_exported_any_more(desk: Desk) -> None:
    desk.plug_in(3)
    desk.click(desk.page.check)
    for connection, _ in desk.modules:
        stand(given(connection.module.check), filed(desk))
    desk.settle()
    (_, worker), (second, _), (third, _) = desk.modules
    assert given(desk.page.notice_bar.notice).text == "3 NO-GO"
    third.module.begin_check(NO_PROFILE, Person(), is_enabling=False)
    desk.settle()
    assert given(desk.page.notice_bar.notice).text == "2 NO-GO, 1 not checked"
    worker.end(EndReason.SILENT)
    worker.begin()  # perhaps another module
    second.treat_as_another()
    desk.settle()
    assert desk.page.notice_bar.notice is None
    shown = [(member.verdict, member.why) for member in desk.page.checks.results.values()]
    assert [verdict for verdict, _ in shown] == [None] * 3
    assert all(why for _, why in shown), shown


@pytest.mark.promise("l")
def test_lock_all_reaches_every_module_also_when_one_port_hangs(desk: Desk) -> None:
    desk.plug_in(5, active=True)
    desk.click(desk.page.lock_all)
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1] * 5
    for _, worker in desk.modules[1:]:  # the first one hangs: its job never ends
        worker.say(active=False)
    desk.settle()
    notice = given(desk.page.notice_bar.notice)
    assert notice.text.startswith("4 report LOCKED · LOCK goes on: port0, ")
    card = given(desk.page._widgets[desk.modules[0][0]].card)
    assert card.need is Need.NOT_LOCKED
    assert card.activation.may_fire


def test_lock_on_a_card_is_for_that_module_alone_and_chooses_nothing(desk: Desk) -> None:
    desk.plug_in(3, active=True)
    third, worker = desk.modules[2]
    desk.click(desk.page._widgets[third].lock)
    assert [len(one.wanted(is_urgent=True)) for _, one in desk.modules] == [0, 0, 1]
    assert desk.ports.ports.current is desk.modules[0][0]
    assert worker.opened == ["/dev/port2"]


def test_a_click_on_a_card_shows_that_module_and_what_was_edited_stays_with_the_former(desk: Desk) -> None:
    desk.plug_in(3)
    (first, _), (second, _), (third, _) = desk.modules
    first.module.settings.choose("freefall_time_s", 1.2)
    desk.qtbot.mouseClick(desk.page._widgets[second].title, Qt.MouseButton.LeftButton)
    assert desk.ports.ports.current is second
    desk.page._widgets[third].setFocus()
    desk.qtbot.keyClick(desk.page._widgets[third], Qt.Key.Key_Return)
    assert desk.ports.ports.current is third
    assert (first.module.count_unsent(), third.module.count_unsent()) == (1, 0)


def test_who_needs_a_person_is_first_and_nothing_moves_under_the_keyboard(desk: Desk) -> None:
    desk.plug_in(4)
    last = desk.page._widgets[desk.modules[3][0]]
    first = desk.page.board.cards[0]
    first.setFocus()
    desk.modules[3][1].say(triggered=True)
    desk.settle()
    assert desk.page.board.cards[0] is first
    assert last.trigger.word == "TRIGGERED"
    _sorts_five_seconds_after_it_has_left(desk, first, last, desk.page.lock_all.setFocus)


def _sorts_five_seconds_after_it_has_left(
    desk: Desk, first: CardWidget, last: CardWidget, leave: Callable[[], object]
) -> None:
    leave()
    for passed_s, is_sorted in ((0.0, False), (4.9, False), (0.2, True)):
        desk.ports.now_s += passed_s
        desk.settle()
        assert desk.page.board.cards[0] is (last if is_sorted else first)


@pytest.mark.promise("l")
def test_no_lock_moves_under_a_hand(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where a module comes, goes or needs a person first."""
    desk.plug_in(3)
    board, pointed_at = desk.page.board, [True]
    monkeypatch.setattr(board, "underMouse", lambda: pointed_at[0])
    first, middle, last = board.cards
    places = {card: card.geometry() for card in (first, last)}
    desk.settle()
    desk.modules[2][1].say(triggered=True)
    desk.plug_in(1)
    desk.page.members.disconnect_port(next(one for one, card in desk.page._widgets.items() if card is middle))
    desk.settle()
    assert {card: card.geometry() for card in (first, last)} == places
    assert len(board.cards) == 3
    _sorts_five_seconds_after_it_has_left(desk, first, last, lambda: pointed_at.__setitem__(0, False))


def test_the_lock_of_an_active_card_is_the_dark_one(desk: Desk) -> None:
    desk.plug_in(2)
    for connection, worker in desk.modules:
        worker.say(active=worker is desk.modules[1][1])
        desk.settle()
        role = desk.page._widgets[connection].lock.property("role") or ""
        assert role == ("primary" if worker is desk.modules[1][1] else "")


def test_any_port_that_connect_takes_can_be_added(desk: Desk) -> None:
    desk.page.add.ask_text = lambda _parent, _title, _label, then: then(" socket://10.0.0.7:4001 ")
    desk.page.add.menu().aboutToShow.emit()
    desk.page.add.menu().actions()[-1].trigger()
    desk.settle()
    (connection,) = desk.page.members.connections
    assert given(connection.target).device == "socket://10.0.0.7:4001"
    said = desk.page._widgets[connection].port.text()
    assert said.endswith(" · socket://10.0.0.7:4001")  # its end may be elided, but not the state of the link before it


def test_the_adapters_that_are_plugged_in_are_added_one_by_one_or_all(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    connector = desk.ports.ports
    monkeypatch.setattr(PortWatcher, "ports", (ADAPTER, SECOND_ADAPTER, THIRD_ADAPTER))
    monkeypatch.setattr(connector, "add", partial(connector.add, desk.ports.make))
    menu, all_ports = desk.page.add.menu(), ["ttyUSB0 CP2102 USB to UART", "ttyACM0 USB Single Serial", "ttyUSB7 CH340"]
    for place, offered in ((1, all_ports), (2, [all_ports[0], all_ports[2]])):
        menu.aboutToShow.emit()
        assert [action.text() for action in menu.actions()[: len(offered) + 1]] == [*offered, "Connect all ports"]
        menu.actions()[place].trigger()
        desk.settle()
    menu.aboutToShow.emit()
    assert menu.actions()[0].text() == "Simulated module"
    targets = [connection.target for connection in desk.page.members.connections]
    assert targets == [target_of(port) for port in (SECOND_ADAPTER, ADAPTER, THIRD_ADAPTER)]


def test_a_notice_moves_no_card(desk: Desk) -> None:
    desk.plug_in(9)
    desk.settle()
    let_lay_out(desk.page)

    def places() -> list[QPoint]:
        return [card.mapTo(desk.page, QPoint()) for card in desk.page.board.cards]

    before = places()
    desk.page.result.set_notice(Notice(Meaning.ATTENTION, "Failed. " * 12))
    desk.settle()
    let_lay_out(desk.page)
    assert desk.page.notice_bar.isVisible()
    assert places() == before


def test_the_cards_fill_the_width_whatever_changes_it(desk: Desk) -> None:
    desk.plug_in(9)
    board, wrong = desk.page.board, []
    sizes = ((1100, 500), (1100, 2400), (1100, 500), (700, 900), (700, 900), (1100, 1300), (780, 760), (1100, 500))
    for width, height in sizes:
        desk.page.resize(width, height)
        desk.settle()
        let_lay_out(desk.page)
        found = [card.geometry() for card in board.cards]
        board.place()
        if found != [card.geometry() for card in board.cards]:
            wrong.append((width, height))
    assert wrong == []


def test_the_last_card_that_is_disconnected_leaves_its_port_and_another_takes_the_place(desk: Desk) -> None:
    desk.plug_in(2)
    (first, _), (second, worker) = desk.modules
    desk.page.members.disconnect_port(first)
    desk.settle()
    assert desk.ports.ports.current is second
    assert desk.page.members.connections == (second,)
    desk.page.members.disconnect_port(second)
    worker.hand_over()
    desk.settle()
    assert desk.page.members.connections == ()
    assert desk.page.stack.currentWidget() is desk.page.empty


def test_a_target_that_is_open_gets_no_second_card(desk: Desk) -> None:
    desk.plug_in(2)
    assert desk.page.members.connect_port(Target("/dev/port1", 115200)) is desk.modules[1][0]
    assert len(desk.page.members.connections) == 2


@pytest.mark.promise("l")
def test_choosing_another_module_disarms_and_the_ritual_names_module_and_port(desk: Desk) -> None:
    desk.plug_in(2, active=True)
    second, _ = desk.modules[1]
    second.module.say_name("M-02")
    ritual = RitualWidget(desk.services)
    desk.qtbot.addWidget(ritual)
    ritual.show()
    desk.qtbot.waitExposed(ritual)
    ritual._choose(is_rehearsal=True)
    assert ritual.is_under_way
    desk.ports.ports.choose(second)
    assert not ritual.is_under_way
    assert ritual.ritual.ended_by is Input.INTERRUPTED
    ritual.refresh()
    assert "M-02" in ritual._title.text()
    assert "port1" in ritual._title.text()


def test_a_name_never_survives_an_interruption_and_its_card_asks_for_it_again(desk: Desk) -> None:
    desk.plug_in(2)
    port, worker = desk.modules[1]
    card = desk.page._widgets[port]
    port.module.say_name("M-07")
    desk.settle()
    assert card.title.text() == "M-07"
    worker.end(EndReason.SILENT)
    worker.begin(**VALUES)
    desk.settle()
    assert card.title.text() == "Unnamed"
    assert card.need.text() == "M-07 again? Read its label."
    port.module.say_name("M-07")
    desk.settle()
    assert card.title.text() == "M-07"


def test_the_card_of_a_named_module_says_what_is_due_as_the_check_does(desk: Desk) -> None:
    store, today = store_of(desk.services.storage), local_now().date()
    late = serviced(ServiceKind.REPACK, on=today - timedelta(days=200), due=today - timedelta(days=1))
    soon = serviced(ServiceKind.CELL, on=today, due=today + timedelta(days=12))
    for name, service in (("M-01", late), ("M-02", soon)):
        store.add(service, name).result()
    desk.plug_in(3)
    for (connection, _), name in zip(desk.modules, ("M-01", "M-02"), strict=False):
        connection.module.say_name(name)
    desk.settle()
    cards = [desk.page._widgets[connection] for connection, _ in desk.modules]

    def said() -> list[str]:
        return [card.need.text().removeprefix("Start the check.").strip() for card in cards]

    due = [
        store.read(partial(service_due, name=name, at=local_now()))[0].text.translated() for name in ("M-01", "M-02")
    ]
    assert ("overdue" in due[0], "days left: 12" in due[1]) == (True, True)
    desk.wait(lambda: said() == [*due, ""])
    repacked = serviced(ServiceKind.REPACK, on=today)
    store.add(repacked, "M-01").result()
    desk.ports.now_s += DUE_EVERY_S
    desk.settle()
    desk.wait(lambda: not cards[0].need.text().count("overdue"))
