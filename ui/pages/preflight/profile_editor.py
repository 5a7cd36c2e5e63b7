"""Editor of a profile: limits of the pre-flight check, guided tests, manual checks.

The profile's settings are edited on the Settings page. A profile is valid where its file could be read again.
"""

from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QGridLayout, QLabel, QLineEdit, QPushButton, QWidget

from app.guided.catalogue import GUIDED_TESTS
from app.guided.results import TITLES
from app.preflight.verdict import CHECKS
from app.settings.profile_file import ProfileRefused, parse_profile, profile_text, save_or_say_why_not
from app.settings.profiles import LIMITS, MAX_ITEMS, MAX_NAME_LENGTH, MAX_TEST_DAYS, ActivatedBy, ManualLine, Profile
from app.text.i18n import tr
from app.text.sentences import labelled
from protocol.translatable import marked
from ui.files.file_dialogs import AskPath, ask_path
from ui.services.context import Services
from ui.style.theme import Meaning, Space
from ui.widgets.controls import Shortcut, named
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.number_line import NumberKind, NumberLine
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_STEP: Final = 0.0001
"""The finest that a profile's number may be."""
_USUAL_TEST_DAYS: Final = 180
_ACTIVATED: Final = {ActivatedBy.PERSON: marked("a person"), ActivatedBy.AIRCRAFT: marked("the aircraft")}


class _Number:
    """A row of the grid: a check box and a number, which is None while it is not checked or cannot be used."""

    def __init__(self, name: str, title: str, why: str, kind: NumberKind, default: float) -> None:
        self._default = default
        self.tick = named(QCheckBox(title), f"{name}_tick")
        self.tick.setToolTip(why)
        self.box = named(NumberLine(kind, start=default), f"{name}_value")
        self.box.setAccessibleName(title)
        self.box.setToolTip(why)
        self.unit = named(QLabel(kind.unit), f"{name}_unit", "muted")
        self.tick.toggled.connect(self._on_tick)
        self.show_value(None)

    @property
    def value(self) -> float | int | None:
        number = self.box.number if self.tick.isChecked() else None
        return int(number) if number is not None and number.is_integer() else number

    @property
    def is_wrong(self) -> bool:
        return self.tick.isChecked() and self.box.is_wrong

    def show_value(self, value: float | None) -> None:
        with QSignalBlocker(self.tick):
            self.tick.setChecked(value is not None)
        self.box.show_number(self._default if value is None else value)
        self.box.setEnabled(value is not None)

    def _on_tick(self, is_on: bool) -> None:
        self.box.setEnabled(is_on)
        if not is_on:
            self.box.show_number(self._default)
        self.box.edited.emit()


class ManualEditor(QWidget):
    """One manual check: its text, and whether it is required. Without a text there is none."""

    changed = Signal()

    def __init__(self, number: int, line: ManualLine) -> None:
        super().__init__()
        name = f"profile_manual_{number}"
        self.setObjectName(name)
        self.text = named(QLineEdit(line.text), f"{name}_text")
        self.text.setAccessibleName(f"{tr('Manual checks')} {number}")
        self.text.setPlaceholderText(tr("Manual checks"))
        self.text.setMaxLength(MAX_NAME_LENGTH)
        self.required = named(QCheckBox(tr("Required")), f"{name}_required")
        self.required.setChecked(line.is_required)
        self.text.textEdited.connect(self.changed)
        self.required.toggled.connect(self.changed)
        in_row((self.text, 1), self.required, of=self, spacing=Space.S, margins=0)

    @property
    def line(self) -> ManualLine:
        return ManualLine(self.text.text().strip(), self.required.isChecked())


