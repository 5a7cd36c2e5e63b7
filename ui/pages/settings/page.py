"""Settings page: what the module holds, what is to be written, and what came of it; nothing of it is kept here.

head      the settings code, Read all, what is rare
table     `SettingsTable` with the baud rate as its last row; only this scrolls
foot      profiles; Discard all, Write
instead   `ComparePanel` or `CalibrationPanel`
"""

from collections.abc import Mapping
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QFrame,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QStackedLayout,
    QToolButton,
    QWidget,
)

from app.engine.procedure import Job
from app.procedures.light import Band, Proposal, measure_light, propose
from app.settings.form import FORM_COMMANDS, Match, RowState, compare
from app.settings.profile_file import save_profile
from app.settings.profiles import Profile
from app.settings.values import DEFAULTS, fingerprint, value_text
from app.text.i18n import tr
from app.text.messages import UserMessage, join_sentences, labelled
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.fields import Value
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.pages.settings.rows import SettingsTable
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.page_job import PageJob
from ui.session.settings_draft import SettingsDraft
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, set_role, stacked, text_label
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

SUFFIX: Final = ".toml"
# For the ages.
REFRESH_EVERY_MS: Final = 250
_MAX_NOTE: Final = 200
_LIGHT: Final = BY_NAME["light_threshold"].key


