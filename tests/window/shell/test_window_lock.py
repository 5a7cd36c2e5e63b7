"""LOCK from the window: one gesture, repeatable, and confirmed only by the module's report."""

from collections.abc import Iterator
from functools import partial
from operator import attrgetter
from pathlib import Path

import pytest
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication, QDialog, QMenu, QWidget
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from protocol.catalogue import ACTIVATION, Request
from tests.support.line.frames import at_each_frame
from tests.support.line.odd_module import end_faults
from tests.support.window.fake_ports import fake_window
from tests.support.window.fakes_ui import EMPTY_PAGE, simulated, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, notice_text, press
from ui.main import PAGES
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.session.lock import PortLock
from ui.session.ports import LockControl
from ui.shell.application_filter import LOCK_ALL_KEY
from ui.shell.main_window import MainWindow
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice


@pytest.mark.parametrize("way", ["click", "key"])
def test_lock_is_one_gesture(one: Rig, way: str) -> None:
    if way == "click":
        press(one.qtbot, one.assembly.window.top_bar.lock)
    else:
        one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
    one.until(lambda: not one.bench.module.state.is_active)
    one.until(lambda: one.assembly.window.top_bar.activation.word == "LOCKED")
    one.until(lambda: "LOCKED" in one.assembly.window.status_bar.passing.text())
    one.bench.module.state.is_active = True  # by somebody else
    one.until(lambda: one.assembly.window.top_bar.activation.word == "ACTIVE")
    one.until(lambda: one.assembly.window.status_bar.passing.text() == "", limit_s=1.0)


def test_a_key_that_is_held_is_one_press(one: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed = list[str]()
    monkeypatch.setattr(PortLock, "press", lambda _lock, **_: pressed.append("LOCK"))
    for is_repeat in (False, True, True):
        event = QKeyEvent(QEvent.Type.KeyPress, Qt.Key.Key_F12, Qt.KeyboardModifier.NoModifier, "", is_repeat)
        QCoreApplication.sendEvent(one.assembly.window, event)
    assert pressed == ["LOCK"]


def lossy(bench: SimulatedBench, lost: int) -> list[float]:
    """The first `lost` LOCKs do not arrive; when each of them left."""
    times = list[float]()

    def lose(request: Request) -> bool:
        if request.command is ACTIVATION:
            times.append(bench.clock())
        return request.command is not ACTIVATION or len(times) > lost

    at_each_frame(bench, lose)
    return times


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Rig]:
    """On an ACTIVE module."""
    with on_fake_time(Rig, qtbot, qapp, tmp_path, f"lock{tmp_path.name}", EMPTY_PAGE, active=True) as made:
        made.connect()
        made.until(made.assembly.window.top_bar.lock.isEnabled)
        yield made


def test_it_is_repeated_and_shown_until_the_module_reports_it(one: Rig) -> None:
    times = lossy(one.bench, 5)
    bar = one.assembly.window.notice_bar
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: "LOCK sent 3×, not yet" in notice_text(bar))
    assert bar.notice is not None
    assert bar.notice.meaning is Meaning.ATTENTION
    assert one.assembly.window.status_bar.passing.text() == "", "it would stand beside the notice: Locking…"
    one.until(lambda: not one.bench.module.state.is_active)
    one.until(lambda: bar.notice is None)
    assert len(times) == 6
    confirmed = given(one.assembly.ports.current.lock.confirmed)
    assert confirmed.sent == 6


def test_escape_does_not_end_it(one: Rig) -> None:
    times = lossy(one.bench, 4)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: len(times) >= 2)
    one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_Escape)
    one.until(lambda: not one.bench.module.state.is_active)


def fail(one: Rig, monkeypatch: pytest.MonkeyPatch) -> Notice:
    monkeypatch.setattr("app.engine.procedure.LOCKS_FOR_S", 0.5)
    one.bench.change(mute=True)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    bar = one.assembly.window.notice_bar
    one.until(lambda: bar.button("lock_again") is not None)
    assert bar.notice is not None
    return bar.notice


@pytest.mark.promise("l")
def test_a_lock_that_fails_is_said_on_every_page_until_the_module_reports_that_it_is_locked(
    one: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    notice = fail(one, monkeypatch)
    assert notice.meaning is Meaning.DANGER
    assert "treat the module as ACTIVE" in notice.text
    assert notice.dismiss is None
    bar = one.assembly.window.notice_bar
    one.assembly.window.attention.stay()
    one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_Escape)
    assert "treat the module as ACTIVE" in notice_text(bar)
    end_faults(one.bench)
    one.bench.change(mute=False)
    one.bench.module.activate(is_active=False)  # somebody locks it in another way
    one.until(lambda: one.assembly.ports.current.lock.failed is None)
    one.until(lambda: "treat the module as ACTIVE" not in notice_text(bar))
    assert one.assembly.ports.current.lock.failed is None


