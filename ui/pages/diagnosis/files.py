"""Files of the Diagnosis page: traffic, opened from a session or from hex text; the support bundle."""

import copy
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QLabel, QListWidget, QListWidgetItem, QPlainTextEdit, QPushButton, QWidget

from app import version
from app.captures.explained import Explained, Explainer
from app.captures.rows import CaptureRows
from app.captures.text import NOT_HEX, LineFault, NotHex, TextReader, lines_in
from app.captures.traffic_buffer import TrafficBuffer
from app.diagnosis.link_statistics import LinkStatistics
from app.diagnosis.support_bundle import BundleFile, Contents, SupportBundle
from app.recordings.entry_texts import size_text
from app.system.gil_yield import GilYield
from app.system.logs import text_of
from app.text import i18n
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import error_text
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, ExportCancelled, Running
from ui.files.file_dialogs import AskOpen, AskPath, ThenPath, ask_open, ask_path, default_name
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, fixed_font, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import TickingLabel
from ui.widgets.layouts import FlowRow, in_column, in_row
from ui.widgets.visibility_timer import VisibilityTimer

SUFFIX = ".mcap"
OPENED_SUFFIXES = (".hex", ".txt", ".log", SUFFIX)


def ask_capture(parent: QWidget, folder: Path, then: ThenPath) -> None:
    ask_open(parent, folder, tr("Open traffic…"), "*.mcap *.txt *.hex *.log", then)


class Opened(NamedTuple):
    path: Path
    rows: CaptureRows
    statistics: LinkStatistics
    faults: tuple[LineFault, ...]
    damage: UserMessage | None
    is_timed: bool


def load_capture(path: Path, running: Running) -> Opened:
    """Reads and explains a file. Raises OSError, `NotHex`, `UserError` or `ExportCancelled`."""
    rows, statistics, pace, text = CaptureRows(), LinkStatistics(), GilYield(), TextReader()
    is_session = path.suffix.lower() == SUFFIX
    with ExitStack() as stack:
        if is_session:
            from app.recordings.recording import RecordedTraffic

            explainer: Explainer | TextReader = (session := Explainer())
            steps = map(session.feed, traffic := RecordedTraffic(path))
        else:
            explainer = text
            file = stack.enter_context(path.open(encoding="utf-8", errors="replace"))
            steps = map(text.feed, lines_in(file))

        def explained() -> Iterator[Explained]:
            for some in steps:
                if running.is_cancelled():
                    raise ExportCancelled
                yield from some
                pace.checkpoint()
            yield from explainer.end()

        statistics.count(map(rows.append, explained()))
    damage = traffic.damage if is_session else None
    return Opened(path, rows, statistics, tuple(text.faults), damage, is_timed=is_session or text.is_timed)


