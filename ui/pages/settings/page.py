"""Settings page: what the module holds, what is to be written, and what came of it; nothing of it is kept here.

head      the settings code, Read all, what is rare
table     `SettingsTable` with the baud rate as its last row; only this scrolls
foot      profiles; Discard all, Write
instead   `ComparePanel` or `CalibrationPanel`
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QLineEdit, QPushButton, QStackedLayout, QToolButton, QWidget

from app.procedures.act import Armed
from app.procedures.light import Proposal
from app.settings.form import RowState
from app.settings.profiles import Profile, save_profile
from app.settings.values import DEFAULTS, fingerprint
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.catalogue import BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.fields import Value
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.pages.settings.panels import BaudRow, CalibrationPanel, ComparePanel
from ui.pages.settings.rows import SettingsTable
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, WaysBack
from ui.session.settings_draft import SettingsDraft, Side
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, set_role, stacked
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

SUFFIX: Final = ".toml"
# For the ages.
REFRESH_EVERY_MS: Final = 250
MAX_NOTE: Final = 200
_LIGHT: Final = BY_NAME["light_threshold"].key


class SettingsPage(Page):
    suffixes = (SUFFIX,)

    def __init__(self, services: Services) -> None:
        super().__init__("settings")
        self._services, self._preferences = services, services.preferences
        self.ask_open: AskOpen = ask_profile
        self.ask_save: AskPath = ask_path
        self.files = JobNotice(self, is_of_module=False)
        self.table = SettingsTable(lambda: self.work)
        self.rows = self.table.rows
        self.baud = BaudRow(self.table, services)
        self.compare = ComparePanel()
        self.calibration = CalibrationPanel()
        self.strip = named(NoticeBar(), "settings_notice")
        self.code = named(QLabel(), "settings_code", "small")
        self._make_buttons()
        self._stack = QStackedLayout(self)
        self._form = self._lay_out()
        stacked(self._stack, self._form, self.compare, self.calibration)
        self._wire()
        VisibilityTimer(self, every_ms=REFRESH_EVERY_MS, tick=self.refresh)

    @property
    def work(self) -> SettingsDraft:
        """Of the module shown."""
        return self.module.settings

    # Display

    def show_module(self, module: ShownModule) -> None:
        self.baud.forget_choice()
        super().show_module(module)

    def refresh(self) -> None:
        work, now = self.work, self.module.now_s
        rows = work.rows
        for row in rows:
            self.rows[row.command.key].show_row(row, now, is_editable=work.can_edit)
        self.baud.refresh()
        count = len(work.changes)
        writing = sum(1 for row in rows if row.state is RowState.WRITING)
        self.write.setText(_write_text(count or writing))
        self.write.setEnabled(work.job.looks_free and count > 0 and not work.form.mistyped)
        self.read.setEnabled(work.job.looks_free)
        self.revert.setEnabled(work.can_edit and work.form.has_drafts)
        self.measure.setEnabled(work.can_edit)
        self.defaults.setEnabled(work.can_edit)
        self.as_found.setEnabled(work.can_edit and work.as_found is not None)
        self._show_code()
        notice = work.notice()
        if notice is not None and not self.files.is_busy and self.files.result_notice() is not None:
            self.files.dismiss()  # it is older, and would stand again when the other one is over
        self.strip.show_notice(notice or self.files.result_notice())
        if work.bands is not None:
            self.calibration.show_calibration(work)
            self._stack.setCurrentWidget(self.calibration)
        elif work.comparison is not None:
            self.compare.show_comparison(work, work.comparison)
            self._stack.setCurrentWidget(self.compare)
        else:
            self._stack.setCurrentWidget(self._form)

    def _show_code(self) -> None:
        """To be read out over the radio; a dash while any covered setting is unknown."""
        found = fingerprint(self.module.view.settings(self.module.now_s))
        self.code.setText(labelled(tr("Settings code"), found or "—"))
        self.code.setToolTip(tr("Same settings, same code"))

    # What a person does

    def _read(self) -> None:
        self.work.read_all()

    def _write(self, armed: Armed) -> None:
        self.work.write(armed, self.note.text())
        self.note.clear()

    def _discard_all(self) -> None:
        self.work.revert()

    def _close_panel(self) -> None:
        self.work.close_panels()

    def _tick(self, key: str, is_ticked: bool) -> None:
        if self.work.comparison is not None:
            self.work.comparison.ticks[key] = is_ticked
            self.refresh()

    def _measure(self) -> None:
        """Also from another page."""
        if self.module.is_going:
            self.work.calibrate()
            self.refresh()
            self.calibration.buttons[Side.CLOSED].setFocus()

    def _measure_side(self, side: Side) -> None:
        self.work.measure(side)

    def _use_threshold(self) -> None:
        proposal = self.work.proposal
        if isinstance(proposal, Proposal):
            self.work.close_panels()
            self.work.choose(_LIGHT, proposal.threshold_v)

    def _use_drafts(self, values: Mapping[str, Value]) -> None:
        """From another page."""
        self.work.close_panels()
        self.work.fill(values)

    # Profiles

    def open_file(self, path: Path) -> None:
        """Compare this profile with the module."""
        self.work.job.dismiss()
        self.files.dismiss()
        profile = self.files.read_profile(path)
        if profile is not None:
            self._preferences.add_profile(path)
            self.work.compare_with(profile, path)
        self.refresh()

    def _choose_and_save(self) -> None:
        """What the module holds now, as far as it is known."""
        self.work.job.dismiss()
        settings = self.module.view.settings(self.module.now_s)
        if not settings:
            self.files.notify(Meaning.ATTENTION, tr("No settings known: read them first."))
            return
        suggested = self._preferences.profile_folder / f"profile{SUFFIX}"
        self.ask_save(self, tr("Save as profile…"), suggested, f"*{SUFFIX}", partial(self._save, settings))

    def _save(self, settings: Mapping[str, Value], path: Path) -> None:
        missing = [tr(one.title) for one in SETTINGS if one.key not in settings and one is not SERIAL_OUTPUT]

        def saved(_none: None) -> str:
            self._preferences.add_profile(path)
            left_out = tr("Unknown: {what}.", what=", ".join(missing)) if missing else ""
            return join_sentences((tr("Saved to {path}.", path=path), left_out))

        profile = Profile(name=path.stem or tr("Profile"), settings=settings)
        self.files.write_file(path, partial(save_profile, path, profile), saved)

    # Construction

    def _make_buttons(self) -> None:
        self.write = control(
            QPushButton(tr("Write")),
            "settings_write",
            tip=tr("Write and verify"),
            picture=Icon.DROP,
            keys="Ctrl+Return; Ctrl+Enter",
            role="primary",
        )
        self.note = control(QLineEdit(), "settings_note", says=tr("Who writes, and why"))
        self.note.setPlaceholderText(tr("Who writes, and why"))
        self.note.setMaxLength(MAX_NOTE)
        self.read = control(QPushButton(tr("Read all")), "settings_read", keys="F5", picture=Icon.AGAIN)
        self.revert = control(QPushButton(tr("Discard all")), "settings_revert")
        self.measure = control(
            QToolButton(),
            "light_threshold_measure",
            text=tr("Measure"),
            says=tr("Measure the light threshold"),
            role="narrow",
        )
        self.rows[_LIGHT].add_button(self.measure)
        self.open = control(QPushButton(tr("Open…")), "profile_open", keys="Ctrl+O")
        self.save = control(QPushButton(tr("Save as…")), "profile_save")
        for button in (self.open, self.save):
            button.setAccessibleName(labelled(tr("Profile"), button.text()))

    def _lay_out(self) -> QWidget:
        header = self.make_header(tr("Settings"), self.code, self.read)
        self.defaults = header.add_rare("settings_defaults", tr("Load defaults"), lambda: self.work.fill(DEFAULTS))
        self.as_found = header.add_rare(
            "settings_as_found", tr("Restore initial"), lambda: self.work.fill(self.work.as_found or {})
        )
        title = named(QLabel(tr("Profile")), "profile_title_label", "small")
        profile = (title, self.open, self.save)
        content = named(QWidget(), "settings_content")
        below = in_column(self.table, spacing=Space.S, margins=(Space.M, 0))
        content.setLayout(below)
        # With large text the foot is one line all the same, and leaves room for the rows.
        at_left = () if is_text_large() else profile
        foot = in_row(*at_left, (self.note, 1), self.revert, self.write, spacing=Space.S, margins=(Space.M, Space.XS))
        if is_text_large():
            below.addLayout(in_row(*profile, 1, spacing=Space.S))
        below.addStretch()
        self.scroll_area = scroll_area(content, "settings_scroll", tr("Settings"), is_vertical=True)
        # A notice below the table takes height, and must not make the rows narrower.
        self.scroll_area.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        bar = named(self.scroll_area.verticalScrollBar(), "settings_scroll_bar", "idle")
        bar.rangeChanged.connect(lambda low, high: set_role(bar, "" if high > low else "idle"))
        self.scroll_area.setMinimumHeight(1)  # the foot and what is asked stay in sight
        head = in_column(header, margins=(Space.M, 0))
        form = named(QWidget(), "settings_form")
        in_column(head, (self.scroll_area, 1), self.strip, foot, of=form, spacing=0, margins=0)
        return form

    def _wire(self) -> None:
        armed, exchange = self._services.armed, self._services.exchange
        self.write.clicked.connect(lambda: self._write(armed))
        self.read.clicked.connect(self._read)
        self.revert.clicked.connect(self._discard_all)
        self.measure.clicked.connect(self._measure)
        self.open.clicked.connect(lambda: self.ask_open(self, self._preferences.profile_folder, self.open_file))
        self.save.clicked.connect(self._choose_and_save)
        self.files.changed.connect(self._refresh_if_seen)
        self.compare.ticked.connect(self._tick)
        self.compare.apply.clicked.connect(lambda: self.work.write_ticked(armed))
        self.calibration.wanted.connect(self._measure_side)
        self.calibration.take.clicked.connect(self._use_threshold)
        for back in (self.compare.back, self.calibration.back):
            back.clicked.connect(self._close_panel)
        exchange.can_use = lambda: self.work.can_edit
        exchange.used.connect(self._use_drafts)
        exchange.measured.connect(self._measure)

    # Esc, and leaving the page

    def ways_back(self) -> WaysBack:
        work = self.work
        return (
            (work.comparison is not None or work.bands is not None, work.close_panels),
            (not work.job.is_running and work.job.result_notice(), work.job.dismiss),
            (self.files.result_notice(), self.files.dismiss),
        )

    def end_notices(self, *, is_page_left: bool = False) -> None:
        super().end_notices(is_page_left=is_page_left)
        if is_page_left and self._module is not None:
            self.work.job.end(is_page_left=True)


def _write_text(count: int) -> str:
    if not count:
        return tr("No changes")
    return tr("Write 1 change") if count == 1 else tr("Write {count} changes", count=count)