@pytest.mark.promise("l")
def test_it_goes_first_when_the_port_comes_back_within_a_minute(one: Rig) -> None:
    bar, port = one.assembly.window.notice_bar, one.assembly.ports.current
    heal = at_each_frame(one.bench, lambda request: request.command is not ACTIVATION)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: bool(port.lock.sent))
    one.bench.unplug()
    one.until(lambda: not port.is_open and port.lock.owed is not None)
    assert "treat the module as ACTIVE. Sent when it answers" in notice_text(bar)
    heal()
    one.bench.plug()
    one.until(lambda: not one.bench.module.state.is_active)
    one.until(lambda: not port.lock.is_unproven)


@pytest.mark.promise("l")
def test_after_a_minute_it_is_not_sent_any_more(one: Rig) -> None:
    port = one.assembly.ports.current
    heal = at_each_frame(one.bench, lambda request: request.command is not ACTIVATION)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: bool(port.lock.sent))
    one.bench.unplug()
    one.until(lambda: port.lock.owed is not None)
    one.wait(62.0)
    heal()
    one.bench.plug()
    one.until(lambda: port.module.is_going)
    one.wait(2.0)
    assert one.bench.module.state.is_active
    assert port.lock.owed is not None
    assert "treat the module as ACTIVE" in notice_text(one.assembly.window.notice_bar)


@pytest.mark.promise("l")
def test_what_is_activated_on_purpose_is_not_locked_again(one: Rig) -> None:
    times = lossy(one.bench, 100)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: len(times) >= 2)
    one.assembly.ports.current.lock.give_up()
    one.until(lambda: not one.assembly.ports.current.lock.is_repeating)
    assert not one.assembly.ports.current.lock.is_unproven
    count = len(times)
    one.wait(0.4)
    assert len(times) == count


@pytest.mark.parametrize("is_unplugged", [False, True])
@pytest.mark.promise("l")
def test_a_lock_that_goes_on_never_reaches_another_port(one: Rig, is_unplugged: bool) -> None:
    connector = one.assembly.ports
    lock, done = connector.current.lock, list[str]()
    with simulated("other") as other:
        other.module.activate(is_active=True)
        one.bench.change(mute=True)
        lock.press(then=lambda: done.append("meant for the former module"))
        one.until(lambda: bool(lock.sent))
        if is_unplugged:
            one.bench.unplug()
            one.until(lambda: not connector.current.is_open)
        one.url = "sim://other"
        one.connect()
        one.until(lambda: connector.module.is_going)
        one.wait(1.0)
        assert other.module.state.is_active
        assert not lock.is_repeating
        press(one.qtbot, one.assembly.window.top_bar.lock)
        one.until(lambda: lock.confirmed is not None)
        assert done == []


def test_its_keys_count_while_the_pages_are_made(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None lets a key through that was pressed meanwhile, or shows a dialog or a menu: then the filter is set aside."""
    pressed, shown = list[str](), list[QWidget]()
    monkeypatch.setattr(LockControl, "press", lambda _lock: pressed.append("LOCK"))

    def make(entry: PageEntry, services: Services) -> Page:
        main = next(one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow))
        event = QKeyEvent(QEvent.Type.KeyPress, Qt.Key.Key_F12, Qt.KeyboardModifier.NoModifier)
        QCoreApplication.postEvent(main, event)
        page = entry.make(services)
        dialogs = (one for one in QApplication.topLevelWidgets() if isinstance(one, QDialog | QMenu))
        shown.extend(one for one in dialogs if one.isVisible())
        return page

    broken = PAGES[0]._replace(key="broken", make=attrgetter("no_page"))
    entries = tuple(entry._replace(make=partial(make, entry)) for entry in (broken, *PAGES))
    with qtbot.captureExceptions() as raised, window(qapp, tmp_path, entries=entries) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages and len(pressed) == len(entries))
        assert [kind for kind, *_ in raised] == [AttributeError]
    assert shown == []


def test_a_module_that_is_not_shown_and_active_is_named_beside_lock(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        main = assembly.window
        first, here = ports.plug_in("/dev/one", active=True)
        second, there = ports.plug_in("/dev/two", active=False)
        qapp.processEvents()
        button = main.top_bar.lock_others
        assert assembly.ports.current is first
        assert button.isHidden()
        there.say(active=True)
        qtbot.waitUntil(button.isVisible)
        assert button.text() == "LOCK two"
        press(qtbot, button)
        assert second.lock.is_repeating
        assert not first.lock.is_repeating
        there.unplug()
        qapp.processEvents()
        assert button.isVisible(), "nobody has seen it locked"
        qtbot.keySequence(main, LOCK_ALL_KEY)
        assert first.lock.is_repeating
        assert here.wanted(is_urgent=True)
