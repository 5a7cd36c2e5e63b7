"""The archive in the window: quiet by itself, through a file by hand, questions answered by a person."""

from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from threading import Event
from unittest.mock import patch

import pytest
from PySide6.QtCore import QDate, Qt
from PySide6.QtWidgets import QApplication, QTableView
from pytestqt.qtbot import QtBot

from app.archive.archive import Archive
from app.archive.exchange import ArchiveStatus, Exchanged, export_facts, import_facts, sync
from app.archive.module_history import module_history
from app.archive.module_names import ConflictKind, names_of
from app.archive.server_url import store_server
from app.limits.service import ServiceKind
from app.safety.acts import Act
from app.settings.form import RowState
from app.store.store import Store
from app.system.folders import data_folder
from tests.support.patience import PATIENCE_S
from tests.support.processes import ran_code
from tests.support.records.archive_server import archive_server
from tests.support.records.archive_stations import ArchiveStation, archive_station
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import window
from tests.support.window.settings_bench import Desk, desk, state, type_into, write
from tests.support.window.steps import choosing, given, press
from ui.archive import archive_exchange
from ui.archive.archive_dialog import ArchiveDialog, Loaded
from ui.archive.archive_exchange import AT_LEAST_EVERY_S
from ui.archive.service_form import ServiceForm
from ui.main import Assembly
from ui.style.theme import Choice
from ui.widgets.gestures import gestures

pytestmark = pytest.mark.qt_log_ignore("does not support", extend=True)
NOWHERE = "postgresql://li:secret@/x?host=/nowhere/at/all"


@pytest.fixture
def here(user_files: Path) -> Iterator[ArchiveStation]:
    with archive_station(data_folder()) as one:
        yield one


@pytest.fixture
def stick(tmp_path: Path) -> Path:
    """With what another station recorded: a module by the same name, a check that is NO-GO."""
    path = tmp_path / "stick.dpsarchive"
    with archive_station(tmp_path / "other") as other:
        other.check("M-07", "NO-GO")
        export_facts(other.archive, path)
    return path


def _dialog(qtbot: QtBot, assembly: Assembly) -> ArchiveDialog:
    archive = assembly.archive
    qtbot.waitUntil(lambda: assembly.window._maker.is_done)
    assembly.window.menus["archive"].trigger()
    assert archive.dialog is not None
    _wait(qtbot, archive.dialog)
    return archive.dialog


def _wait(qtbot: QtBot, dialog: ArchiveDialog) -> None:
    """Until nothing is read or exchanged any more."""

    def is_idle() -> bool:
        return not (dialog._exchange.is_running or dialog._loading.is_running or dialog._loading_history.is_running)

    qtbot.waitUntil(is_idle)