class SettingsPage(Page):
    suffixes = (SUFFIX,)

    def __init__(self, services: Services) -> None:
        super().__init__("settings")
        self._services, self._preferences = services, services.preferences
        self.ask_open: AskOpen = ask_profile
        self.ask_save: AskPath = ask_path
        self.table = SettingsTable(lambda: self.work, services)
        self.rows, self.baud = self.table.rows, self.table.baud
        self.compare = ComparePanel(self)
        self.compare.apply.clicked.connect(self._write_ticked)
        self.calibration = CalibrationPanel(self)
        self.calibration.take.clicked.connect(self._use_threshold)
        self.strip = named(NoticeBar(), "settings_notice")
        self._stack = QStackedLayout(self)
        self._form = self._lay_out()
        stacked(self._stack, self._form, self.compare, self.calibration)
        exchange = services.exchange
        exchange.can_use = lambda: self.work.can_edit
        exchange.used.connect(self._use_drafts)
        exchange.measured.connect(self._measure)
        VisibilityTimer(self, every_ms=REFRESH_EVERY_MS, tick=self.refresh)

    def _lay_out(self) -> QWidget:
        self.code = named(QLabel(), "settings_code", "small")
        self.read = control(QPushButton(tr("Read all")), "settings_read", keys="F5", picture=Icon.AGAIN)
        self.read.clicked.connect(lambda _is_checked: self.work.read_all())
        header = self.make_header(tr("Settings"), self.code, self.read)
        self.defaults = header.add_rare("settings_defaults", tr("Load defaults"), lambda: self.work.fill(DEFAULTS))
        self.as_found = header.add_rare(
            "settings_as_found", tr("Restore initial"), lambda: self.work.fill(self.module.as_found or {})
        )
        says = tr("Measure the light threshold")
        self.measure = control(QToolButton(), "light_threshold_measure", text=tr("Measure"), says=says, role="narrow")
        self.measure.clicked.connect(self._measure)
        # In the place of the default, which the light threshold does not have.
        self.rows[_LIGHT].buttons.insertWidget(1, self.measure)
        self.open = control(QPushButton(tr("Open…")), "profile_open", keys="Ctrl+O", slot=self._choose_and_open)
        self.save = control(QPushButton(tr("Save as…")), "profile_save", slot=self._choose_and_save)
        for button in (self.open, self.save):
            button.setAccessibleName(labelled(tr("Profile"), button.text()))
        self.note = named(QLineEdit(), "settings_note", says=tr("Who writes, and why"))
        self.note.setPlaceholderText(tr("Who writes, and why"))
        self.note.setMaxLength(_MAX_NOTE)
        # It went with a write. It is cleared when nothing is left to be written, not where a question is cancelled.
        self._is_noted = False
        self.revert = control(QPushButton(tr("Discard all")), "settings_revert")
        self.revert.clicked.connect(lambda _is_checked: self.work.revert())
        self.write = control(
            QPushButton(tr("Write")),
            "settings_write",
            picture=Icon.DROP,
            role="primary",
            tip=tr("Write and verify"),
            keys="Ctrl+Return; Ctrl+Enter",
            slot=self._write,
        )
        profile = (named(QLabel(tr("Profile")), "profile_title_label", "small"), self.open, self.save)
        content = named(QWidget(), "settings_content")
        below = in_column(self.table, of=content, spacing=Space.S, margins=(Space.M, 0))
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
        form = named(QWidget(), "settings_form")
        head = in_column(header, margins=(Space.M, 0))
        in_column(head, (self.scroll_area, 1), self.strip, foot, of=form, spacing=0, margins=0)
        return form

    @property
    def work(self) -> SettingsDraft:
        return self.module.settings

    # Display

    def show_module(self, module: ShownModule) -> None:
        self.baud.forget_choice()
        # The light of two modules is no threshold; a profile that was opened before any answered is of none yet.
        if self.panel is not self.compare or self.module.number:
            self.close_panels()
        super().show_module(module)

    def refresh(self) -> None:
        work, now = self.work, self.module.now_s
        rows = work.rows
        for row in rows:
            key = row.command.key
            self.rows[key].show_row(row, now, is_editable=work.can_edit, last_write=work.last_write(key))
        self.baud.refresh()
        changes = len(work.changes)
        if self._is_noted and not changes and not work.is_writing:
            self._is_noted = False
            self.note.clear()
        count = changes or sum(row.state is RowState.WRITING for row in rows)
        text = tr("Write 1 change") if count == 1 else tr("Write {count} changes", count=count)
        # What cannot be sent is an edit, too: why it is not written stands in the notice.
        nothing = tr("Write") if work.impossible else tr("No changes")
        self.write.setText(text if count else nothing)
        self.write.setEnabled(work.job.looks_free and changes > 0 and not work.impossible)
        self.read.setEnabled(work.job.looks_free)
        self.revert.setEnabled(work.can_edit and bool(work.wanted))
        self.measure.setEnabled(work.can_edit)
        self.defaults.setEnabled(work.can_edit)
        self.as_found.setEnabled(work.can_edit and self.module.as_found is not None)
        # To be read out over the radio; a dash while any covered setting is unknown.
        self.code.setText(labelled(tr("Settings code"), fingerprint(self.module.view.settings(now)) or "—"))
        self.code.setToolTip(tr("Same settings, same code"))
        self.strip.show_notices(work.notices)
        if self.panel is not None:
            self.panel.refresh()

    # What is shown in place of the table

    @property
    def panel(self) -> "ComparePanel | CalibrationPanel | None":
        return next((one for one in (self.compare, self.calibration) if one is self._stack.currentWidget()), None)

    def close_panels(self) -> None:
        self.calibration.stop()
        self._stack.setCurrentWidget(self._form)

    def _show_panel(self, panel: "_Panel") -> None:
        self.close_panels()
        self._stack.setCurrentWidget(panel)
        self.refresh()

    # What a person does

    def _write(self) -> None:
        self._is_noted = True
        self.work.write(self._services.armed, self.note.text())

    def _measure(self) -> None:
        """Also from another page."""
        if self.module.is_going:
            self.calibration.bands.clear()
            self._show_panel(self.calibration)
            self.calibration.buttons[Side.CLOSED].setFocus()

    def _use_threshold(self) -> None:
        if isinstance(proposal := self.calibration.proposal, Proposal):
            self._use_drafts({_LIGHT: proposal.threshold_v})

    def _use_drafts(self, values: Mapping[str, Value]) -> None:
        """Also from another page."""
        self.close_panels()
        self.work.fill(values)

    def _write_ticked(self) -> None:
        self.close_panels()
        self.work.write(self._services.armed, ticked=self.compare.ticked)

    def _choose_and_open(self) -> None:
        self.ask_open(self, self._preferences.profile_folder, self.open_file)

    def open_file(self, path: Path) -> None:
        """Compare this profile with the module."""
        self.work.job.dismiss()
        profile = self.work.job.read_profile(path)
        if profile is not None:
            self._preferences.add_profile(path)
            self.compare.begin(profile)
            self._show_panel(self.compare)

    def _choose_and_save(self) -> None:
        """Save what the module holds now, as far as it is known."""
        self.work.job.dismiss()
        settings = self.module.view.settings(self.module.now_s)
        if not settings:
            self.work.job.notify(Meaning.ATTENTION, tr("No settings known: read them first."))
            return
        missing = [tr(one.title) for one in SETTINGS if one.key not in settings and one is not SERIAL_OUTPUT]

        def save(path: Path) -> None:
            profile = Profile(name=path.stem or tr("Profile"), settings=settings)
            self.work.job.write_file(path, partial(save_profile, path, profile), partial(saved, path))

        def saved(path: Path, _none: None) -> str:
            self._preferences.add_profile(path)
            left_out = tr("Unknown: {what}.", what=", ".join(missing)) if missing else ""
            return join_sentences((tr("Saved to {path}.", path=path), left_out))

        suggested = self._preferences.profile_folder / f"profile{SUFFIX}"
        self.ask_save(self, tr("Save as profile…"), suggested, f"*{SUFFIX}", save)

    # Esc, and leaving the page

    def ways_back(self) -> WaysBack:
        job = self.work.job
        return ((self.panel is not None, self.close_panels), (job.said, job.dismiss))

    def end_notices(self, *, is_page_left: bool = False) -> None:
        super().end_notices(is_page_left=is_page_left)
        if is_page_left and self._module is not None:
            self.work.job.end(is_page_left=True)


