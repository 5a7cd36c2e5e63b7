"""Profiles on the Settings page: opened by dialog, recent list or drop, compared row by row, applied; saved."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFrame, QGridLayout, QLabel, QMenu, QPushButton, QWidget

from app.engine.device import DeviceView
from app.engine.snapshots import fresh_settings
from app.settings.form import FORM_COMMANDS, Match, ProfileRow, compare
from app.settings.profile_file import ProfileRefused, read_profile, save_or_say_why_not
from app.settings.profiles import Profile
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked
from ui.files.file_dialogs import AskOpen, AskPath, add_recent, ask_path, ask_profile
from ui.forms.field_editors import VALUE_PX, ValueLabel, explain_setting
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, is_text_large, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.readout import StateChip
from ui.widgets.visibility_timer import VisibilityTimer

SUFFIX: Final = ".toml"
_LARGE_VALUE_PX: Final = 112
_CHIPS: Final[Mapping[Match, tuple[Icon, Meaning | None]]] = {
    Match.SAME: (Icon.CHECK, None),
    Match.DIFFERENT: (Icon.SETTINGS, Meaning.INFORMATION),
    Match.UNKNOWN: (Icon.UNKNOWN, Meaning.UNKNOWN),
    Match.NOT_IN_PROFILE: (Icon.INFORMATION, None),
}


class ProfileCompare(QWidget):
    """`applied` carries the ticked values by key."""

    applied = Signal(object)
    shown = Signal()
    """Another profile, or the errors of a file."""
    closed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("profile_compare")
        self.profile: Profile | None = None
        self._path = Path()
        self._refusal: ProfileRefused | None = None
        self._is_touched: set[str] = set()
        self.title = text_label("profile_title", "title")
        self.about = text_label("profile_about", "small")
        self.faults = text_label("profile_faults", "attention")
        self.faults.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.note = text_label("profile_note", "small")
        self._rows = {command.key: _CompareRow(command) for command in (*FORM_COMMANDS, BAUD_RATE)}
        for key, row in self._rows.items():
            row.tick.clicked.connect(partial(self._is_touched.add, key))
        self.apply = control(
            QPushButton(),
            "profile_apply",
            picture=Icon.CHECK,
            role="primary",
            slot=lambda: self.applied.emit(self.ticked),
        )
        self.close_button = control(QPushButton(tr("Back")), "profile_close", key="Esc", slot=self.closed)
        self._lay_out()

    def show_profile(self, profile: Profile, path: Path) -> None:
        self.profile, self._path, self._refusal = profile, path, None
        self.forget_ticks()
        self.shown.emit()

    def forget_ticks(self) -> None:
        """What a person ticked or unticked was for the former module."""
        self._is_touched.clear()

    def show_faults(self, path: Path, refusal: ProfileRefused) -> None:
        self.profile, self._path, self._refusal = None, path, refusal
        self.shown.emit()

    def refresh(self, device: DeviceView, now: float, *, can_apply: bool) -> None:
        profile = self.profile
        self.faults.setVisible(profile is None)
        for widget in (self._table, self.apply, self.note):
            widget.setVisible(profile is not None)
        if profile is None:
            self.title.setText(tr("{file} is not a profile", file=self._path.name))
            self.about.setText(tr("Nothing was applied:"))
            self.faults.setText("" if self._refusal is None else "\n".join(self._refusal.sentences))
            return
        self.title.setText(profile.name)
        self.about.setText(" · ".join(part for part in (profile.airframe, profile.notes, str(self._path)) if part))
        for row in compare(profile, device, now):
            self._rows[row.command.key].show_row(row, now, is_touched=row.command.key in self._is_touched)
        count = len(self.ticked)
        self.apply.setText(tr("Apply {count} ticked", count=count))
        self.apply.setEnabled(can_apply and count > 0)

    @property
    def ticked(self) -> dict[str, Value]:
        settings = {} if self.profile is None else self.profile.settings
        return {key: settings[key] for key, row in self._rows.items() if key in settings and row.tick.isChecked()}

    def _lay_out(self) -> None:
        self.note.setText(tr("The baud rate is never applied with a profile."))
        self._table = named(QFrame(), "profile_table", "card")
        grid = QGridLayout(self._table)
        grid.setContentsMargins(Space.M, Space.S, Space.M, Space.S)
        grid.setHorizontalSpacing(Space.M)
        grid.setVerticalSpacing(Space.S)
        heads = (marked("Parameter"), marked("Profile"), marked("Module"), marked("State"))
        for column, english in enumerate(heads):
            head = text_label(f"profile_head_{column}", "caption")
            head.setText(tr(english))
            grid.addWidget(head, 0, column)
        for number, row in enumerate(self._rows.values(), start=1):
            for column, widget in enumerate((row.tick, row.target_label, row.value_label, row.chip)):
                grid.addWidget(widget, number, column, alignment=Qt.AlignmentFlag.AlignVCenter)
        grid.setColumnStretch(len(heads), 1)
        content = named(QWidget(), "profile_content")
        in_column(
            self.title,
            self.about,
            self.faults,
            self._table,
            self.note,
            1,
            of=content,
            spacing=Space.S,
            margins=(Space.M, Space.S),
        )
        scroll = scroll_area(content, "profile_scroll", tr("Profile"))
        foot = in_row(1, self.close_button, self.apply, spacing=Space.S, margins=(Space.M, Space.S))
        in_column((scroll, 1), foot, of=self, spacing=0, margins=0)


class _CompareRow:
    """The widgets of one row of the table's grid."""

    def __init__(self, command: Command) -> None:
        self.command = command
        self.tick = named(QCheckBox(tr(command.title)), f"profile_tick_{command.name}")
        explain_setting(self.tick, command)
        self.target_label = named(QLabel(), f"profile_wanted_{command.name}", "strong")
        self.value_label = named(ValueLabel(command), f"profile_stands_{command.name}")
        self.chip = named(StateChip("", size=Size.SMALL), f"profile_match_{command.name}")
        VisibilityTimer(self.tick, self._fit, restyle=self._fit)

    def _fit(self) -> None:
        """A check box does not wrap its text: where it is large each word has its line, and the value less room."""
        title = tr(self.command.title)
        self.value_label.setFixedWidth(scaled(_LARGE_VALUE_PX if is_text_large() else VALUE_PX))
        self.tick.setText(title.replace(" ", "\n") if is_text_large() else title)

    def show_row(self, row: ProfileRow, now: float, *, is_touched: bool) -> None:
        can_apply = row.target is not None and row.command is not BAUD_RATE
        self.tick.setEnabled(can_apply)
        if not can_apply or not is_touched:
            self.tick.setChecked(can_apply and row.is_worth_applying)
        self.target_label.setText("—" if row.target is None else value_text(row.command, row.target))
        self.value_label.show_known(row.module_value, now)
        picture, meaning = _CHIPS[row.match]
        self.chip.set_caption(tr(row.command.title))
        self.chip.show_state(tr(row.match.value), picture, meaning)


