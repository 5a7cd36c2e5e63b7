"""What the Live page paints: its plots when their picture changes, its numbers when a report does, the first paint
first.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import window
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.steps import await_child
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.shell.main_window import MainWindow
from ui.style.icons import Icon


def test_a_window_that_is_never_painted_gets_its_pages(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MainWindow, "show", lambda self: None)
    with window(qapp, tmp_path) as assembly:
        await_child(qtbot, assembly.window, QWidget, "empty_page")


class Leaf(Page):
    """A page with nothing in it."""

    def __init__(self, _services: Services) -> None:
        super().__init__("leaf")


def leaves(made: list[str], keys: str = "abcd") -> tuple[PageEntry, ...]:
    """An entry a letter; `made` gets the letters in the order in which their pages are made."""

    def make(key: str, services: Services) -> Page:
        made.append(key)
        return Leaf(services)

    return tuple(PageEntry(key, key, Icon.LIVE, partial(make, key)) for key in keys)


def test_a_page_that_is_chosen_before_it_is_made_comes_next(qapp: QApplication, qtbot: QtBot, tmp_path: Path) -> None:
    made: list[str] = []
    with window(qapp, tmp_path, entries=leaves(made)) as assembly:
        assembly.window.go_to("c")
        qtbot.waitSignal(assembly.window.pages_made).wait()
        assert made == list("cabd")
        assert assembly.window.stack.currentWidget() is assembly.window._pages["c"]


@pytest.fixture
def bench(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as made:
        made.say()
        made.page._timer.stop()
        qapp.processEvents()
        yield made


@pytest.mark.promise("j")
def test_the_numbers_follow_some_batches_and_a_change_of_state_at_once(
    bench: Bench, qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[object] = []
    monkeypatch.setattr(bench.page.panel, "show_device", lambda device, *_, **__: shown.append(device.reported))
    bench.page._timer.stop()
    monkeypatch.setattr(bench.page._timer, "restart", int)  # only batches count here, however slow the computer is
    bench.now_s += 0.01
    for _ in range(3):  # too soon for other numbers
        bench.hand_over()
        qapp.processEvents()
    assert shown == []
    bench.hand_over(triggered=True, active=False)
    qapp.processEvents()
    bench.hand_over(triggered=True, active=True)
    qapp.processEvents()
    assert list(dict.fromkeys(shown)) == [(True, False), (True, True)]


@pytest.mark.promise("j")
def test_a_trigger_and_an_activation_are_changes_that_everybody_hears_of(bench: Bench, qapp: QApplication) -> None:
    heard: list[object] = []
    bench.connector.changed.connect(lambda: heard.append(bench.connector.current.module.view.reported))
    for state in ((False, False), (True, False), (True, False), (True, True)):
        bench.hand_over(triggered=state[0], active=state[1])
        qapp.processEvents()
    assert list(dict.fromkeys(heard)) == [(True, False), (True, True)]


def test_a_report_just_after_a_turn_without_one_is_shown_at_once(bench: Bench) -> None:
    """It waited for the next turn: as batches came a little more slowly than turns, each number was one batch late."""
    bench.now_s += 0.1
    bench.page._tick_alone()
    bench.now_s += 0.01
    bench.hand_over(tilt_deg=33)
    QApplication.processEvents()
    assert bench.page.panel.tilt.text == "33"
