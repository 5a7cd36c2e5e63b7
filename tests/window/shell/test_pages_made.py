"""The pages are made after the first paint."""

from functools import partial
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import window
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
