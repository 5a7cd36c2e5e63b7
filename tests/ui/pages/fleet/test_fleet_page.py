"""The fleet board over fake ports: no wrong card ever, LOCK for one and for all."""

import json
import random
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QWidget

from app.engine.identity import Identity, Trust
from app.engine.procedure import Cancelled
from app.engine.target import Target
from app.fleet.card import Need
from app.fleet.check_set import SetMember
from app.fleet.profile_table import Applied
from app.preflight.evidence import Disturbance
from app.preflight.verdict import Void, assess
from app.records.check_store import CheckStore
from app.records.filing import Filed
from app.safety.last_known import Activation
from app.safety.ritual import Input
from app.settings.profiles import Profile
from app.store.store import Store
from app.text.messages import UserMessage
from tests.support.records.preflight_rig import check
from tests.support.window.fake_ports import VALUES
from tests.support.window.fakes_ui import speak_chinese
from tests.ui.pages.fleet.conftest import Desk
from ui.acts.ritual_widget import RitualWidget
from ui.core.port_connection import PortConnection
from ui.core.texts import Texts
from ui.files.file_dialogs import ThenPath
from ui.shell.attention import Attention
from ui.style.theme import Choice, Meaning
from ui.widgets.notice_bar import Notice, NoticeBar


def test_with_no_module_the_page_says_what_to_do(desk: Desk) -> None:
    assert desk.page.stack.currentWidget() is desk.page.empty
    assert not desk.page.lock_all.isVisible()
    desk.plug_in(1)
    assert desk.page.stack.currentWidget() is desk.page.view
    assert desk.page.lock_all.isVisible()


@pytest.mark.parametrize("seed", range(4))
def test_no_card_ever_shows_anything_of_another_module_or_of_before(desk: Desk, seed: int) -> None:
    """Values, losses, returns, LOCKs and choices in any order: every card is its own module's, and of now."""
    source = random.Random(seed)
    desk.plug_in(6)
    said: dict[PortConnection, dict[str, object]] = {one: dict(VALUES) for one, _ in desk.modules}
    plugged = {one for one, _ in desk.modules}
    was_active: set[PortConnection] = set()
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
                assert connection.target is not None
                connection.connect_to(connection.target)
                worker.say(**{key: value for key, value in said[connection].items() if key != "x"})  # type: ignore[arg-type]
                plugged.add(connection)
            case "choose":
                desk.ports.connector.choose(connection)
            case "lock":
                desk.page._widgets[connection].lock.click()
            case "age":
                desk.ports.now_s += source.choice((0.3, 2.0))
            case _:
                continue
        desk.settle()
        for place, (one, _) in enumerate(desk.modules):
            card = desk.page._widgets[one].card
            assert card is not None
            assert card.port == f"port{place}"
            if one not in plugged:
                assert (card.tilt_deg, card.cell_v) == (None, None)
                assert card.need in (Need.LINK, Need.WAS_ACTIVE, Need.NOT_LOCKED)
                assert (one in was_active) <= card.activation.may_fire
            else:
                assert card.tilt_deg in (None, said[one]["tilt_deg"])
                if card.activation.state is Activation.LOCKED:
                    assert said[one]["active"] is False
        shown = [card for card in (desk.page._widgets[one].card for one, _ in desk.modules) if card and card.is_shown]
        assert [card.port for card in shown] == [desk.ports.connector.adapter_key.removeprefix("/dev/")]


def filed(desk: Desk) -> Filed:
    """A check that ended now, of which everything that a fake module reports still holds."""
    case = check().assessment.case
    return Filed(assess(replace(case, evidence=replace(case.evidence, flags={}, ended_at=desk.ports.now_s))), {})


