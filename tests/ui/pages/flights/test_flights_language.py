"""What the Flight logs page says of a file follows the language."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.flights.many_flights import write_csv, write_logs
from tests.support.window.fakes_ui import WAIT_MS
from tests.ui.pages.flights.test_flights_page import MUST_NOT, opened, tilted


def test_columns_that_are_missing(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as desk:
        write_logs(tmp_path / "logs")
        desk.page.open_paths([tmp_path / "logs"])
        desk.wait_read()
        choose = desk.page.strip.button("columns")
        assert choose is not None
        choose.click()
        desk.page.form.read.click()
        assert desk.page.form.fault.text() == "Choose a column in each row."
        desk.assembly.language_switch.use("zh_CN")
        assert desk.page.form.fault.text() == "请在每一行选择一列。"


def test_a_log_that_is_gone(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as desk:
        path = write_csv(tmp_path / "gone.csv", tilted("", 20))
        desk.page.open_paths([path])
        desk.wait_read()
        path.unlink()
        desk.page.open_flight(desk.page.lists.of[MUST_NOT].filter.row_at(0))
        waiting = desk.page.flight.waiting
        qtbot.waitUntil(lambda: "No such file" in waiting.text(), timeout=WAIT_MS)
        desk.assembly.language_switch.use("zh_CN")
        assert "不得触发" in waiting.text()
