"""LOCK from the window: one gesture, repeatable, and confirmed only by the module's report."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from protocol.catalogue import ACTIVATION
from tests.support.window.fakes_ui import connect, simulated, window
from tests.support.window.steps import notice_text, press
from ui.main import Assembly
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice


@pytest.mark.parametrize("way", ["click", "key"])
def test_lock_is_one_gesture(qtbot: QtBot, qapp: QApplication, tmp_path: Path, way: str) -> None:
    with active_module(qtbot, qapp, tmp_path, "lock") as (assembly, bench):
        if way == "click":
            press(qtbot, assembly.window.top_bar.lock)
        else:
            qtbot.keyClick(assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
        qtbot.waitUntil(lambda: not bench.state().is_active)
        qtbot.waitUntil(lambda: assembly.window.top_bar.activation.word == "LOCKED")
        qtbot.waitUntil(lambda: "LOCKED" in assembly.window.status_bar.passing.text())


def lossy(bench: SimulatedBench, lost: int) -> list[float]:
    """The first `lost` LOCKs do not arrive; when each of them left."""
    write, times = bench.wire.write, list[float]()

    def lose(data: bytes, now_s: float) -> None:
        if data[2] == ACTIVATION.code:
            times.append(now_s)
        if data[2] != ACTIVATION.code or len(times) > lost:
            write(data, now_s)

    bench.wire.write = lose  # type: ignore[method-assign]
    return times


@contextmanager
def active_module(
    qtbot: QtBot, qapp: QApplication, folder: Path, name: str
) -> Iterator[tuple[Assembly, SimulatedBench]]:
    with simulated(name, active=True) as bench, window(qapp, folder) as assembly:
        connect(qtbot, assembly, f"sim://{name}")
        qtbot.waitUntil(assembly.window.top_bar.lock.isEnabled)
        yield assembly, bench


def test_it_is_repeated_and_shown_until_the_module_reports_it(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with active_module(qtbot, qapp, tmp_path, "repeated") as (assembly, bench):
        times = lossy(bench, 5)
        bar = assembly.window.notice_bar
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: "LOCK sent 3×, not yet" in notice_text(bar))
        assert bar.notice is not None
        assert bar.notice.meaning is Meaning.ATTENTION
        assert assembly.window.status_bar.passing.text() == "", "it would stand beside the notice: Locking…"
        qtbot.waitUntil(lambda: not bench.state().is_active)
        qtbot.waitUntil(lambda: bar.notice is None)
        assert len(times) == 6
        confirmed = assembly.connector.current.lock.confirmed
        assert confirmed is not None
        assert confirmed.sent == 6


def wait_for_identity(qtbot: QtBot, assembly: Assembly) -> None:
    """Wait until enough was read to recognise the module after a loss of the port."""
    port = assembly.connector.current
    qtbot.waitUntil(lambda: port.device.values.keys() >= {"boot_count", "freefall_time_s"})


def say_which_module(qtbot: QtBot, assembly: Assembly, key: str) -> None:
    """Answer the question which module this is. It is asked again if the module fell silent just then, as it may on a
    busy machine: the answer would have been about what was there before."""
    bar, port = assembly.window.notice_bar, assembly.connector.current
    for _ in range(10):
        qtbot.waitUntil(lambda: bar.button(key) is not None)
        press(qtbot, bar.button(key))
        with suppress(qtbot.TimeoutError):
            qtbot.waitUntil(lambda: port.identity.is_settled, timeout=3000)
            return
    pytest.fail("the question stays")


def test_lock_pressed_again_is_sent_at_once(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with active_module(qtbot, qapp, tmp_path, "twice") as (assembly, bench):
        times = lossy(bench, 1)
        lock = assembly.window.top_bar.lock
        press(qtbot, lock)
        qtbot.waitUntil(lambda: len(times) >= 1)
        press(qtbot, lock)
        qtbot.waitUntil(lambda: "LOCKED" in assembly.window.status_bar.passing.text())
        assert not bench.state().is_active
        assert len(times) >= 2


def test_escape_does_not_end_it(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with active_module(qtbot, qapp, tmp_path, "escape") as (assembly, bench):
        times = lossy(bench, 4)
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: len(times) >= 2)
        qtbot.keyClick(assembly.window, Qt.Key.Key_Escape)
        qtbot.waitUntil(lambda: not bench.state().is_active)


def fail(qtbot: QtBot, assembly: Assembly, bench: SimulatedBench, monkeypatch: pytest.MonkeyPatch) -> Notice:
    monkeypatch.setattr("app.engine.procedure.LOCKS_FOR_S", 0.5)
    bench.change(mute=True)
    press(qtbot, assembly.window.top_bar.lock)
    bar = assembly.window.notice_bar
    qtbot.waitUntil(lambda: bar.button("lock_again") is not None)
    assert bar.notice is not None
    return bar.notice


def test_a_lock_that_fails_is_said_on_every_page_until_the_module_reports_that_it_is_locked(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with active_module(qtbot, qapp, tmp_path, "deaf") as (assembly, bench):
        notice = fail(qtbot, assembly, bench, monkeypatch)
        assert notice.meaning is Meaning.DANGER
        assert "treat the module as ACTIVE" in notice.text
        assert notice.dismiss is None
        bar = assembly.window.notice_bar
        assembly.window.attention.stay()
        qtbot.keyClick(assembly.window, Qt.Key.Key_Escape)
        assert "treat the module as ACTIVE" in notice_text(bar)
        bench.end_faults()
        bench.change(mute=False)
        bench.module.activate(is_active=False)  # somebody locks it in another way
        port = assembly.connector.current
        qtbot.waitUntil(lambda: bar.notice is None or port.identity.is_for_a_person)  # after a second of silence
        port.confirm_identity()
        qtbot.waitUntil(lambda: bar.notice is None)
        assert assembly.connector.current.lock.failed is None


def test_a_lock_that_fails_is_forgotten_with_its_module(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with active_module(qtbot, qapp, tmp_path, "deaf") as (assembly, bench), simulated("other"):
        fail(qtbot, assembly, bench, monkeypatch)
        connect(qtbot, assembly, "sim://other")
        qtbot.waitUntil(lambda: assembly.window.notice_bar.notice is None)


def test_closing_with_an_unconfirmed_lock_is_confirmed(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with active_module(qtbot, qapp, tmp_path, "closing") as (assembly, bench):
        fail(qtbot, assembly, bench, monkeypatch)
        assembly.window.close()
        assert assembly.window.isVisible()
        notice = assembly.window.notice_bar.notice
        assert notice is not None
        assert [choice.key for choice in notice.choices] == ["lock_and_leave", "leave_active", "stay"]


def test_it_is_sent_again_when_the_port_comes_back_in_time(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with active_module(qtbot, qapp, tmp_path, "returns") as (assembly, bench):
        bar = assembly.window.notice_bar
        wait_for_identity(qtbot, assembly)
        bench.change(mute=True)
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: assembly.connector.current.lock.is_repeating)
        bench.unplug()
        qtbot.waitUntil(lambda: not assembly.connector.current.is_open)
        assert assembly.connector.current.lock.is_repeating
        assert "when the port is back" in notice_text(bar)
        bench.end_faults()
        bench.change(mute=False)
        bench.plug()
        qtbot.waitUntil(lambda: not bench.state().is_active)
        qtbot.waitUntil(lambda: bar.button("identity_same") is not None)
        qtbot.wait(300)  # it has reported LOCKED several times, and may be a twin
        assert assembly.connector.current.lock.confirmed is None
        assert "treat the module as ACTIVE" in notice_text(bar)
        say_which_module(qtbot, assembly, "identity_same")
        qtbot.waitUntil(lambda: assembly.connector.current.lock.confirmed is not None)


@pytest.mark.parametrize("is_late", [False, True])
@pytest.mark.parametrize("answer", ["identity_same", "identity_new"])
def test_the_report_of_what_may_be_another_module_confirms_nothing(
    qtbot: QtBot,
    qapp: QApplication,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    answer: str,
    is_late: bool,
) -> None:
    with active_module(qtbot, qapp, tmp_path, f"exchanged {answer} {is_late}") as (assembly, bench):
        connector, bar = assembly.connector, assembly.window.notice_bar
        lock = connector.current.lock
        wait_for_identity(qtbot, assembly)
        if is_late:
            monkeypatch.setattr("app.engine.procedure.LOCKS_FOR_S", 0.2)
        bench.change(mute=True)
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: bool(lock.sent))
        bench.unplug()
        qtbot.waitUntil(lambda: not connector.current.is_open and lock.is_repeating is not is_late)
        bench.change(mute=False)
        bench.module.memory.boot_count -= 20
        bench.restart()  # another one, which is locked
        bench.plug()
        qtbot.waitUntil(lambda: connector.current.identity.is_for_a_person)
        qtbot.waitUntil(lambda: not lock.is_repeating)
        qtbot.wait(300)  # it has reported LOCKED several times
        assert (lock.confirmed, lock.failed is None) == (None, False)
        qtbot.waitUntil(lambda: "treat the module as ACTIVE. This may be another" in notice_text(bar))
        say_which_module(qtbot, assembly, answer)
        qtbot.waitUntil(lambda: bar.notice is None or "restarted" in bar.notice.text)
        assert (lock.confirmed is not None, lock.failed) == (answer == "identity_same", None)


def test_a_twin_behind_the_open_port_confirms_nothing_for_a_named_module(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    """The adapter stays plugged in; another module with the same boot count and settings, locked, answers."""
    with active_module(qtbot, qapp, tmp_path, "twin") as (assembly, bench):
        connector = assembly.connector
        lock = connector.current.lock
        wait_for_identity(qtbot, assembly)
        assembly.connector.current.module.choose("M-1")
        qtbot.waitUntil(lambda: connector.current.identity.is_named)
        bench.change(mute=True)
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: connector.current.device.breaks > 0)
        bench.module.activate(is_active=False)
        bench.change(mute=False)
        port = connector.current
        qtbot.waitUntil(lambda: port.identity.is_for_a_person and not lock.is_repeating)
        qtbot.wait(300)  # it has reported LOCKED several times
        assert (lock.confirmed, lock.failed is None) == (None, False)
        say_which_module(qtbot, assembly, "identity_same")
        qtbot.waitUntil(lambda: lock.confirmed is not None)


def test_what_is_activated_on_purpose_is_not_locked_again(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with active_module(qtbot, qapp, tmp_path, "purpose") as (assembly, bench):
        times = lossy(bench, 100)
        press(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: len(times) >= 2)
        assembly.connector.current.lock.end()
        qtbot.waitUntil(lambda: not assembly.connector.current.lock.is_repeating)
        assert not assembly.connector.current.lock.is_unproven
        count = len(times)
        qtbot.wait(400)
        assert len(times) == count