@pytest.mark.parametrize("is_of_page", [True, False])
def test_a_bay_that_was_open_while_the_page_was_hidden_voids_the_check(desk: Desk, is_of_page: bool) -> None:
    desk.plug_in(2)
    connection, worker = desk.modules[1]
    desk.page.hide()
    if is_of_page:
        connection.kept.check = (filed(desk), None)
    else:
        desk.page.members.verdicts.store(connection, filed(desk))
    for light_v in (9.0, 0.3):
        worker.say(light_v=light_v)
        QApplication.processEvents()
    desk.page.show()
    card = desk.page._widgets[connection].card
    assert card is not None
    assert card.next_step(desk.ports.now_s) == "Check again: changed: Light"


def test_a_check_that_is_void_on_its_page_is_void_here(desk: Desk) -> None:
    desk.plug_in(1)
    (connection, _), one = desk.modules[0], filed(desk)
    for void, need in ((None, Need.NO_GO), (Void(Disturbance.CHANGED, UserMessage("entries")), Need.VOID)):
        connection.kept.check = (one, void)
        desk.settle()
        card = desk.page._widgets[connection].card
        assert card is not None
        assert card.need is need


def test_lock_all_reaches_every_module_also_when_one_port_hangs(desk: Desk) -> None:
    desk.plug_in(5, active=True)
    desk.click(desk.page.lock_all)
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1] * 5
    for _, worker in desk.modules[1:]:  # the first one hangs: its job never ends
        worker.say(active=False)
    desk.settle()
    notice = desk.page.said.notice
    assert notice is not None
    assert "4 report LOCKED" in notice.text
    card = desk.page._widgets[desk.modules[0][0]].card
    assert card is not None
    assert card.need is Need.NOT_LOCKED
    assert card.activation.may_fire


def test_lock_on_a_card_is_for_that_module_alone_and_chooses_nothing(desk: Desk) -> None:
    desk.plug_in(3, active=True)
    third, worker = desk.modules[2]
    desk.click(desk.page._widgets[third].lock)
    assert [len(one.wanted(is_urgent=True)) for _, one in desk.modules] == [0, 0, 1]
    assert desk.ports.connector.current is desk.modules[0][0]
    assert worker.opened == ["/dev/port2"]


def test_a_click_on_a_card_shows_that_module_and_asks_where_edits_would_be_lost(desk: Desk) -> None:
    desk.plug_in(3)
    second, third = desk.modules[1][0], desk.modules[2][0]
    desk.qtbot.mouseClick(desk.page._widgets[second].title, Qt.MouseButton.LeftButton)
    assert desk.ports.connector.current is second
    desk.services.pending_edits.count = lambda: 2
    desk.page._widgets[third].setFocus()
    desk.qtbot.keyClick(desk.page._widgets[third], Qt.Key.Key_Return)
    assert desk.ports.connector.current is second
    assert desk.page.said.button("discard") is not None
    stay = desk.page.said.button("stay")
    assert stay is not None
    desk.click(stay)
    assert desk.page.said.notice is None
    assert desk.ports.connector.current is second


def test_who_needs_a_person_is_first_and_nothing_moves_under_the_keyboard(desk: Desk) -> None:
    desk.plug_in(4)
    last = desk.page._widgets[desk.modules[3][0]]
    first = desk.page.board.cards[0]
    first.setFocus()
    desk.modules[3][1].say(triggered=True)
    desk.settle()
    assert desk.page.board.cards[0] is first
    desk.page.lock_all.setFocus()
    desk.settle()
    assert desk.page.board.cards[0] is last
    assert last.trigger.word == "TRIGGERED"


