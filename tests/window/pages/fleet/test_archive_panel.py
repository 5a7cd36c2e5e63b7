"""All modules ever seen: what is due of each, its history, a service, and the exchange with a file or a server."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.archive.archive import sync
from app.store.rows import SaidNew, Serviced, SettingsSeen, TriggerRecordSeen
from tests.files.records.test_filing import file_one
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import open_store
from tests.support.window.fakes_ui import page_entries, store_of, window
from ui.main import Assembly
from ui.pages.fleet.archive_panel import ArchivePanel
from ui.pages.fleet.page import FleetPage

WAIT_MS = int(PATIENCE_S * 1000)


@pytest.fixture
def assembly(qapp: QApplication, tmp_path: Path) -> Iterator[Assembly]:
    with window(qapp, tmp_path, entries=page_entries("fleet")) as assembly:
        yield assembly


def shown(qtbot: QtBot, assembly: Assembly) -> ArchivePanel:
    qtbot.waitUntil(lambda: "fleet" in assembly.window._pages, timeout=WAIT_MS)
    assembly.window.go_to("archive")
    page = assembly.window._pages["fleet"]
    assert isinstance(page, FleetPage)
    assert page.archive.isVisible()
    return page.archive


def test_a_file_brings_what_another_station_knows(qtbot: QtBot, assembly: Assembly, tmp_path: Path) -> None:
    stick = tmp_path / "all.dps-s"
    with closing(open_store(tmp_path / "other")) as store:
        file_one(store, "M-07", port="/dev/ttyUSB0")
        store.add(TriggerRecordSeen(place=0, raw="41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"), "M-07").result()
        sync(store, str(stick))
    store_of(assembly.storage).add(SaidNew(is_new=True), "M-01").result(PATIENCE_S)
    panel = shown(qtbot, assembly)
    panel.ask_file = lambda *given, **_options: given[-1](stick)
    qtbot.waitUntil(panel.carry.isEnabled, timeout=WAIT_MS)
    panel.carry.click()
    model = panel.modules.model()
    qtbot.waitUntil(lambda: model.rowCount() == 2, timeout=WAIT_MS)
    rows = [[model.index(row, column).data() for column in range(model.columnCount())] for row in range(2)]
    assert [row[0] for row in rows] == ["M-01", "M-07"]
    assert "READY" in rows[1][1]
    assert "Unjudged trigger records: 1." in rows[1][3]
    assert "Received: " in panel.state.text()
    panel.modules.selectRow(1)
    qtbot.waitUntil(lambda: panel.life.model().rowCount() > 2, timeout=WAIT_MS)


def test_a_service_is_kept_under_the_module_for_which_it_was_begun(qtbot: QtBot, assembly: Assembly) -> None:
    store = store_of(assembly.storage)
    for name in ("M-01", "M-02"):
        store.add(SaidNew(is_new=True), name).result(PATIENCE_S)
    panel = shown(qtbot, assembly)
    qtbot.waitUntil(lambda: panel.modules.model().rowCount() == 2, timeout=WAIT_MS)
    panel.modules.selectRow(1)
    panel.enter_service.click()
    assert "M-02" in panel.service.title.text()
    panel.service.who.setText("Li Wei")
    store.add(SaidNew(is_new=True), "M-00").result(PATIENCE_S)  # the table is read again meanwhile
    panel.service.save.click()
    kept = lambda: store.read(lambda facts: facts.of_module(Serviced, "M-02"))  # noqa: E731
    qtbot.waitUntil(lambda: len(kept()) == 1, timeout=WAIT_MS)
    assert (kept()[0].content.service, kept()[0].content.who) == ("repack", "Li Wei")
    qtbot.waitUntil(lambda: panel.modules.model().rowCount() == 3, timeout=WAIT_MS)
    assert [row.name for row in panel.modules.chosen()] == ["M-02"]


def test_a_server_that_is_away_is_said_without_the_password(qtbot: QtBot, assembly: Assembly) -> None:
    told: list[str] = []
    assembly.ports.notified.connect(told.append)
    panel = shown(qtbot, assembly)
    qtbot.waitUntil(panel.sync.isEnabled, timeout=WAIT_MS)
    panel.server.setText("postgresql://li:secret@127.0.0.1:1/x")
    panel.sync.click()
    assert panel.server.text() == "postgresql://li@127.0.0.1:1/x"
    qtbot.waitUntil(lambda: "cannot be used" in panel.state.text(), timeout=WAIT_MS)
    qtbot.waitUntil(lambda: any("cannot be used" in text for text in told), timeout=WAIT_MS)  # on every page
    assert "secret" not in panel.state.text() + "".join(told)
    assembly.window.close_now()
    files = [path for path in assembly.storage.folder.rglob("*") if path.is_file()]
    assert all(b"secret" not in path.read_bytes() for path in files)


def test_earlier_settings_are_compared_and_used_as_edits(qtbot: QtBot, assembly: Assembly) -> None:
    store = store_of(assembly.storage)
    for count, angle in ((4, 60), (5, 65)):
        seen = SettingsSeen(port="P", boot_count=count, settings={"attitude_threshold_deg": angle})
        store.add(seen, "M-07").result(PATIENCE_S)
    panel = shown(qtbot, assembly)
    qtbot.waitUntil(lambda: panel.life.model().rowCount() == 2, timeout=WAIT_MS)
    assert panel.settings.text().startswith("Choose an entry")
    assert not panel.use.isEnabled(), "none is chosen"
    panel.life.selectRow(1)
    assert not panel.use.isEnabled(), "no module answers"
    used: list[object] = []
    exchange = panel._services.exchange
    exchange.used.connect(used.append)
    exchange.can_use = lambda: True
    panel.life.selectAll()
    assert panel.settings.text() == "Attitude threshold 60° → 65°"
    assert not panel.use.isEnabled()
    panel.life.selectRow(1)
    panel.use.click()
    assert used == [{"attitude_threshold_deg": 60}]
