"""Settings page: module value, edited value, write and verify.

The rows scroll; what is said and the buttons below stay in sight.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import (
    QFrame,
    QPushButton,
    QScrollArea,
    QStackedLayout,
    QWidget,
)

from app.settings.form import FORM_COMMANDS, RowState
from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.sentences import together
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.pages.settings.baud_panel import BaudPanel
from ui.pages.settings.calibration_panel import CalibrationPanel
from ui.pages.settings.controller import SettingsController
from ui.pages.settings.fingerprint_view import FingerprintView
from ui.pages.settings.profile_compare import ProfileCompare
from ui.pages.settings.profile_files import SUFFIX, ProfileFiles
from ui.pages.settings.row import SettingsRow
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import Shortcut, control
from ui.widgets.layouts import FlowRow, in_column, in_row
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 250


class SettingsPage(Page):
    """See the module's docstring."""

    suffixes = (SUFFIX,)

    def __init__(self, services: Services, parent: QWidget | None = None) -> None:
        super().__init__("settings", parent)
        self._services, self._connector = services, services.connector
        texts = services.texts
        self._guard = WheelGuard(self)
        self.work = SettingsController(services, self)
        self.rows = {command.key: SettingsRow(command, texts, self._guard) for command in FORM_COMMANDS}
        self.baud = BaudPanel(services, self._guard)
        self.files = ProfileFiles(services)
        self.compare = ProfileCompare(texts)
        self.calibration = CalibrationPanel(services)
        self.strip = NoticeBar(texts)
        self.strip.setObjectName("settings_notice")
        policy = self.strip.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.strip.setSizePolicy(policy)
        self.strip.setMinimumHeight(44)
        self.fingerprint = FingerprintView()
        self._make_buttons()
        self._stack = QStackedLayout(self)
        self._form = self._lay_out()
        for view in (self._form, self.compare, self.calibration):
            self._stack.addWidget(view)
        self._wire()
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        self.refresh()

    def open_file(self, path: Path) -> None:
        """A profile, dropped on the window or chosen elsewhere."""
        self.files.open_file(path)

    def refresh(self) -> None:
        """Everything as it is now."""
        work, device, now = self.work, self._connector.device, self._connector.clock()
        form = work.form
        for row in form.rows(device, now):
            self.rows[row.command.key].show_row(row, now, is_editable=work.can_edit)
        count = len(form.changes(device, now))
        self.write.setText(tr("Write {count} changes", count=count) if count != 1 else tr("Write 1 change"))
        has_unfit = form.count_unsent(device, now) > count
        self.write.setEnabled(work.can_write and count > 0 and not has_unfit)
        self.read.setEnabled(work.job.can_run)
        self.revert.setEnabled(work.can_edit and form.has_drafts)
        self.defaults.setEnabled(work.can_edit)
        self.as_found.setEnabled(work.can_edit and work.found is not None)
        self.undo.setEnabled(work.can_edit and form.can_undo)
        self.redo.setEnabled(work.can_edit and form.can_redo)
        self.strip.show_notice(work.notice() or self._idle_notice())
        self.fingerprint.show_device(device, now)
        self.files.refresh()
        self.compare.refresh(device, now, can_apply=work.can_write and work.can_edit)
        self.baud.refresh()
        self.calibration.refresh()

    def _idle_notice(self) -> Notice | None:
        if self._connector.is_wanted:
            now = self._connector.clock()
            invalid = [row for row in self.work.form.rows(self._connector.device, now) if row.state is RowState.UNFIT]
            said = [tr("{setting}: {why}.", setting=tr(row.command.title), why=row.reason) for row in invalid]
            if self._connector.is_open and not self.work.job.is_running and not self.work.can_write:
                is_there = self._connector.device.presence is Presence.ONLINE
                said.append(
                    tr("Checking whether it is the same module…") if is_there else tr("The module does not answer.")
                )
            return Notice(Meaning.ATTENTION, together(said)) if said else None
        return Notice(Meaning.INFORMATION, tr("Connect a module to see and change its settings."))

    # What a person does

    def _write(self) -> None:
        self.work.write()

    def show_form(self) -> None:
        self._stack.setCurrentWidget(self._form)
        self.refresh()

    def _show_profile(self, profile: Profile, path: Path) -> None:
        self.compare.show_profile(profile, path)
        self._stack.setCurrentWidget(self.compare)
        self.refresh()

    def _show_faults(self, path: Path, sentences: tuple[str, ...]) -> None:
        self.compare.show_faults(path, sentences)
        self._stack.setCurrentWidget(self.compare)
        self.refresh()

    def _apply_profile(self, values: dict[str, Value]) -> None:
        self.show_form()
        self.work.edit(partial(self.work.form.fill, values))
        self.work.write()

    def _measure(self) -> None:
        self.calibration.begin()
        self._stack.setCurrentWidget(self.calibration)
        self.refresh()

    def _take_threshold(self, threshold_v: float) -> None:
        self.work.edit(partial(self.work.form.choose, "light_threshold_v", threshold_v))
        self.show_form()

    def _try_out(self) -> None:
        self._services.exchange.tried.emit(self.work.form.wanted)
        self.page_wanted.emit("live")

    def _take_drafts(self, values: Mapping[str, Value]) -> None:
        """What was tried on recorded data."""
        self.show_form()
        self.work.edit(partial(self.work.form.fill, values))

    # Making

    def _make_buttons(self) -> None:
        texts = self._services.texts
        self.write = control(QPushButton(), texts, "settings_write", says="Write the changes",
                             tip="Write the changes to the module and verify them", key="Ctrl+Return",
                             picture=Icon.DROP, role="primary", slot=self._write)  # fmt: skip
        self.read = control(QPushButton(), texts, "settings_read", "Read all", tip="Ask the module for everything",
                            key="F5", picture=Icon.AGAIN)  # fmt: skip
        self.undo = control(QPushButton(), texts, "settings_undo", says="Undo", tip="Undo",
                            key="Ctrl+Z", picture=Icon.UNDO)  # fmt: skip
        self.redo = control(
            QPushButton(), texts, "settings_redo", says="Redo", tip="Redo", key="Ctrl+Shift+Z", picture=Icon.REDO
        )
        self.revert = control(QPushButton(), texts, "settings_revert", "Revert", tip="Discard all edits")
        self.defaults = control(QPushButton(), texts, "settings_defaults", "Defaults",
                                tip="Load the vendor's defaults; nothing is written yet")  # fmt: skip
        tip = marked("Would these values have fired on what was measured? Nothing is sent")
        self.try_out = control(QPushButton(), texts, "settings_try", "Try it out", tip=tip, slot=self._try_out)
        self.as_found = control(QPushButton(), texts, "settings_as_found", "Restore initial",
                                tip="Restore the settings from before the first change of this session")  # fmt: skip

    def _wire(self) -> None:
        work, form = self.work, self.work.form
        for row in self.rows.values():
            row.typed.connect(lambda key, text: work.edit(partial(form.type_text, key, text)))
            row.chosen.connect(lambda key, value: work.edit(partial(form.choose, key, value)))
            row.cancelled.connect(lambda key: work.edit(partial(form.revert, key)))
            row.left.connect(form.end_typing)
            row.measure_wanted.connect(self._measure)
        self.read.clicked.connect(work.read_all)
        self.undo.clicked.connect(lambda: work.edit(form.undo))
        self.redo.clicked.connect(lambda: work.edit(form.redo))
        self.revert.clicked.connect(lambda: work.edit(form.revert))
        self.defaults.clicked.connect(lambda: work.edit(form.want_defaults))
        self.as_found.clicked.connect(work.want_as_found)
        Shortcut("settings_undo_key", self, self.undo)
        Shortcut("settings_redo_key", self, self.redo, keys=("Ctrl+Shift+Z", "Ctrl+Y"))
        Shortcut("settings_write_key", self, self.write, keys=("Ctrl+Return", "Ctrl+Enter"))
        Shortcut("settings_read_key", self, self.read)
        Shortcut("settings_open_key", self, self.files.open, keys=("Ctrl+O",))
        self.files.opened.connect(self._show_profile)
        self.files.refused.connect(self._show_faults)
        self.files.said.connect(self._say)
        self.compare.applied.connect(self._apply_profile)
        self.compare.closed.connect(self.show_form)
        self.calibration.closed.connect(self.show_form)
        self.calibration.proposed.connect(self._take_threshold)
        work.changed.connect(self.refresh)
        exchange = self._services.exchange
        exchange.find_drafts = lambda: form.wanted
        exchange.can_use = lambda: work.can_edit
        exchange.used.connect(self._take_drafts)

    def _say(self, notice: Notice) -> None:
        self.work.job.say(lambda: Notice(notice.meaning, notice.text, notice.choices, self.work.job.dismiss))

    def _lay_out(self) -> QWidget:
        texts = self._services.texts
        head = in_row((self.fingerprint, 1), self.files, spacing=Space.M, margins=(Space.M, Space.S, Space.M, Space.XS))
        card = QFrame()
        card.setObjectName("settings_card")
        card.setProperty("role", "card")
        in_column(*self.rows.values(), of=card, spacing=0, margins=1)
        content = QWidget()
        content.setObjectName("settings_content")
        in_column(card, self.baud, 1, of=content, spacing=Space.XL, margins=(Space.M, 0, Space.M, Space.S))
        self.scroll_area = control(QScrollArea(), texts, "settings_scroll", says="Settings")
        self.scroll_area.setWidgetResizable(True)
        self.scroll_area.setWidget(content)
        foot = FlowRow()
        foot.setContentsMargins(Space.M, Space.XS, Space.M, Space.S)
        foot.add(self.read, self.undo, self.redo, self.revert, self.defaults, self.as_found, self.try_out)
        foot.add_right(self.write)
        form = QWidget()
        form.setObjectName("settings_form")
        in_column(head, (self.scroll_area, 1), self.strip, foot, of=form, spacing=0, margins=0)
        return form

    # Qt

    def on_escape(self) -> bool:
        """Take a question back, or leave a profile."""
        if self._stack.currentWidget() is not self._form:
            self.show_form()
        elif not self.work.job.is_running and self.work.notice() is not None:
            self.work.job.dismiss()
        else:
            return False
        return True
