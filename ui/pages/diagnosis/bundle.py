"""The support bundle of the Diagnosis page: what is in it, shown before it is saved."""

import copy
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QPlainTextEdit, QPushButton, QWidget

from app import version
from app.diagnosis.support_bundle import Contents, SupportBundle
from app.text import i18n
from app.text.i18n import tr
from app.text.sentences import error_text
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.pages.diagnosis.traffic import TrafficModel
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, fixed_font
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.visibility_timer import VisibilityTimer


class BundlePreview(QWidget):
    """Makes the bundle each time it is shown."""

    def __init__(self, services: Services, traffic: TrafficModel, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("bundle_preview")
        self.ask_path: AskPath = ask_path
        self._ports, self._appearance = services.ports, services.appearance
        self._traffic, self._log, self._result = traffic, services.log, result
        self.bundle: SupportBundle | None = None
        self._making: BackgroundTask[SupportBundle] = BackgroundTask("dps-s support bundle", self)
        self._folder = Path.home()
        promise = text_label("bundle_promise")
        promise.setText(
            tr(
                "The names of the user and the computer are replaced. Names of modules, files and ports, serial "
                "numbers and addresses stay: read everything before you pass it on. Nothing is sent."
            )
        )
        self.text = control(QPlainTextEdit(), "bundle_text", says=tr("Contents"))
        self.text.setReadOnly(True)
        self.text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.text.setTabChangesFocus(True)
        self.text.setFont(fixed_font(Size.SMALL))
        self.save = control(
            QPushButton(tr("Save support bundle…")),
            "bundle_save",
            picture=Icon.BUNDLE,
            role="primary",
            slot=self.choose_and_save,
        )
        self.renew = control(QPushButton(tr("Refresh")), "bundle_renew", picture=Icon.AGAIN, slot=self.make)
        self._where = text_label("bundle_log_path", "small", is_selectable=True)
        self._where.setVisible(self._log is not None)
        buttons = in_row(1, self.renew, self.save, spacing=Space.S)
        in_column(promise, buttons, (self.text, 1), self._where, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        self._timer = VisibilityTimer(self, self.make)

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
            return SupportBundle(contents if log is None else replace(contents, log=log.text()))

        self._making.run(pack, self._show, self._notify_failure)

    def _contents(self) -> Contents:
        """Copies what belongs to the window's thread; without the log."""
        return Contents(
            version=version(),
            connection=self._ports.current.connection,
            conversation=self._ports.module.view,
            now=self._ports.clock(),
            statistics=copy.copy(self._ports.module.statistics),
            preferences={"language": i18n.language(), "theme": self._appearance.choice.value},
            traffic=self._traffic.events,
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
        self.text.setPlainText("\n".join(f"——— {part.name} ———\n{part.text}" for part in bundle.files))
        if self._log is not None:
            self._where.setText(tr("Log file: {path}", path=self._log.trouble or self._log.path))

    def _notify_failure(self, error: Exception) -> None:
        self._result.notify(Meaning.ATTENTION, tr("Failed: {why}.", why=error_text(error)))