class CaptureFiles(QWidget):
    """The button that opens a capture. `opened`: an `Opened`."""

    opened = Signal(object)

    def __init__(self, services: Services, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("capture_files")
        self.ask_open: AskOpen = ask_capture
        self._result = result
        self._folder = Path.home()
        texts = services.texts
        self.open = control(QPushButton(), texts, "capture_open", "Open traffic…", keys="Ctrl+O", picture=Icon.FOLDER,
                            slot=self.choose)  # fmt: skip
        in_row(self.open, of=self, spacing=Space.S, margins=0)

    def choose(self) -> None:
        self.ask_open(self, self._folder, self.open_file)

    def open_file(self, path: Path) -> None:
        self._folder = path.parent
        load = partial(load_capture, path)
        self._result.begin(lambda: path.name, load, self._show, partial(_refusal, path), writes=False)

    def _show(self, opened: Opened) -> None:
        if not opened.rows:
            self._result.notify(Meaning.ATTENTION, lambda: _why_nothing(opened))
            return
        self.opened.emit(opened)


def _why_nothing(opened: Opened) -> str:
    if opened.faults:
        return tr("{file} cannot be read: {why}.", file=opened.path.name, why=tr(opened.faults[0].text))
    return tr("{name} is empty.", name=opened.path.name)


def _refusal(path: Path, error: Exception) -> str:
    why = tr(NOT_HEX) if isinstance(error, NotHex) else error_text(error)
    return tr("{file} cannot be read: {why}.", file=path.name, why=why)


_PART_WORDS: Final = {
    "about.json": marked("Program"),
    "link.json": marked("Statistics"),
    "module.json": marked("Module"),
    "preferences.json": marked("Preferences"),
    "log.txt": marked("Log"),
    "capture.txt": marked("Traffic"),
}
_PARTS_PX: Final = 232


class BundlePreview(QWidget):
    """Makes the bundle each time it is shown."""

    def __init__(self, services: Services, traffic: TrafficBuffer, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("bundle_preview")
        self.ask_path: AskPath = ask_path
        self._connector, self._appearance = services.connector, services.appearance
        self._traffic, self._log, self._result = traffic, services.log, result
        self.bundle: SupportBundle | None = None
        self._making: BackgroundTask[SupportBundle] = BackgroundTask("dps-s support bundle", self)
        self._folder = Path.home()
        texts = services.texts
        self._privacy_note = control(
            QLabel(),
            texts,
            "bundle_promise",
            "The names of the user and the computer are replaced. Names of modules, files and ports, serial numbers "
            "and addresses stay: read everything before you pass it on. Nothing is sent.",
        )
        self._privacy_note.setWordWrap(True)
        self.parts = control(QListWidget(), texts, "bundle_parts", says="Files")
        self.parts.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.parts.setStyleSheet("QListWidget::item { padding: 6px 8px; }")
        self.parts.currentRowChanged.connect(self._show_part)
        self.text = control(QPlainTextEdit(), texts, "bundle_text", says="Contents")
        self.text.setReadOnly(True)
        self.text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.text.setTabChangesFocus(True)
        self.text.document().setDocumentMargin(Space.S)
        self.save = control(QPushButton(), texts, "bundle_save", "Save support bundle…",
                            picture=Icon.BUNDLE, role="primary", slot=self.choose_and_save)  # fmt: skip
        self.renew = control(QPushButton(), texts, "bundle_renew", "Refresh", picture=Icon.AGAIN,
                             slot=self.make)  # fmt: skip
        self._where = named(TickingLabel(), "bundle_log_path", "small")
        self._where.hide()
        self._lay_out()
        self._timer = VisibilityTimer(self, self.make, retranslate=self._retranslate, restyle=self._apply_theme)
        self._apply_theme()

    def begin_again(self) -> None:
        """What is shown, or still being made, is of the former module."""
        self._making.cancel()
        self.bundle = None
        self.text.clear()
        self._timer.refresh_seen()

    def make(self) -> None:
        """Makes the bundle in the background from the present state."""
        log, contents = self._log, self._contents()
        self.save.setEnabled(False)

        def pack(_running: Running) -> SupportBundle:
            return SupportBundle(contents if log is None else replace(contents, log=text_of(log)))

        self._making.run(pack, self._show, self._notify_failure)

    def _contents(self) -> Contents:
        """Copies what belongs to the window's thread; without the log."""
        connection = self._connector.current.connection
        return Contents(
            version=version(),
            connection=connection,
            device=self._connector.current.device,
            now=self._connector.clock(),
            statistics=copy.copy(self._connector.current.kept.statistics),
            preferences={"language": i18n.language(), "theme": self._appearance.choice.value},
            capture=self._traffic.entries(),
            capture_started_at=self._traffic.started_at(),
        )

    def choose_and_save(self) -> None:
        """Saves the bundle that is shown."""
        bundle = self.bundle
        if bundle is None or self._result.is_writing:
            return
        name = default_name("support", ".zip", datetime.now().astimezone())
        save = partial(self._save_to, bundle)
        self.ask_path(self, tr("Save support bundle…"), self._folder / name, "*.zip", save)

    def _save_to(self, bundle: SupportBundle, path: Path) -> None:
        self._folder = path.parent
        self._result.write_file(path, partial(bundle.write, path))

    def _show(self, bundle: SupportBundle) -> None:
        self.bundle = bundle
        self.save.setEnabled(True)
        row = max(0, self.parts.currentRow())
        with QSignalBlocker(self.parts):
            self.parts.clear()
            for part in bundle.files:
                item = QListWidgetItem(_title(part))
                item.setData(Qt.ItemDataRole.AccessibleTextRole, _title(part))
                item.setToolTip(part.name)
                self.parts.addItem(item)
            self.parts.setCurrentRow(min(row, self.parts.count() - 1))
        self._show_part(self.parts.currentRow())
        self._show_where()

    def _show_part(self, row: int) -> None:
        parts = self.bundle.files if self.bundle is not None else ()
        self.text.setPlainText(parts[row].text if 0 <= row < len(parts) else "")

    def _show_where(self) -> None:
        where = None if self._log is None else self._log.trouble or self._log.path
        self._where.setText("" if where is None else tr("Log file: {path}", path=where))
        self._where.setHidden(where is None)
        if where is not None:  # an empty label must not take the focus
            self._where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)

    def _notify_failure(self, error: Exception) -> None:
        self._result.notify(Meaning.ATTENTION, lambda: tr("Failed: {why}.", why=error_text(error)))

    # Making

    def _lay_out(self) -> None:
        body = in_row(self.parts, (self.text, 1), spacing=Space.S)
        buttons = FlowRow(right=(self.renew, self.save))
        head = in_row((self._privacy_note, 1), (buttons, 1), spacing=Space.S)
        in_column(head, (body, 1), self._where, of=self, spacing=Space.S, margins=(Space.M, Space.S))

    def _apply_theme(self) -> None:
        self.text.setFont(fixed_font(Size.SMALL))
        self.parts.setFixedWidth(scaled(_PARTS_PX))

    def _retranslate(self) -> None:
        if self.bundle is not None:
            self._show(self.bundle)


def _title(part: BundleFile) -> str:
    words = tr(_PART_WORDS[part.name]) if part.name in _PART_WORDS else part.name
    return f"{words} · {size_text(part.size_bytes)}"