class ProfileEditor(QWidget):
    """`saved`: the path of the file."""

    saved = Signal(object)
    closed = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("profile_editor")
        self.ask_save: AskPath = ask_path
        self._preferences = services.preferences
        self._path: Path | None = None
        self._original = self._unedited = Profile(name="")
        """As it is in its file, and as the fields show it: without spaces around its texts."""
        self.name, self.airframe = named(QLineEdit(), "profile_name"), named(QLineEdit(), "profile_airframe")
        for line in (self.name, self.airframe):
            line.setMaxLength(MAX_NAME_LENGTH)
            line.textEdited.connect(self.refresh)
        self.activated_by = named(QComboBox(), "profile_activated_by")
        for who, text in _ACTIVATED.items():
            self.activated_by.addItem(tr(text), who)
        WheelGuard(self.activated_by)
        self.activated_by.activated.connect(self.refresh)
        self.service = named(QCheckBox(tr("Overdue service is NO-GO")), "profile_service")
        self.service.toggled.connect(self.refresh)
        titles = {check.id: tr(check.title) for check in CHECKS}
        self.limits = {
            name: _Number(
                f"profile_limit_{name}",
                f"{titles[limit.check]} {'≤' if limit.is_maximum else '≥'}",
                tr(limit.why),
                NumberKind.of(limit.low, limit.high, _STEP, limit.shown.partition("}")[2].strip()),
                limit.usual,
            )
            for name, limit in LIMITS.items()
        }
        days = NumberKind.of(1, MAX_TEST_DAYS, 1, tr("days"))
        self.tests = {
            test.kind: _Number(
                f"profile_test_{test.kind.value}", tr(TITLES[test.kind]), tr("Not older than"), days, _USUAL_TEST_DAYS
            )
            for test in GUIDED_TESTS
        }
        self.manual: list[ManualEditor] = []
        """The last one is empty: a new check is typed there."""
        self.strip = named(NoticeBar(), "profile_editor_notice")
        self.cancel = named(QPushButton(tr("Cancel")), "profile_cancel")
        self.save_as = named(QPushButton(tr("Save as…")), "profile_save_as")
        self.save = named(QPushButton(tr("Save")), "profile_save", "primary")
        for button, act in (
            (self.cancel, self.close_editor),
            (self.save_as, self.choose_and_save),
            (self.save, self._save),
        ):
            button.clicked.connect(act)
        Shortcut(self.save, "Ctrl+S")
        self._lay_out()
        VisibilityTimer(self, self.refresh)

    # What is edited

    def edit(self, profile: Profile | None, path: Path | None) -> None:
        """`profile` None: a new one. `path`: its file."""
        self._original, self._path = profile or Profile(name=""), path
        original = self._original
        self.name.setText(original.name)
        self.airframe.setText(original.airframe)
        self.activated_by.setCurrentIndex(self.activated_by.findData(original.activated_by))
        self.service.setChecked(original.is_service_required)
        for name, number in self.limits.items():
            number.show_value(original.limits.get(name))
        for kind, number in self.tests.items():
            number.show_value(original.tests_within_days.get(kind))
        for row in self.manual:
            row.hide()
            row.deleteLater()
        self.manual.clear()
        for line in original.manual:
            self._add_manual(line)
        self._unedited = self.profile
        self.strip.show_notice(None)
        self.refresh()
        self.name.setFocus()

    @property
    def profile(self) -> Profile:
        limits = {name: value for name, number in self.limits.items() if (value := number.value) is not None}
        tests = {kind: int(value) for kind, number in self.tests.items() if (value := number.value) is not None}
        return self._original._replace(
            name=self.name.text().strip(),
            airframe=self.airframe.text().strip(),
            activated_by=self.activated_by.currentData() or ActivatedBy.PERSON,
            is_service_required=self.service.isChecked(),
            limits=limits,
            tests_within_days=tests,
            manual=tuple(row.line for row in self.manual if row.line.text),
        )

    @property
    def is_edited(self) -> bool:
        return self.profile != self._unedited or bool(self._wrong_numbers())

    def faults(self) -> tuple[str, ...]:
        """Why a file with this content would be refused, or would not hold what is typed."""
        wrong = self._wrong_numbers()
        if wrong:
            return tuple(labelled(number.tick.text(), number.box.kind.range_text) for number in wrong)
        try:
            parse_profile(profile_text(self.profile).encode("utf-8", "surrogatepass"))
        except ProfileRefused as refusal:
            return refusal.sentences
        return ()

    def _wrong_numbers(self) -> list[_Number]:
        return [number for number in (*self.limits.values(), *self.tests.values()) if number.is_wrong]

    def refresh(self) -> None:
        if len(self.manual) < MAX_ITEMS and (not self.manual or self.manual[-1].line.text):
            self._add_manual(ManualLine(""))
        faults = self.faults()
        if faults:
            self.strip.show_notice(Notice(Meaning.ATTENTION, "\n".join(faults[:3])))
        elif self.strip.notice is not None and not self.strip.notice.choices:
            self.strip.show_notice(None)
        self.save.setEnabled(not faults and (self.is_edited or self._path is None))
        self.save_as.setEnabled(not faults)

    # What a person does

    def close_editor(self) -> None:
        """Close the editor; ask before edits are discarded."""
        if not self.is_edited:
            self.closed.emit()
            return
        keep = Choice("keep", tr("Cancel"), lambda: self.strip.show_notice(None))
        discard = Choice("discard", tr("Discard edits"), self.closed.emit, is_step=True)
        self.strip.show_notice(Notice(Meaning.ATTENTION, tr("Unsaved edits."), (keep, discard)))

    def choose_and_save(self) -> None:
        suggested = self._path or self._preferences.profile_folder / "profile.toml"
        self.ask_save(self, tr("Save as profile…"), suggested, "*.toml", self._save_to)

    def _save(self) -> None:
        if self._path is None:
            self.choose_and_save()
        else:
            self._save_to(self._path)

    def _save_to(self, path: Path) -> None:
        profile = self.profile
        fault = save_or_say_why_not(path, profile._replace(name=profile.name or path.stem), source=self._path)
        if fault is None:
            self.saved.emit(path)
            return
        dismiss = partial(self.strip.show_notice, None)
        self.strip.show_notice(Notice(Meaning.DANGER, fault.translated(), dismiss=dismiss))

    def _add_manual(self, line: ManualLine) -> None:
        row = ManualEditor(len(self.manual) + 1, line)
        row.changed.connect(self.refresh)
        self.manual.append(row)
        self._manual_rows.addWidget(row)

    def _lay_out(self) -> None:
        head = QFormLayout()
        head.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow)
        rows = ((tr("Name"), self.name), (tr("Airframe"), self.airframe), (tr("Activated by"), self.activated_by))
        for title, field in rows:
            head.addRow(title, field)
            field.setAccessibleName(title)
        numbers = QGridLayout()
        numbers.setColumnStretch(3, 1)
        numbers.setHorizontalSpacing(Space.M)
        for title, group in ((tr("Limits"), self.limits.values()), (tr("Guided tests"), self.tests.values())):
            numbers.addWidget(named(QLabel(title), "profile_caption", "caption"), numbers.rowCount(), 0, 1, 4)
            for number in group:
                number.box.edited.connect(self.refresh)
                row = numbers.rowCount()
                for column, part in enumerate((number.tick, number.box, number.unit)):
                    numbers.addWidget(part, row, column)
        manual, content = QWidget(), named(QWidget(), "profile_editor_content")
        self._manual_rows = in_column(of=manual, spacing=Space.XS, margins=0)
        caption = named(QLabel(tr("Manual checks")), "profile_manual_caption", "caption")
        in_column(head, numbers, self.service, caption, manual, 1, of=content, spacing=Space.S, margins=(Space.M, 0))
        scroll = scroll_area(content, "profile_editor_scroll", tr("Profile"), is_vertical=True)
        foot = in_row(1, self.cancel, self.save_as, self.save, spacing=Space.S, margins=(Space.M, Space.S))
        heading = in_row(named(QLabel(tr("Profile")), "profile_title", "title"), margins=(Space.M, 0, 0, Space.S))
        in_column(heading, (scroll, 1), self.strip, foot, of=self, spacing=0, margins=0)
