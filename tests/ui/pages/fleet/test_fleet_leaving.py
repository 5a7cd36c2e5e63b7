"""What is asked before a module on the Fleet board is left: edits, an ACTIVE module, and for whom."""

from PySide6.QtWidgets import QPushButton

from app.engine.identity import Identity, Trust
from app.procedures.lock import Locked
from app.safety.journal import Outcome
from tests.support.window.fake_ports import FakeWorker
from tests.ui.pages.fleet.conftest import Desk
from ui.core.texts import Texts
from ui.services.port import Port
from ui.shell.attention import Attention
from ui.widgets.notice_bar import NoticeBar


def attention_of(desk: Desk, page: str = "fleet") -> tuple[Attention, NoticeBar]:
    """The window's, wired as there, while this page is shown."""
    bar, connector = NoticeBar(Texts()), desk.ports.connector
    desk.qtbot.addWidget(bar)
    attention = Attention(
        connector, bar, acts={}, pending_edits=desk.services.pending_edits, go_to=lambda _page: None,
        shown_page=lambda: page, is_choosing=lambda: False, find_left=lambda: None, parent=desk.page,
    )  # fmt: skip
    connector.before_new = attention.leave_edits
    connector.before_leaving = lambda port, act: attention.leave_port(act, port=port)
    return attention, bar


def press(bar: NoticeBar, key: str) -> None:
    button = bar.button(key)
    assert isinstance(button, QPushButton)
    button.click()


def lock_reported(desk: Desk, port: Port, worker: FakeWorker) -> None:
    """LOCK of this port has ended: the module says so."""
    worker.say(active=False)
    port.lock._finish(Locked(outcome=Outcome.CONFIRMED, sent=1))
    desk.settle()


def test_disconnecting_a_card_asks_before_edits_are_lost(desk: Desk) -> None:
    desk.plug_in(2)
    _, bar = attention_of(desk)
    (first, _), (second, _) = desk.modules
    edits = [1]
    desk.services.pending_edits.count = lambda: len(edits)
    desk.services.pending_edits.discard = edits.clear
    desk.page._widgets[first].disconnect_action.trigger()
    desk.settle()
    assert desk.ports.connector.current is first
    assert bar.notice is not None
    assert bar.notice.text == "Settings not written: 1."
    bar.notice.choices[1].act()
    desk.settle()
    assert desk.page.members.connections == (second,)
    assert not edits


def test_another_module_on_a_card_asks_about_no_edits_of_the_shown_one(desk: Desk) -> None:
    desk.plug_in(2)
    _, bar = attention_of(desk)
    (first, _), (second, worker) = desk.modules
    desk.services.pending_edits.count = lambda: 1
    worker.hand_over(identity=Identity(Trust.UNPROVEN))
    desk.settle()
    opening = second.view.opening
    desk.page._widgets[second].new.chosen.emit()
    assert second.view.opening == opening + 1
    assert bar.notice is None
    first.module.treat_as_new()
    assert bar.notice is not None
    assert bar.notice.text == "Settings not written: 1."


def test_disconnecting_the_card_of_an_active_module_asks_first(desk: Desk) -> None:
    desk.plug_in(2)
    _, bar = attention_of(desk)
    (first, _), (second, worker) = desk.modules
    worker.say(active=True)
    desk.settle()
    desk.page._widgets[second].disconnect_action.trigger()
    desk.settle()
    assert desk.page.members.connections == (first, second)
    assert bar.notice is not None
    assert bar.notice.text == "/dev/port1: The module is ACTIVE: it fires also without this program."
    press(bar, "lock_and_leave")
    assert [len(one.wanted(is_urgent=True)) for _, one in desk.modules] == [0, 1]
    lock_reported(desk, second, worker)
    assert desk.page.members.connections == (first,)


def test_leaving_that_was_cancelled_is_not_done_when_lock_is_confirmed(desk: Desk) -> None:
    desk.plug_in(1, active=True)
    attention, bar = attention_of(desk)
    ((port, worker),) = desk.modules
    desk.page._widgets[port].disconnect_action.trigger()
    press(bar, "lock_and_leave")
    attention.stay()
    lock_reported(desk, port, worker)
    assert port.is_requested


def test_closing_asks_while_any_module_is_active_and_locks_all_of_them(desk: Desk) -> None:
    desk.plug_in(2)
    (attention, bar), closed = attention_of(desk), list[bool]()
    assert attention.may_close(lambda: closed.append(True))
    desk.modules[1][1].say(active=True)  # not the one that the pages show
    desk.settle()
    assert not attention.may_close(lambda: closed.append(True))
    button = bar.button("lock_and_leave")
    assert button is not None
    button.click()
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1, 1]
    assert not closed


def test_a_lock_that_another_port_does_not_confirm_is_said_on_every_page(desk: Desk) -> None:
    desk.plug_in(2, active=True)
    _, bar = attention_of(desk, page="live")
    (_, first), (second, worker) = desk.modules
    second.module.choose("M-02")
    second.lock._finish(Locked(outcome=Outcome.UNKNOWN, sent=50))
    assert bar.notice is not None
    assert bar.notice.text == "NOT reported, treat as ACTIVE: M-02"
    press(bar, "lock_others")
    assert [len(one.wanted(is_urgent=True)) for one in (first, worker)] == [0, 1]
    lock_reported(desk, second, worker)
    assert bar.notice is None
