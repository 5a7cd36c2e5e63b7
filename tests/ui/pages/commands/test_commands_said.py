"""What the Commands page says: nothing of a module that is not there, or that is another by now."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.safety.acts import Act
from protocol.messages import Source
from tests.support.window.fakes_ui import simulated, window
from tests.support.window.settings_bench import ENTRIES, desk
from tests.support.window.steps import await_child
from ui.pages.commands.page import CommandsPage


def test_without_a_port_nothing_is_said_of_the_log(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=ENTRIES) as assembly:
        page = await_child(qtbot, assembly.window, CommandsPage)
        page.refresh()
        for row in page.acts.values():
            assert "does not answer" in row.conditions.text()
            assert "log" not in row.conditions.text()
            assert not row.confirm.ask.isEnabled()


def test_after_a_trigger_it_says_fired_until_the_module_says_otherwise(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, page="commands", active=True) as one:
        meaning, until_locked = one.commands.meaning, "Treat it as ready to fire until it reports LOCKED."
        one.until(lambda: meaning.text() == "Ready to fire: lock it before you touch it.")
        one.bench.module.fire(Source.SERIAL, one.assembly.connector.clock())
        one.until(lambda: meaning.text() == f"Fired. {until_locked}")
        one.bench.module.state.is_active = False  # LOCK would end the trigger, too
        one.until(lambda: meaning.text() == "Fired. Find out why (Triggers), repack, restart.")
        one.bench.change(drop=1.0, direction="both")
        one.until(lambda: meaning.text() == f"Fired. {until_locked}")  # silent: it may be active by now
        one.bench.end_faults()
        one.bench.restart()
        one.until(lambda: meaning.text() == "In standby.")


def test_what_was_said_of_one_module_is_not_said_of_the_next(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, page="commands") as one, simulated("next"):
        row = one.commands.acts[Act.ZERO]
        one.until(row.confirm.ask.isEnabled)
        one.ask(row.confirm)
        one.click(row.confirm.go)
        one.until(lambda: (notice := row.said.notice) is not None and "Acknowledged" in notice.text)
        one.assembly.connector.connect_to(Target("sim://next", 115200))
        one.until(lambda: row.said.notice is None)
