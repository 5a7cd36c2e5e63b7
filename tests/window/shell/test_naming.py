"""Names that a scanner types."""

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
from ui.main import Assembly
from ui.pages.preflight.page import PreflightPage
from ui.pages.triggers.page import TriggersPage
from ui.services.context import PageEntry
from ui.session.module_field import ModuleField
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
