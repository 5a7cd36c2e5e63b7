"""What was done to a module in the window is found in its history, under the name that it had then."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.archive.local_facts import open_facts
from app.archive.module_history import module_history
from app.archive.module_names import names_of
from app.safety.acts import Act
from app.settings.form import RowState
from app.stations.station import own_station
from app.store.store import Store
from tests.support.window.settings_bench import Desk, desk, state, type_into, write


def test_acts_and_settings_are_in_the_history_of_the_module_of_that_name(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        naming = one.assembly.window._services.naming
        _lock(one)  # without a name: in nobody's history
        naming.choose("M-07")
        type_into(one, "freefall_time", "1.2")
        write(one)
        one.until(lambda: state(one, "freefall_time_s") is RowState.VERIFIED)
        one.go_to("commands")
        zero = one.commands.acts[Act.ZERO].confirm
        one.ask(zero)
        one.click(zero.go)
        one.until(lambda: not one.assembly.connector.is_busy)
        naming.choose("M-08")
        _lock(one)
        told = _told(one.assembly.storage.store, tmp_path)
    assert list(told) == ["M-07"]  # nothing was stored of the other one
    named, settings, *acts = told["M-07"]
    assert named == "Named M-07."
    assert "Free-fall time 1.60 s" in settings  # as it was found, before the write
    assert acts == ["Free-fall time 1.20 s: confirmed.", "Zero the sensor: confirmed."]


def _lock(one: Desk) -> None:
    lock, before = one.assembly.window._services.lock, len(one.changes("activation"))
    lock.press()
    one.until(lambda: len(one.changes("activation")) > before and not lock.is_repeating)


def _told(store: object, folder: Path) -> dict[str, list[str]]:
    """The history of every module in English, as the archive of this computer has it."""
    assert isinstance(store, Store)
    facts = open_facts(folder / "archive", store.facts)
    try:
        facts.sign(own_station(folder))
        return {
            module.name: [event.text.in_english() for event in module_history(facts, module).events]
            for module in names_of(facts, ()).modules
        }
    finally:
        facts.close()
