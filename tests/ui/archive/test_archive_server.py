"""The window and a PostgreSQL server: it exchanges by itself, and names what was altered there."""

from datetime import datetime
from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.archive.archive import Archive
from app.archive.server_url import store_server
from app.system.folders import data_folder
from tests.support.records.archive_server import archive_server, needs_server
from tests.support.records.archive_stations import archive_station
from tests.support.window.fakes_ui import window


@needs_server
def test_records_are_exchanged_by_themselves_and_what_was_altered_is_named(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, user_files: Path
) -> None:
    with (
        archive_server() as server,
        archive_station(data_folder()) as here,
        archive_station(tmp_path / "other") as other,
    ):
        here.act()
        other.check("M-07")
        Archive(other.store, other.facts, other.station).sync(server.url())
        store_server(data_folder(), server.url())
        with window(qapp, tmp_path) as assembly:
            exchange, line = assembly.archive.exchange, assembly.archive.line
            qtbot.waitUntil(line.isVisible)
            assert exchange.seen is not None
            assert exchange.seen.status.last_at is not None
            last = datetime.fromisoformat(exchange.seen.status.last_at).astimezone()
            assert line.text() in (f"Not shared: 0. Last: {last:%H:%M}.", f"Not shared: 0. Last: {last:%Y-%m-%d}.")
            assert here.ids() > other.ids()
            Archive(other.store, other.facts, other.station).sync(server.url())
            assert here.content() == other.content()
            server.run(
                "UPDATE dps_s_facts SET payload = replace(payload, 'GO', 'NO-GO') WHERE kind = 'preflight_check'"
            )
            exchange.sync()
            qtbot.waitUntil(lambda: not exchange.is_running)
            assert line.text() == "Left out, unreadable or altered: 1"
            exchange.refresh()  # as every minute: nothing new is known, so it stays
            qtbot.waitUntil(lambda: not exchange.is_running)
            assert line.text() == "Left out, unreadable or altered: 1"
            assert here.content() == other.content()
