"""Settings page: a table of parameters with the module's value and the new one; write and verify.

    head      the settings code, Read all, what is rare
    table     groups of `SettingsRow` and the `BaudPanel`
    foot      profiles; Discard edits, Write
    instead   `ProfileCompare` or `CalibrationPanel`
`SettingsController` owns the form and runs one job at a time. Only the rows scroll.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QStackedLayout, QWidget

from app.engine.snapshots import fresh_settings
from app.settings.fingerprint import Fingerprint, fingerprint
from app.settings.form import FORM_COMMANDS, RowState
from app.settings.values import DEFAULTS
from app.text.i18n import tr
from app.text.sentences import labelled
from protocol.catalogue import BY_NAME
from protocol.fields import Flag, Value
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.forms.field_editors import VALUE_PX
from ui.pages.settings.controller import SettingsController
from ui.pages.settings.panels import BaudPanel, CalibrationPanel
from ui.pages.settings.profiles import SUFFIX, ProfileCompare, ProfileFiles
from ui.pages.settings.row import CELL_GAP, EDITOR_PX, MARGINS, NAME_PX, STATE_PX, WIDE_NAME_PX, SettingsRow
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, is_text_large, scaled
from ui.widgets.controls import control, named
from ui.widgets.layouts import FlowRow, in_column, in_row, scroll_area, stacked
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 250
_WIDE_FROM_PX: Final = 816
"""In a table of this width the names and the values have more room, and, at the size of text in use, reasons lie beside
their states."""
_REST_PX: Final = 120
"""Of a row: a reason, the gaps and the margins."""
_GAPS_PX: Final = 71
_WIDEST_STATE_PX: Final = 121
_LARGE_NAME_PX: Final = 172
_FOLDED_TO_PX: Final = 600
"""Up to this width of the table the button of the baud rate lies below its text."""
_CAPTIONS_FROM_PX: Final = 540
"""A lower page gives the room of the captions to the rows: the baud rate is in sight at 1024x600."""
_SERIAL: Final = "serial_output"
_LIGHT: Final = BY_NAME["light_threshold"].key


class SettingsPage(Page):
    suffixes = (SUFFIX,)

    def __init__(self, services: Services) -> None:
        super().__init__("settings")
        self._services, self._connector = services, services.connector
        self.work = SettingsController(services, self)
        self.rows = {command.key: SettingsRow(command) for command in FORM_COMMANDS}
        self.baud = BaudPanel(services)
        self.header = self.make_header(tr("Settings"))
        self.files = ProfileFiles(services, self, self.work.job)
        self.compare = ProfileCompare()
        self.calibration = CalibrationPanel(services)
        self.strip = named(NoticeBar(), "settings_notice")
        self.code = named(QLabel(), "settings_code", "small")
        self._make_buttons()
        self.rows[_LIGHT].add_beside_editor(self.measure)
        self._stack = QStackedLayout(self)
        self._form = self._lay_out()
        stacked(self._stack, self._form, self.compare, self.calibration)
        self._wire()
        self.work.changed.connect(VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS).refresh_seen)
        self.refresh()

    def open_file(self, path: Path) -> None:
        self.files.open_file(path)

    def refresh(self) -> None:
        work, device, now = self.work, self._connector.current.device, self._connector.clock()
        form = work.form
        rows = form.rows(device, now)
        for row in rows:
            key = row.command.key
            self.rows[key].show_row(row, now, is_editable=work.can_edit)
        count = len(form.changes(device, now))
        writing = sum(row.state is RowState.WRITING for row in rows)
        self.write.setText(_write_text(count or writing))
        self.write.setEnabled(work.can_write and count > 0 and not form.mistyped)
        self.read.setEnabled(work.job.can_run)
        self.revert.setEnabled(work.can_edit and form.has_drafts)
        self.defaults.setEnabled(work.can_fill(DEFAULTS))
        self.as_found.setEnabled(work.can_fill(None if work.initial is None else work.initial.settings))
        self.find_rate.setEnabled(self._connector.current.is_open)
        self.strip.show_notice(work.notice() or self._idle_notice())
        self._show_code(fingerprint(fresh_settings(device, now)))
        self.files.refresh()
        self.compare.refresh(device, now, can_apply=work.can_write and work.can_edit)
        self.baud.refresh()
        self.calibration.refresh()

    def _show_code(self, fingerprint: Fingerprint) -> None:
        """To be read out over the radio; a dash while any covered setting is unknown."""
        code = (fingerprint.code if fingerprint.is_complete else None) or "—"
        self.code.setText(labelled(tr("Settings code"), code))
        missing = ", ".join(tr(command.title) for command in fingerprint.missing)
        self.code.setToolTip(tr("Unknown: {what}.", what=missing) if missing else tr("Same settings, same code"))

    def _idle_notice(self) -> Notice | None:
        if mistyped := self.work.mistyped_notice():
            return mistyped
        if not self._connector.current.is_open or self.work.job.is_running or self.work.can_write:
            return None
        is_online = self._connector.current.device.presence is Presence.ONLINE
        text = tr("Checking whether it is the same module…") if is_online else tr("The module does not answer.")
        return Notice(Meaning.ATTENTION, text)

    # Actions

    def show_form(self) -> None:
        self._stack.setCurrentWidget(self._form)
        self.refresh()

    def _show_compare(self) -> None:
        self._stack.setCurrentWidget(self.compare)
        self.refresh()

    def _apply_profile(self, values: dict[str, Value]) -> None:
        """Other edits were not ticked, nor even shown: they stay edits."""
        self._use_drafts(values)
        self.work.write(only=values)

    def _measure(self) -> None:
        self.calibration.begin()
        self._stack.setCurrentWidget(self.calibration)
        self.refresh()

    def _use_threshold(self, threshold_v: float) -> None:
        self.work.edit(partial(self.work.form.choose, "light_threshold_v", threshold_v))
        self.show_form()

    def _try_out(self) -> None:
        """The edits, and for the rest what the module has."""
        rows = self.work.form.rows(self._connector.current.device, self._connector.clock())
        known = {row.command.key: row.module_value.value for row in rows if row.module_value is not None}
        self.page_wanted.emit("flights")
        self._services.exchange.tried.emit({**known, **self.work.form.edited}, None, bool)

    def _use_drafts(self, values: Mapping[str, Value]) -> None:
        self.show_form()
        self.work.edit(partial(self.work.form.fill, values))

    # Construction

    def _make_buttons(self) -> None:
        work, form = self.work, self.work.form
        self.write = control(
            QPushButton(),
            "settings_write",
            tip=tr("Write and verify"),
            keys="Ctrl+Return; Ctrl+Enter",
            about=tr("Sends each edited row once and reads it back; never to an ACTIVE module."),
            picture=Icon.DROP,
            role="primary",
            slot=work.write,
        )
        self.read = control(
            QPushButton(tr("Read all")), "settings_read", keys="F5", picture=Icon.AGAIN, slot=self.work.read_all
        )
        self.revert = control(QPushButton(tr("Discard edits")), "settings_revert", slot=lambda: work.edit(form.revert))
        self.measure = control(
            QPushButton(),
            "light_threshold_measure",
            says=tr("Measure the light threshold"),
            picture=Icon.LIGHT,
            role="quiet",
            slot=self._measure,
        )
        for part in (self.code, self.read):
            self.header.add(part)
        self.defaults = self.header.add_rare(
            "settings_defaults", tr("Load defaults"), lambda: work.edit(partial(form.fill, DEFAULTS))
        )
        self.as_found = self.header.add_rare("settings_as_found", tr("Restore initial"), work.restore_initial)
        self.header.add_rare("settings_measure", tr("Measure the light threshold"), self._measure)
        self.try_out = self.header.add_rare("settings_try", tr("Try on recorded data"), self._try_out)
        self.find_rate = self.header.add_rare("settings_find_rate", tr("Find the baud rate"), self._connector.find_rate)

    def _wire(self) -> None:
        work, form = self.work, self.work.form
        for row in self.rows.values():
            row.chosen.connect(lambda key, value: work.edit(partial(form.choose, key, value)))
            row.mistyped.connect(lambda key, text: work.edit(partial(form.mistype, key, text)))
            row.cancelled.connect(lambda key: work.edit(partial(form.revert, key)))
        self.files.opened.connect(self.compare.show_profile)
        self.files.refused.connect(self.compare.show_faults)
        self.compare.shown.connect(self._show_compare)
        self.compare.applied.connect(self._apply_profile)
        self.compare.closed.connect(self.show_form)
        self.calibration.closed.connect(self.show_form)
        self.calibration.proposed.connect(self._use_threshold)
        exchange = self._services.exchange
        exchange.can_use = lambda: work.can_edit
        exchange.used.connect(self._use_drafts)
        for is_over in (self._connector.invalidated, self._connector.broke_in_doubt):
            is_over.connect(exchange.forgotten)
            is_over.connect(self.compare.forget_ticks)
        exchange.measured.connect(self._measure)

    def _lay_out(self) -> QWidget:
        table = named(QFrame(), "settings_card", "card")
        flags = [row for row in self.rows.values() if isinstance(row.command.write, Flag)]
        serial = self.rows[BY_NAME[_SERIAL].key]
        groups = (
            (marked("Thresholds"), [row for row in self.rows.values() if row not in flags]),
            (marked("Automatic triggers"), [row for row in flags if row is not serial]),
            (marked("Serial line"), [serial]),
        )
        rows: list[QWidget] = []
        self._captions: list[QLabel] = []
        for number, (english, members) in enumerate(groups):
            caption = named(QLabel(tr(english)), f"settings_group_{number}", "caption")
            caption.setContentsMargins(Space.S + 3, 2, 0, 2)
            self._captions.append(caption)
            rows += [caption, *members]
        content = named(QWidget(), "settings_content")
        in_column(*rows, self.baud, 1, of=content, spacing=0, margins=0)
        self.scroll_area = scroll_area(
            content, "settings_scroll", tr("Settings"), is_vertical=True, is_transparent=True
        )
        in_column(self._make_heads(), (self.scroll_area, 1), of=table, spacing=0, margins=1)
        body = in_row((table, 1), margins=(Space.M, 0))
        head = in_column(self.header, margins=(Space.M, 0))
        files = self.files
        foot = FlowRow(files.title, files.open, files.recent, files.save, right=(self.revert, self.write),
                       margins=(Space.M, Space.XS))  # fmt: skip
        form = named(QWidget(), "settings_form")
        in_column(head, (body, 1), self.strip, foot, of=form, spacing=0, margins=0)
        return form

    def _make_heads(self) -> QWidget:
        heads = named(QFrame(), "settings_heads", "bar")
        columns = (
            (marked("Parameter"), NAME_PX),
            (marked("Module"), VALUE_PX),
            (marked("New value"), EDITOR_PX),
            (marked("State"), STATE_PX),
        )
        labels = []
        for number, (english, width) in enumerate(columns):
            label = named(QLabel(tr(english)), f"settings_head_{number}", "caption")
            label.setFixedWidth(width)
            labels.append(label)
        self._heads = labels
        left, _top, right, _bottom = MARGINS
        in_row(*labels, 1, of=heads, spacing=CELL_GAP, margins=(left + 3, Space.XS, right, Space.XS))
        return heads

    # Qt

    def fit(self) -> None:
        is_low, policy = self.height() < scaled(_CAPTIONS_FROM_PX), Qt.ScrollBarPolicy
        for caption in self._captions:
            caption.setVisible(not is_low)
        # A notice below the table takes height, and must not make the rows narrower.
        self.scroll_area.setVerticalScrollBarPolicy(policy.ScrollBarAlwaysOn if is_low else policy.ScrollBarAsNeeded)
        self._fit_columns(self.width() - 2 * Space.M)

    def _fit_columns(self, table_px: int) -> None:
        """Gives the columns the widths that fit a table of `table_px` in the size of text in use."""
        is_wide = table_px >= _WIDE_FROM_PX
        room_px = table_px - WIDE_NAME_PX - scaled(EDITOR_PX) - scaled(STATE_PX) - _REST_PX
        value_px = max(VALUE_PX, min(scaled(VALUE_PX), room_px)) if is_wide else VALUE_PX
        name_px = NAME_PX if not is_wide else _LARGE_NAME_PX if is_text_large() else WIDE_NAME_PX
        rest_px = name_px + value_px + scaled(_WIDEST_STATE_PX) + _GAPS_PX
        editor_px = max(EDITOR_PX, min(scaled(EDITOR_PX), table_px - rest_px)) if is_wide else EDITOR_PX
        rows = self.rows.values()
        for name in (self._heads[0], self.baud.title, *(row.name for row in rows)):
            name.setFixedWidth(name_px)
        for value in (self._heads[1], self.baud.value_label, *(row.value_label for row in rows)):
            value.setFixedWidth(value_px)
        for editor in (self._heads[2], self.baud.editor, *(row.editor for row in rows)):
            editor.setFixedWidth(editor_px)
        self.baud.fold(is_narrow=table_px < scaled(_FOLDED_TO_PX))
        for row in rows:
            row.fold(is_narrow=table_px < scaled(_WIDE_FROM_PX))

    def ways_back(self) -> WaysBack:
        shown, job = self._stack.currentWidget(), self.work.job
        return (
            (shown is self.calibration, self.calibration.close_panel),
            (shown is self.compare, self.show_form),
            (not job.is_running and self.work.notice(), job.dismiss),
        )


def _write_text(count: int) -> str:
    if not count:
        return tr("No changes")
    return tr("Write 1 change") if count == 1 else tr("Write {count} changes", count=count)