class _Panel(QWidget):
    """Shown in place of the table; only its parts scroll."""

    def __init__(self, page: SettingsPage, name: str, says: str) -> None:
        super().__init__()
        named(self, name, says=says)
        self.page = page
        self.title = text_label(f"{name}_title", "title", says)
        self.card = named(QFrame(), f"{name}_table", "card")
        self.grid = QGridLayout(self.card)
        self.grid.setHorizontalSpacing(Space.M)
        self.back = control(QPushButton(tr("Back")), f"{name}_back", key="Esc")
        self.back.clicked.connect(page.close_panels)

    def lay_out(self, main: QPushButton, *parts: QWidget) -> None:
        content = QWidget()
        in_column(self.title, *parts, 1, of=content, spacing=Space.S, margins=(Space.M, Space.S))
        scroll = scroll_area(content, f"{self.objectName()}_scroll", self.accessibleName(), is_vertical=True)
        foot = in_row(1, self.back, main, spacing=Space.S, margins=(Space.M, Space.S))
        in_column((scroll, 1), foot, of=self, spacing=0, margins=0)


class ComparePanel(_Panel):
    """A profile beside the module; what is ticked can be written."""

    def __init__(self, page: SettingsPage) -> None:
        super().__init__(page, "profile", tr("Profile"))
        self._profile: Profile | None = None
        # What a person ticked or unticked stays so.
        self._touched: set[str] = set()
        self.about = text_label("profile_about", "small")
        note = text_label("profile_note", "small", tr("The baud rate is never applied with a profile."))
        self.apply = control(QPushButton(), "profile_apply", picture=Icon.CHECK, role="primary")
        for column, head in enumerate((tr("Parameter"), tr("Profile"), tr("Module"), tr("State"))):
            self.grid.addWidget(named(QLabel(head), f"profile_head_{column}", "caption"), 0, column)
            self.grid.setColumnStretch(column, 1)
        # Tick, and the labels of the profile's value, the module's, and how they compare.
        self._cells: dict[str, tuple[QCheckBox, QLabel, QLabel, QLabel]] = {}
        for place, command in enumerate((*FORM_COMMANDS, BAUD_RATE), 1):
            title, name = tr(command.title), command.name
            # A check box does not wrap its text.
            tick = QCheckBox(title.replace(" ", "\n") if is_text_large() else title)
            named(tick, f"profile_tick_{name}", says=title)
            tick.clicked.connect(partial(self._touch, command.key))
            wanted, held = named(QLabel(), f"profile_wanted_{name}"), named(QLabel(), f"profile_stands_{name}")
            self._cells[command.key] = tick, wanted, held, text_label(f"profile_match_{name}")
            for column, cell in enumerate(self._cells[command.key]):
                self.grid.addWidget(cell, place, column)
        self.lay_out(self.apply, self.about, self.card, note)

    def begin(self, profile: Profile) -> None:
        self._profile, self._touched = profile, set()
        self.title.setText(profile.name)
        self.about.setText(" · ".join(filter(None, (profile.airframe, profile.notes))))

    @property
    def ticked(self) -> dict[str, Value]:
        """What is to be written, by the setting's key."""
        settings = {} if self._profile is None else self._profile.settings
        return {key: settings[key] for key, (tick, *_) in self._cells.items() if tick.isChecked()}

    def _touch(self, key: str) -> None:
        self._touched.add(key)
        self.refresh()

    def refresh(self) -> None:
        if self._profile is None:
            return
        module = self.page.module
        for row in compare(self._profile, module.view, module.now_s):
            command, known = row.command, row.module_value
            tick, *labels = self._cells[command.key]
            tick.setEnabled(row.target is not None and command is not BAUD_RATE)
            if command.key not in self._touched:
                tick.setChecked(row.is_worth_applying and command is not BAUD_RATE)
            wanted = "—" if row.target is None else value_text(command, row.target)
            held = tr("unknown") if known is None else value_text(command, known.value)
            is_calm = row.match in (Match.SAME, Match.NOT_IN_PROFILE)
            texts = (
                (wanted, "muted" if row.target is None else "strong"),
                (held, "muted" if known is None or known.is_stale else ""),
                (tr(row.match.value), "muted" if is_calm else "strong"),
            )
            for label, (text, role) in zip(labels, texts, strict=True):
                label.setText(text)
                label.setAccessibleName(labelled(tr(command.title), text))
                set_role(label, role)
        self.apply.setText(tr("Apply {count} ticked", count=len(self.ticked)))
        self.apply.setEnabled(self.page.work.job.can_run and bool(self.ticked))