def test_a_group_act_sends_questions_and_settings_only_where_it_may(desk: Desk) -> None:
    """The check asks; the profile writes settings. Nothing else that a person does here reaches several modules."""
    desk.plug_in(3)
    desk.modules[1][1].hand_over(identity=Identity(Trust.REFUTED))
    desk.settle()
    desk.click(desk.page.check)
    assert [len(worker.jobs) for _, worker in desk.modules] == [2, 2, 2]  # the handshake, and the check
    assert not any(worker.wanted(is_urgent=True) for _, worker in desk.modules)
    desk.modules[0][1].unplug()
    desk.settle()
    assert desk.page.checks.is_running  # one that is lost stops none of the others
    for _, worker in desk.modules[1:]:
        worker.end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.checks.is_running)
    results = desk.page.checks.results
    assert {one.verdict for one in results.values()} <= {None}
    assert len(results) == 3
    desk.page.profile.open(Profile(name="Show", settings={"attitude_threshold_deg": 70}))
    desk.page.profile.apply(desk.page.members.connections)
    states = [desk.page.profile.applied[one].state for one, _ in desk.modules]
    assert states == [Applied.UNREACHABLE, Applied.WRITING, Applied.WRITING]
    desk.modules[1][1].unplug()
    desk.settle()
    states = [desk.page.profile.applied[one].state for one, _ in desk.modules]
    assert states == [Applied.UNREACHABLE, Applied.FAILED, Applied.WRITING]
    shown = desk.page.panel.table.item(1, 2)
    assert shown is not None
    assert shown.text() == "FAILED: Link lost: the rest is unknown."
    speak_chinese()
    assert shown.text().endswith("通信中断：其余未知。")


def test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any(desk: Desk) -> None:
    desk.plug_in(3)
    page, strip = desk.page, desk.page.said
    page.profile.open(Profile(name="Bench", settings={"attitude_trigger": False, "attitude_threshold_deg": 70}))
    desk.settle()
    page.panel.write_pressed.emit()
    desk.settle()
    assert page.profile.applied == {}
    assert strip.notice is not None
    assert strip.notice.text == "Attitude trigger: No protection when it tips over."
    cancel, anyway = (choice.act for choice in strip.notice.choices)
    cancel()
    desk.settle()
    assert (strip.notice, page.profile.applied) == (None, {})
    page.profile.open(Profile(name="Bench", settings={"attitude_trigger": False, "freefall_trigger": False}))
    anyway()  # of the former question: what is written now was not all in it
    desk.settle()
    assert page.profile.applied == {}
    assert strip.notice is not None
    assert "Free-fall trigger: No protection in free fall." in strip.notice.text
    strip.notice.choices[1].act()
    assert [page.profile.applied[one].state for one, _ in desk.modules] == [Applied.WRITING] * 3
    page.profile.cancel()


def test_named_silent_modules_are_said_to_be_new_by_one_press(desk: Desk) -> None:
    case = check(options={"mute_codes": "35"}).assessment.case
    desk.plug_in(3)
    for (connection, _), name in zip(desk.modules, ("M-1", "", "M-2"), strict=True):
        desk.page.checks.results[connection] = SetMember("port", name, Filed(assess(case), {}))
    desk.page.checks.finished.emit()
    desk.settle()
    assert desk.page.said.notice is not None
    (say,) = desk.page.said.notice.choices
    assert say.text == "New, no records: M-1, M-2"
    say.act()
    desk.wait(lambda: desk.page.checks.is_running)
    store = desk.services.storage.store
    assert isinstance(store, Store)
    known = {module.name: CheckStore(store.database).is_said_new(module.name) for module in store.modules()}
    assert known == {"M-1": True, "M-2": True}


def test_a_notice_moves_no_card(desk: Desk) -> None:
    desk.plug_in(9)
    desk.settle()
    QApplication.processEvents()

    def places() -> list[QPoint]:
        return [card.mapTo(desk.page, QPoint()) for card in desk.page.board.cards]

    before = places()
    desk.page.result.set_notice(lambda: Notice(Meaning.ATTENTION, "Failed. " * 12))
    desk.settle()
    QApplication.processEvents()
    assert desk.page.said.isVisible()
    assert places() == before


