"""Names that a scanner types, and the labels that are printed for it."""

from itertools import product
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.store.fact_store import Store
from tests.support.records.stored import register
from tests.support.window.fake_ports import fake_window
from tests.support.window.fakes_ui import store_of
from tests.support.window.steps import given
from ui.files.file_dialogs import ThenPath
from ui.main import Assembly
from ui.pages.preflight.page import PreflightPage
from ui.pages.triggers.page import TriggersPage
from ui.services.context import PageEntry
from ui.session.name_question import ModuleField
from ui.shell.label_actions import LabelActions
from ui.style.icons import Icon

PAGES = (
    PageEntry("preflight", "Pre-flight", Icon.CHECKLIST, PreflightPage),
    PageEntry("triggers", "Triggers", Icon.HISTORY, TriggersPage),
)


def with_modules(assembly: Assembly, qtbot: QtBot, *names: str) -> Store:
    """The window's store, once it is open, with these modules."""
    qtbot.waitUntil(lambda: isinstance(assembly.storage.store, Store))
    store = store_of(assembly.storage)
    for name in names:
        register(store, name)
    return store


@pytest.mark.parametrize("known", [("M-070", "m-07"), ("M-07", "M-070")])
def test_a_scanned_name_is_taken_as_it_was_typed_wherever_a_module_is_named(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, known: tuple[str, ...]
) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        main = assembly.window
        qtbot.waitUntil(lambda: main.has_pages)
        ports.plug_in("/dev/one")
        qtbot.waitUntil(lambda: assembly.ports.module.is_read)
        naming = assembly.ports.module
        for number, page in product(range(len(known) + 1), PAGES):
            with_modules(assembly, qtbot, *known[:number])
            main.go_to(page.key)
            shown = given(main.stack.currentWidget())
            field = shown.findChildren(ModuleField)[0]
            field.show_name()
            edit = given(field.lineEdit())
            edit.setFocus()
            edit.selectAll()
            QTest.keyClicks(edit, "M-07")
            QTest.keyClick(edit, Qt.Key.Key_Return)
            assert (naming.name, edit.text()) == ("M-07", "M-07"), page.key
            naming.say_name("")


def test_a_label_is_printed_of_the_named_module_and_a_sheet_of_all(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    asked: list[Path] = []

    def ask(_parent: object, _title: str, suggested: Path, _filter: str, then: ThenPath) -> None:
        asked.append(tmp_path / suggested.name)
        then(asked[-1])

    with fake_window(qapp, tmp_path) as (ports, assembly):
        main = assembly.window
        ports.plug_in("/dev/one")
        qtbot.waitUntil(lambda: assembly.ports.module.is_read)
        menus, naming = main.menus, assembly.ports.module
        actions = main.findChildren(LabelActions)[0]
        actions.ask_path = ask
        menus.refresh()
        assert not menus["label_62"].isEnabled()
        store = with_modules(assembly, qtbot, "M-08")
        naming.say_name("M-07/../<b>")
        menus.refresh()
        menus["label_24"].trigger()
        qtbot.waitUntil(lambda: asked[-1].name in main.status_bar.passing.text())
        menus["label_A4"].trigger()
        qtbot.waitUntil(lambda: asked[-1].name in main.status_bar.passing.text())
        assert [path.name for path in asked] == ["M-07_b label.pdf", "DPS-S label.pdf"]
        assert all(path.read_bytes().startswith(b"%PDF-") for path in asked)
        register(store, "W" * 61)
        asked[-1].unlink()
        menus["label_A4"].trigger()
        refused = "Name: at most 60 characters"
        qtbot.waitUntil(lambda: refused in main.status_bar.passing.text())
        assert not asked[-1].exists()