class ProfileFiles(QObject):
    opened = Signal(object, object)
    """`Profile` and path."""
    refused = Signal(object, object)
    """Path and `ProfileRefused`."""

    def __init__(self, services: Services, page: QWidget, result: JobNotice) -> None:
        super().__init__(page)
        self.ask_open: AskOpen = ask_profile
        self.ask_save: AskPath = ask_path
        self._page, self._result = page, result
        self._connector, self._remembered = services.connector, services.preferences
        self.title = named(QLabel(tr("Profile")), "profile_title_label", "small")
        self.open = control(QPushButton(tr("Open…")), "profile_open", keys="Ctrl+O", slot=self.choose)
        self.recent = control(QPushButton(tr("Compare")), "profile_recent", tip=tr("Recent files"))
        self.menu = named(QMenu(page), "profile_recent_menu")
        self.recent.setMenu(self.menu)
        self.save = control(QPushButton(tr("Save as…")), "profile_save", slot=self.choose_and_save)
        for button in (self.open, self.recent, self.save):
            button.setAccessibleName(labelled(tr("Profile"), button.text()))
        self.menu.aboutToShow.connect(self._fill_menu)

    def refresh(self) -> None:
        self.recent.setEnabled(bool(self._remembered.recent_profiles))

    def choose(self) -> None:
        """The profile is for the module that is shown when it is asked for."""
        asked = self._connector.current, self._connector.current.adapter_key

        def open_file(path: Path) -> None:
            if asked == (self._connector.current, self._connector.current.adapter_key):
                self.open_file(path)
            else:
                self._result.notify(Meaning.ATTENTION, tr("Another module is shown now: nothing was opened."))

        self.ask_open(self._page, self._remembered.profile_folder, open_file)

    def open_file(self, path: Path) -> None:
        try:
            profile = read_profile(path)
        except ProfileRefused as refusal:
            if not path.exists():
                self._remove_recent(path)
            self.refused.emit(path, refusal)
            return
        self._remember(path)
        self.opened.emit(profile, path)

    def choose_and_save(self) -> None:
        """Saves the module's current settings where any are known."""
        known = fresh_settings(self._connector.current.device, self._connector.clock())
        profile = Profile(name=tr("Profile"), settings=known)
        if not profile.settings:
            self._result.notify(Meaning.ATTENTION, tr("No settings known: read them first."))
            return
        suggested = self._remembered.profile_folder / f"profile{SUFFIX}"
        save = partial(self._save, profile)
        self.ask_save(self._page, tr("Save as profile…"), suggested, "*.toml", save)

    def _save(self, profile: Profile, path: Path) -> None:
        fault = save_or_say_why_not(path, Profile(name=path.stem or tr("Profile"), settings=profile.settings))
        if fault is not None:
            self._result.notify(Meaning.DANGER, fault.translated())
            return
        self._remember(path)
        missing = [one.title for one in SETTINGS if one.key not in profile.settings and one is not SERIAL_OUTPUT]
        self._result.notify(Meaning.GOOD, _saved_text(path, missing))

    def _remember(self, path: Path) -> None:
        self._remembered.add_profile(path)
        self.refresh()

    def _remove_recent(self, path: Path) -> None:
        name = str(path.absolute())
        self._remembered.recent_profiles = tuple(one for one in self._remembered.recent_profiles if one != name)
        self.refresh()

    def _fill_menu(self) -> None:
        self.menu.clear()
        add_recent(self.menu, "profile_recent", self._remembered.recent_profiles, self.open_file)


def _saved_text(path: Path, missing: Sequence[str]) -> str:
    left_out = tr("Unknown: {what}.", what=", ".join(map(tr, missing))) if missing else ""
    return join_sentences((tr("Saved to {path}.", path=path), left_out))