class Side(Enum):
    """The position of the bay while the light is measured."""

    CLOSED = "closed"
    OPEN = "open"


class CalibrationPanel(_Panel):
    """Both positions of the bay, and below them the threshold in the middle."""

    def __init__(self, page: SettingsPage) -> None:
        super().__init__(page, "calibration", tr("Measure the light threshold"))
        self.bands: dict[Side, Band] = {}
        self.measuring: Side | None = None
        advice = tr("Measure in the light of the flight day, with no hand over the sensor.")
        intro = text_label("calibration_intro", "muted", advice)
        self.texts: dict[Side, QLabel] = {}
        self.buttons: dict[Side, QPushButton] = {}
        self.grid.setColumnStretch(1, 1)
        sides = ((Side.CLOSED, tr("Bay closed"), Icon.BAY_CLOSED), (Side.OPEN, tr("Bay open"), Icon.BAY_OPEN))
        for place, (side, text, picture) in enumerate(sides):
            name, heading = f"calibration_{side.value}", f"{place + 1}. {text}"
            self.texts[side] = text_label(f"{name}_text")
            self.texts[side].setAccessibleDescription(heading)
            button = self.buttons[side] = control(QPushButton(tr("Measure")), f"{name}_measure", picture=picture)
            button.setAccessibleName(labelled(heading, tr("Measure")))
            button.clicked.connect(partial(self._measure, side))
            self.grid.addWidget(named(QLabel(heading), f"{name}_title", "strong"), place, 0)
            self.grid.addWidget(self.texts[side], place, 1)
            self.grid.addWidget(button, place, 2)
        self.result = text_label("calibration_result", "strong")
        self.detail = text_label("calibration_detail", "small")
        self.take = control(QPushButton(tr("Use this threshold")), "calibration_take", role="primary")
        self.lay_out(self.take, intro, self.card, self.result, self.detail)

    @property
    def job(self) -> PageJob:
        return self.page.module.job("calibration")

    @property
    def proposal(self) -> Proposal | UserMessage | None:
        """None until both sides are measured."""
        return propose(self.bands[Side.CLOSED], self.bands[Side.OPEN]) if len(self.bands) == len(Side) else None

    def stop(self) -> None:
        if self.measuring is not None:
            self.measuring = None
            self.job.drop()

    def _measure(self, side: Side) -> None:
        """In place of what was measured of this side before."""
        if not self.job.can_run:
            return

        def end(job: Job[Band]) -> None:
            self.measuring = None
            if job.error is None:
                self.bands[side] = job.outcome()
                if isinstance(proposal := self.proposal, Proposal):
                    self.page.module.light_direction = proposal.direction

        self.bands.pop(side, None)
        self.measuring = side
        self.job.run(measure_light(), end)

    def refresh(self) -> None:
        for side in Side:
            band, progress = self.bands.get(side), self.job.progress
            text = tr("not measured yet")
            if self.measuring is side:
                text = tr("measuring… {done}", done=0 if progress is None else progress.done)
            elif band is not None and band.raws:
                low, high = band.low_v, band.high_v
                text = tr("{median:.1f} V ({low:.1f} to {high:.1f} V)", median=band.median_v, low=low, high=high)
            self.texts[side].setText(text)
            self.buttons[side].setEnabled(self.job.can_run)
        proposal = self.proposal
        self.take.setEnabled(isinstance(proposal, Proposal))
        self.result.setText(proposal.translated() if isinstance(proposal, UserMessage) else "")
        self.detail.setText("")
        if isinstance(proposal, Proposal):
            # The vendor's advice taken literally: the reading with the bay fully open.
            advice = tr("Vendor advises: {advice}.", advice=f"{self.bands[Side.OPEN].median_v:.1f} V")
            self.result.setText(proposal.sentence)
            self.detail.setText(join_sentences((tr(proposal.direction.value), advice)))
