"""Pages are made after the first paint of the window."""

from functools import partial
from pathlib import Path

import pytest
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from protocol.link_states import Presence
from tests.support.window.fakes_ui import simulated, window
from tests.support.window.steps import await_child
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.shell.main_window import MainWindow
from ui.shell.page_area import PageMaker
from ui.style.icons import Icon


def test_pages_are_made_after_the_first_paint(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    make = MainWindow.make_pages

    def painted(self: QWidget, _event: QPaintEvent) -> None:
        order.append("painted")

    def made(self: MainWindow) -> None:
        order.append("made")
        make(self)

    monkeypatch.setattr(MainWindow, "paintEvent", painted, raising=False)
    monkeypatch.setattr(MainWindow, "make_pages", made)
    with window(qapp, tmp_path):
        qtbot.waitUntil(lambda: "made" in order)
    assert order[0] == "painted"
    assert order.count("made") == 1


def test_a_window_that_is_never_painted_gets_its_pages(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MainWindow, "show", lambda self: None)
    with window(qapp, tmp_path) as assembly:
        await_child(qtbot, assembly.window, QWidget, "traffic_page")


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


def test_a_turn_makes_and_places_one_page(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    done: list[int] = []
    placed: list[str] = []
    turn, place = PageMaker._make_next, MainWindow._place

    def counted(maker: PageMaker) -> None:
        before = len(made) + len(placed)
        turn(maker)
        done.append(len(made) + len(placed) - before)

    def noted(main: MainWindow, key: str, page: Page) -> None:
        placed.append(key)
        place(main, key, page)

    monkeypatch.setattr(PageMaker, "_make_next", counted)
    monkeypatch.setattr(MainWindow, "_place", noted)
    with window(qapp, tmp_path, entries=leaves(made)) as assembly:
        qtbot.waitSignal(assembly.window.pages_made).wait()
        assert made == placed == list("abcd")
        assert done == [2] * 4 + [0]


def test_a_page_that_is_chosen_before_it_is_made_comes_next(qapp: QApplication, qtbot: QtBot, tmp_path: Path) -> None:
    made: list[str] = []
    with window(qapp, tmp_path, entries=leaves(made)) as assembly:
        assembly.window.go_to("c")
        qtbot.waitSignal(assembly.window.pages_made).wait()
        assert made == list("cabd")
        assert assembly.window.stack.currentWidget() is assembly.window._pages["c"]


def test_a_port_that_was_held_back_for_the_pages_goes_on_though_another_one_is_shown(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=leaves([])) as assembly, simulated("held back"):
        ports, held = assembly.connector, assembly.connector.current
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window._maker.hold_batches()
            held.connect_to(Target("sim://held back", 115200))
            ports.choose(ports.add())
            assert ports.current is not held
            assembly.window._maker.hold_batches()
        qtbot.waitUntil(lambda: held.device.presence is Presence.ONLINE)