def test_without_a_server_nothing_is_shown_and_a_file_carries_everything(
    here: ArchiveStation, stick: Path, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    here.check("M-07")
    here.visit("M-07", 1)
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        assert not assembly.archive.line.isVisible()
        assert not dialog.sync.isEnabled()
        assert [row.module.name for row in dialog.modules.source.rows] == ["M-07"]
        assert "Pre-flight check 1: GO" in " ".join(row.text.translated() for row in dialog.life.source.rows)
        dialog.ask_open = choosing(stick)
        dialog.import_.click()
        _wait(qtbot, dialog)
        assert "Received: 2." in dialog.state.text()
        assert [row.module.name for row in dialog.modules.source.rows] == ["M-07", "M-07"]
        assert dialog.question.isVisible()
        assert "is it the same module?" in dialog.asked.text()
        assert not dialog.same.isEnabled()  # nobody has said yet who decides
        dialog.who.setText("Li")
        press(qtbot, dialog.same)
        _wait(qtbot, dialog)
        assert not dialog.question.isVisible()
        (module,) = dialog.modules.source.rows
        assert (module.checks, len(module.module.members)) == (2, 2)
        dialog.ask_save = choosing(stick)
        dialog.export.click()
        _wait(qtbot, dialog)
        assert "Sent: 5." in dialog.state.text()
        stick.write_text(stick.read_text(encoding="utf-8").replace("NO-GO", "GO"), encoding="utf-8")
        dialog.import_.click()
        _wait(qtbot, dialog)
        assert "Left out, unreadable or altered: 1." in dialog.state.text()


def test_a_double_click_on_an_answer_does_not_answer_the_next_question(
    here: ArchiveStation, stick: Path, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    for name in ("M-07", "M-08"):
        here.check(name)
    with archive_station(tmp_path / "third") as third:
        third.check("M-08")
        export_facts(third.archive, stick)
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        dialog.ask_open = choosing(stick)
        dialog.import_.click()
        _wait(qtbot, dialog)
        dialog.who.setText("Li")
        first = dialog.asked.text()
        assembly.appearance.choose(Choice.SUNLIGHT)
        assembly.appearance.zoom(200)
        assert [fault for fault in cut_off(dialog) if not fault.startswith("archive_server")] == []
        assembly.appearance.zoom(100)
        press(qtbot, dialog.same)
        second = dialog.asked.text()
        assert second != first  # at once, so that the first one is not answered twice
        _wait(qtbot, dialog)
        with patch.object(gestures(), "clock", lambda: dialog.same.appeared_at):  # at once, however busy the machine is
            qtbot.mouseDClick(dialog.same, Qt.MouseButton.LeftButton)
            qtbot.mouseRelease(dialog.same, Qt.MouseButton.LeftButton)
            dialog.same.click()
        assert not dialog._exchange.is_running
        assert dialog.asked.text() == second
        qtbot.waitUntil(lambda: dialog.different.is_live)
        dialog._show(Loaded(tuple(dialog.modules.source.rows), dialog._conflicts))
        assert dialog.different.is_live
        other = dialog._conflicts[0]._replace(kind=ConflictKind.CONTRADICTION)
        dialog._show(Loaded(tuple(dialog.modules.source.rows), (other, *dialog._conflicts)))
        assert not dialog.different.is_live  # another question came under the hand
        press(qtbot, dialog.different)
        _wait(qtbot, dialog)
        assert sorted(len(row.module.members) for row in dialog.modules.source.rows) == [1, 1, 2]


def test_to_look_at_the_archive_again_ends_neither_what_is_imported_nor_what_is_typed(
    here: ArchiveStation, stick: Path, qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_go_on = Event(), Event()

    def held(archive: Archive, path: Path, *, on_page: Callable[[Exchanged], None]) -> Exchanged:
        begun.set()
        assert may_go_on.wait(PATIENCE_S)
        on_page(Exchanged())
        return import_facts(archive, path, on_page=on_page)

    monkeypatch.setattr("ui.archive.archive_dialog.import_facts", held)
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        dialog.ask_open = choosing(stick)
        dialog.import_.click()
        assert begun.wait(PATIENCE_S)
        qtbot.keyClicks(dialog.server, "postgresql://li@")
        assembly.window.menus["archive"].trigger()
        may_go_on.set()
        _wait(qtbot, dialog)
        assert "Received: 2." in dialog.state.text()
        assert dialog.server.text() == "postgresql://li@"


def test_a_service_that_is_entered_while_a_file_is_written_waits_for_it(
    here: ArchiveStation, qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_go_on, target = Event(), Event(), tmp_path / "out.dpsarchive"
    here.meet("M-07")

    def held(archive: Archive, path: Path, *, on_page: Callable[[Exchanged], None]) -> Exchanged:
        begun.set()
        assert may_go_on.wait(PATIENCE_S)
        return export_facts(archive, path, on_page=on_page)

    monkeypatch.setattr("ui.archive.archive_dialog.export_facts", held)
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        qtbot.waitUntil(dialog.service.isEnabled)
        dialog.service.click()
        form = dialog.findChildren(ServiceForm)[0]
        dialog.ask_save = choosing(target)
        dialog.export.click()
        assert begun.wait(PATIENCE_S)
        form.accept()
        may_go_on.set()
        qtbot.waitUntil(lambda: "Repack on" in _texts(dialog.life))
        assert target.exists()


def test_an_empty_archive_says_what_fills_it(
    here: ArchiveStation, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        assert dialog.empty.isVisible()
        assert dialog.empty.text.text() == "Each check or test adds its module."
        here.check("M-07")
        dialog.bring_up()
        _wait(qtbot, dialog)
        assert dialog.modules.isVisible()
        assert not dialog.empty.isVisible()


def test_a_server_that_is_away_is_a_quiet_line_and_its_password_is_kept_nowhere(
    here: ArchiveStation, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    here.act()
    store_server(data_folder(), NOWHERE)
    with window(qapp, tmp_path) as assembly:
        line = assembly.archive.line
        qtbot.waitUntil(line.isVisible)
        assert line.text() == "Not shared: 2. Last: never."
        assert "postgresql://li@/x" in line.toolTip()
        dialog = _dialog(qtbot, assembly)
        dialog.server.setText(NOWHERE)
        dialog.use.click()
        assert dialog.server.text() == "postgresql://li@/x?host=%2Fnowhere%2Fat%2Fall"
        _wait(qtbot, dialog)
        assert "cannot be used" in dialog.state.text()
        for wrong in ("mysql://li:secret@db/x", "postgresql://li:se/cret@db/x"):
            dialog.server.setText(wrong)
            dialog.use.click()
            assert "Write " in dialog.state.text()
        dialog.server.setText("")
        dialog.use.click()
        _wait(qtbot, dialog)
        assert not line.isVisible()
    files = [path for path in (*data_folder().rglob("*"), *tmp_path.rglob("*")) if path.is_file()]
    assert all(b"secret" not in path.read_bytes() for path in files)


def test_an_exchange_that_runs_by_itself_shows_what_was_altered_on_the_server(
    here: ArchiveStation, qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here.act()
    monkeypatch.setattr("app.archive.exchange.sync", lambda *_args, **_more: Exchanged(refused_count=2))
    store_server(data_folder(), NOWHERE)
    with window(qapp, tmp_path) as assembly:
        line = assembly.archive.line
        qtbot.waitUntil(line.isVisible)
        assert line.text() == "Left out, unreadable or altered: 2"


def test_no_start_loads_what_only_a_server_needs() -> None:
    """Nor the source text of what it loads: 20 MB."""
    program = """if True:
        import importlib, linecache, sys, ui.main
        for page in ui.main.PAGES:
            importlib.import_module(f"ui.pages.{page.key}.page")
        print(*sys.modules)
        print(*(name for name in linecache.cache if "pyqtgraph" in name or "numpy" in name))
    """
    modules, texts = ran_code(program).stdout.splitlines()
    loaded = set(modules.split())
    assert texts == ""
    assert "ui.archive.archive_actions" in loaded
    assert not loaded & {
        "psycopg",
        "keyring",
        "app.archive.postgres",
        "app.archive.archive",
        "ui.archive.archive_dialog",
    }


def test_acts_and_settings_are_in_the_history_of_the_module_of_that_name(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", "commands") as one:
        naming = one.assembly.connector.current.module
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
        told = _told(one.assembly.storage.store)
    assert list(told) == ["M-07"]  # nothing was stored of the other one
    named, settings, *acts = told["M-07"]
    assert named == "Named M-07."
    assert "Free-fall time 1.60 s" in settings  # as it was found, before the write
    assert acts == ["Free-fall time 1.20 s: confirmed.", "Zero the sensor: confirmed."]


def _lock(one: Desk) -> None:
    lock, before = one.assembly.connector.current.lock, len(one.changes("activation"))
    lock.press()
    one.until(lambda: len(one.changes("activation")) > before and not lock.is_repeating)


def _told(store: object) -> dict[str, list[str]]:
    """The history of every module in English, as the archive of this computer has it."""
    assert isinstance(store, Store)
    with closing(Archive(store)) as archive:
        archive.collect()
        return {
            module.name: [event.text.in_english() for event in module_history(archive, module).events]
            for module in names_of(archive).modules
        }


def test_what_was_done_to_a_module_is_entered_in_a_form_and_is_due_again(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, here: ArchiveStation
) -> None:
    here.meet("M-07")
    with window(qapp, tmp_path) as assembly:
        dialog = _dialog(qtbot, assembly)
        qtbot.waitUntil(dialog.service.isEnabled)
        dialog.service.click()
        form = dialog.findChildren(ServiceForm)[0]
        assert form.is_due.isChecked()
        form.who.setText("Li Wei")
        form.kind.setCurrentIndex(form.kind.findData(ServiceKind.CELL))
        form.due.setDate(QDate.currentDate().addDays(12))
        form.accept()
        _wait(qtbot, dialog)
        qtbot.waitUntil(lambda: "Cell due on" in _texts(dialog.modules))
        assert "days left: 12" in _texts(dialog.modules)
        assert "Cell on" in _texts(dialog.life)


def _texts(table: QTableView) -> str:
    model = table.model()
    cells = (model.index(row, column) for row in range(model.rowCount()) for column in range(model.columnCount()))
    return "\n".join(str(cell.data()) for cell in cells)


# With a server


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
        sync(other.archive, server.url())
        store_server(data_folder(), server.url())
        with window(qapp, tmp_path) as assembly:
            exchange, line = assembly.archive.exchange, assembly.archive.line
            qtbot.waitUntil(line.isVisible)
            assert exchange.seen is not None
            last = datetime.fromisoformat(given(exchange.seen.status.last_at)).astimezone()
            assert line.text() in (f"Not shared: 0. Last: {last:%H:%M}.", f"Not shared: 0. Last: {last:%Y-%m-%d}.")
            assert here.ids() > other.ids()
            sync(other.archive, server.url())
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


@pytest.mark.parametrize(
    ("ago_s", "is_due"),
    [(AT_LEAST_EVERY_S - 10, False), (AT_LEAST_EVERY_S + 10, True), (-60, True)],
    ids=["just now", "long ago", "clock put back"],
)
def test_without_news_an_exchange_is_due_again_after_a_while(
    monkeypatch: pytest.MonkeyPatch, ago_s: float, is_due: bool
) -> None:
    at = datetime.now(UTC) - timedelta(seconds=ago_s)
    status = ArchiveStatus(stations={}, place=None, not_shared=0, last_at=at.isoformat(), conflicts=0)
    monkeypatch.setattr("app.archive.exchange.status_of", lambda *_: status)
    assert archive_exchange._is_due(None, "") is is_due  # type: ignore[arg-type]
