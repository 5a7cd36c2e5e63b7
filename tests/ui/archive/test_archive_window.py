"""The archive in the window: what is due of each module, its history, and the exchange with a file or a server."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.archive.archive import Archive
from app.archive.sync import sync
from app.store.kinds import SaidNew, TriggerRecordSeen
from tests.app.records.test_filing import file_one
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import open_store
from tests.support.window.fakes_ui import store_of, window
from tests.support.window.steps import given
from ui.archive.archive_dialog import ArchiveDialog

WAIT_MS = int(PATIENCE_S * 1000)


def shown(assembly: object) -> ArchiveDialog:
    archive = assembly.archive  # type: ignore[attr-defined]
    archive.show()
    dialog: ArchiveDialog = given(archive.dialog)
    return dialog


def stick_of_another(tmp_path: Path) -> Path:
    stick = tmp_path / "all.dps-s"
    store = open_store(tmp_path / "other")
    file_one(store, "M-07", port="/dev/ttyUSB0")
    store.add(TriggerRecordSeen(place=0, raw="41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"), "M-07").result()
    sync(Archive(store), str(stick))
    store.close()
    return stick


def test_a_file_brings_what_another_station_knows(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    stick = stick_of_another(tmp_path)
    with window(qapp, tmp_path, entries=()) as assembly:
        store_of(assembly.storage).add(SaidNew(is_new=True), "M-01").result(PATIENCE_S)
        dialog = shown(assembly)
        dialog.ask_file = lambda _parent, then: then(stick)
        qtbot.waitUntil(dialog.carry.isEnabled, timeout=WAIT_MS)
        dialog.carry.click()
        model = dialog.modules.model()
        qtbot.waitUntil(lambda: model.rowCount() == 2, timeout=WAIT_MS)
        rows = [[model.index(row, column).data() for column in range(model.columnCount())] for row in range(2)]
        assert [row[0] for row in rows] == ["M-01", "M-07"]
        assert "READY" in rows[1][1]
        assert "Unjudged trigger records: 1." in rows[1][3]
        assert "Received: " in dialog.state.text()
        dialog.modules.selectRow(1)
        qtbot.waitUntil(lambda: dialog.life.model().rowCount() > 2, timeout=WAIT_MS)
        store_of(assembly.storage).add(SaidNew(is_new=True), "M-00").result(PATIENCE_S)
        dialog.bring_up()
        qtbot.waitUntil(lambda: model.rowCount() == 3, timeout=WAIT_MS)
        assert [row.name for row in dialog.modules.chosen()] == ["M-07"]


def test_a_server_that_is_away_is_said_without_the_password(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=()) as assembly:
        dialog = shown(assembly)
        qtbot.waitUntil(dialog.sync.isEnabled, timeout=WAIT_MS)
        dialog.server.setText("postgresql://li:secret@127.0.0.1:1/x")
        dialog.sync.click()
        assert dialog.server.text() == "postgresql://li@127.0.0.1:1/x"
        qtbot.waitUntil(lambda: "cannot be used" in dialog.state.text(), timeout=WAIT_MS)
        assert "secret" not in dialog.state.text()
        line = assembly.archive.line
        assert not line.isHidden()
        assert "secret" not in line.toolTip() + line.text()
    files = [path for path in assembly.storage.folder.rglob("*") if path.is_file()]  # none comes and goes any more
    assert all(b"secret" not in path.read_bytes() for path in files)


def test_without_a_server_nothing_is_shown(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=()) as assembly:
        qtbot.wait(100)
        assert assembly.archive.line.isHidden()