def test_the_cards_fill_the_width_whatever_changes_it(desk: Desk) -> None:
    desk.plug_in(9)
    appearance, board, wrong = desk.services.appearance, desk.page.board, []
    sizes = ((1100, 500), (1100, 2400), (1100, 500), (700, 900), (700, 900), (1100, 1300), (780, 760), (1100, 500))
    for (width, height), percent in zip(sizes, (100, 100, 150, 150, 90, 90, 125, 100), strict=True):
        appearance.zoom(percent)
        desk.page.resize(width, height)
        desk.settle()
        QApplication.processEvents()
        found = [card.geometry() for card in board.cards]
        board.place()
        if found != [card.geometry() for card in board.cards]:
            wrong.append((width, height, percent))
    assert wrong == []


def test_the_cells_of_a_profile_follow_the_theme(desk: Desk) -> None:
    desk.plug_in(1)
    desk.page.profile.open(Profile(name="Show", settings={"attitude_threshold_deg": 70}))
    desk.settle()
    inks = []
    for theme in (Choice.LIGHT, Choice.DARK):
        desk.page._services.appearance.choose(theme)
        desk.page.refresh()
        item = desk.page.panel.table.item(0, 0)
        assert item is not None
        inks.append(item.foreground().color().lightness())
    assert inks[0] < 100 < 180 < inks[1]


def test_the_last_card_that_is_disconnected_leaves_its_port_and_another_takes_the_place(desk: Desk) -> None:
    desk.plug_in(2)
    (first, _), (second, worker) = desk.modules
    desk.page.members.disconnect_port(first)
    desk.settle()
    assert desk.ports.connector.current is second
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


def test_choosing_another_module_disarms_and_the_ritual_names_module_and_port(desk: Desk) -> None:
    desk.plug_in(2, active=True)
    naming, (second, _) = desk.services.naming, desk.modules[1]
    naming.of(second).choose("M-02")
    ritual = RitualWidget(desk.services)
    desk.qtbot.addWidget(ritual)
    ritual.show()
    desk.qtbot.waitExposed(ritual)
    ritual._choose(is_rehearsal=True)
    assert ritual.is_under_way
    desk.ports.connector.choose(second)
    assert not ritual.is_under_way
    assert ritual.ritual.ended_by is Input.LINK_LOST
    ritual.refresh()
    assert "M-02" in ritual._title.text()
    assert "port1" in ritual._title.text()


def test_closing_asks_while_any_module_is_active_and_locks_all_of_them(desk: Desk) -> None:
    desk.plug_in(2)
    bar, closed = NoticeBar(Texts()), list[bool]()
    desk.qtbot.addWidget(bar)
    attention = Attention(
        desk.ports.connector, bar, desk.services.lock, acts={}, pending_edits=desk.services.pending_edits,
        find_identity=lambda: None, go_to=lambda _page: None, shown_page=lambda: "", parent=desk.page,
    )  # fmt: skip
    assert attention.may_close(lambda: closed.append(True))
    desk.modules[1][1].say(active=True)  # not the one that the pages show
    desk.settle()
    assert not attention.may_close(lambda: closed.append(True))
    button = bar.button("lock_and_leave")
    assert button is not None
    button.click()
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1, 1]
    assert not closed


def test_the_report_of_all_is_exported_by_its_button(desk: Desk, tmp_path: Path) -> None:
    desk.plug_in(2)
    assert not desk.page.report.isEnabled()  # nothing was checked
    desk.click(desk.page.check)
    for _, worker in desk.modules:
        worker.end_jobs(Cancelled())
    desk.wait(desk.page.report.isEnabled)
    asked: list[str] = []

    def choose(_parent: QWidget, title: str, _suggested: Path, _kinds: str, then: ThenPath) -> None:
        asked.append(title)
        then(tmp_path / "fleet.pdf")

    desk.page.ask_report = choose
    desk.page.report.trigger()
    desk.wait(lambda: desk.page.said.notice is not None and "fleet.pdf" in desk.page.said.notice.text)
    assert asked == ["Export report…"]
    told = json.loads((tmp_path / "fleet.json").read_text(encoding="utf-8"))
    assert [one["trouble"] for one in told["modules"]] == ["Cancelled."] * 2
    assert (tmp_path / "fleet.pdf").read_bytes().startswith(b"%PDF")
