"""Editor of a profile: limits of the pre-flight check, guided tests, manual checks.

The profile's settings are edited on the Settings page. A profile is valid where its file could be read again.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QLabel, QLineEdit, QPushButton, QWidget

from app.guided.guided_tests import GUIDED_TESTS
from app.guided.results import TITLES
from app.preflight.checks import CHECKS
from app.settings.profiles import (
    LIMITS,
    MAX_ITEMS,
    MAX_NAME_LENGTH,
    MAX_TEST_DAYS,
    ActivatedBy,
    ManualLine,
    Profile,
    ProfileRefused,
    parse_profile,
    profile_text,
    save_or_say_why_not,
)
from app.text.i18n import tr
from app.text.messages import in_brackets, labelled
from ui.files.file_dialogs import AskPath, ask_path
from ui.services.context import Services
from ui.style.theme import Meaning, Space
from ui.widgets.controls import Shortcut, in_column, in_row, named, scroll_area
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.number_line import NumberKind, NumberLine, WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

# The finest that a profile's number may be.
_STEP: Final = 0.0001


class ManualEditor(QWidget):
    """One manual check: its text, and whether it is required. Without a text there is none."""

    def __init__(self, number: int, line: ManualLine, on_edit: Callable[[], None]) -> None:
        super().__init__()
        name = f"profile_manual_{number}"
        self.setObjectName(name)
        self.text = named(QLineEdit(line.text), f"{name}_text")
        self.text.setAccessibleName(f"{tr('Manual checks')} {number}")
        self.text.setPlaceholderText(tr("Manual checks"))
        self.text.setMaxLength(MAX_NAME_LENGTH)
        self.required = named(QCheckBox(tr("Required")), f"{name}_required")
        self.required.setChecked(line.is_required)
        self.text.textEdited.connect(on_edit)
        self.required.toggled.connect(on_edit)
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
        # As it is in its file, and as the fields show it: without spaces around its texts.
        self._original = self._unedited = Profile(name="")
        self.name, self.airframe = named(QLineEdit(), "profile_name"), named(QLineEdit(), "profile_airframe")
        for line in (self.name, self.airframe):
            line.setMaxLength(MAX_NAME_LENGTH)
            line.textEdited.connect(self.refresh)
        self.activated_by = named(QComboBox(), "profile_activated_by")
        self.activated_by.addItem(tr("a person"), ActivatedBy.PERSON)
        self.activated_by.addItem(tr("the aircraft"), ActivatedBy.AIRCRAFT)
        WheelGuard(self.activated_by)
        self.activated_by.activated.connect(self.refresh)
        self.service = named(QCheckBox(tr("Overdue service is NO-GO")), "profile_service")
        self.service.toggled.connect(self.refresh)
        titles = {check.id: tr(check.title) for check in CHECKS}
        # Empty, the program's own limit holds, which stands there in grey.
        self.limits: dict[str, NumberLine] = {}
        for name, limit in LIMITS.items():
            kind = NumberKind.of(limit.low, limit.high, _STEP, limit.shown.partition("}")[2].strip())
            title = f"{titles[limit.check]} {'≤' if limit.is_maximum else '≥'}"
            self.limits[name] = self._field(f"profile_limit_{name}", title, tr(limit.why), kind)
            self.limits[name].setPlaceholderText(kind.with_unit(limit.usual))
        days = NumberKind.of(1, MAX_TEST_DAYS, 1, tr("days"))
        self.tests = {
            test.kind: self._field(f"profile_test_{test.kind.value}", tr(TITLES[test.kind]), tr("Not older than"), days)
            for test in GUIDED_TESTS
        }
        # The last one is empty: a new check is typed there.
        self.manual: list[ManualEditor] = []
        self.strip = named(NoticeBar(), "profile_editor_notice")
        self.cancel = named(QPushButton(tr("Cancel")), "profile_cancel")
        self.save_as = named(QPushButton(tr("Save as…")), "profile_save_as")
        self.save = named(QPushButton(tr("Save")), "profile_save", "primary")
        self.cancel.clicked.connect(self.close_editor)
        self.save_as.clicked.connect(self.choose_and_save)
        self.save.clicked.connect(self._save)
        Shortcut(self.save, "Ctrl+S")
        self._lay_out()
        VisibilityTimer(self, self.refresh)

    def _field(self, name: str, title: str, why: str, kind: NumberKind) -> NumberLine:
        field = named(NumberLine(kind, start=float(kind.low), may_be_empty=True), name)
        field.setAccessibleName(title + in_brackets(kind.unit) if kind.unit else title)
        field.setToolTip(why)
        field.edited.connect(self.refresh)
        return field

    # What is edited

    def edit(self, profile: Profile | None, path: Path | None) -> None:
        """`profile` None: a new one. `path`: its file."""
        self._original, self._path = profile or Profile(name=""), path
        original = self._original
        self.name.setText(original.name)
        self.airframe.setText(original.airframe)
        self.activated_by.setCurrentIndex(self.activated_by.findData(original.activated_by))
        self.service.setChecked(original.is_service_required)
        for name, field in self.limits.items():
            field.show_number(original.limits.get(name))
        for kind, field in self.tests.items():
            field.show_number(original.tests_within_days.get(kind))
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
        numbers = {name: field.number for name, field in self.limits.items()}
        limits = {name: int(one) if one.is_integer() else one for name, one in numbers.items() if one is not None}
        tests = {kind: int(field.number) for kind, field in self.tests.items() if field.number is not None}
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
        return self.profile != self._unedited or self._wrong_number() is not None

    def _wrong_number(self) -> NumberLine | None:
        return next((field for field in (*self.limits.values(), *self.tests.values()) if field.is_wrong), None)

    def refresh(self) -> None:
        if len(self.manual) < MAX_ITEMS and (not self.manual or self.manual[-1].line.text):
            self._add_manual(ManualLine(""))
        # Why a file with this content would be refused, or would not hold what is typed.
        fault, wrong = "", self._wrong_number()
        if wrong is not None:
            fault = labelled(wrong.accessibleName(), wrong.kind.range_text)
        else:
            try:
                parse_profile(profile_text(self.profile).encode("utf-8", "surrogatepass"))
            except ProfileRefused as refusal:
                fault = refusal.sentence
        if fault:
            self.strip.show_notice(Notice(Meaning.ATTENTION, fault))
        elif self.strip.notice is not None and not self.strip.notice.choices:
            self.strip.show_notice(None)
        self.save.setEnabled(not fault and (self.is_edited or self._path is None))
        self.save_as.setEnabled(not fault)

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
        else:
            notice = Notice(Meaning.DANGER, fault.translated(), dismiss=lambda: self.strip.show_notice(None))
            self.strip.show_notice(notice)

    def _add_manual(self, line: ManualLine) -> None:
        row = ManualEditor(len(self.manual) + 1, line, self.refresh)
        self.manual.append(row)
        self._manual_rows.addWidget(row)

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        for title, line in (
            (tr("Name"), self.name),
            (tr("Airframe"), self.airframe),
            (tr("Activated by"), self.activated_by),
        ):
            form.addRow(title, line)
            line.setAccessibleName(title)
        for title, group in ((tr("Limits"), self.limits.values()), (tr("Guided tests"), self.tests.values())):
            form.addRow(named(QLabel(title), "profile_caption", "caption"))
            for field in group:
                form.addRow(field.accessibleName(), field)
        manual, content = QWidget(), named(QWidget(), "profile_editor_content")
        self._manual_rows = in_column(of=manual, spacing=Space.XS, margins=0)
        caption = named(QLabel(tr("Manual checks")), "profile_manual_caption", "caption")
        in_column(form, self.service, caption, manual, 1, of=content, spacing=Space.S, margins=(Space.M, 0))
        scroll = scroll_area(content, "profile_editor_scroll", tr("Profile"), is_vertical=True)
        foot = in_row(1, self.cancel, self.save_as, self.save, spacing=Space.S, margins=(Space.M, Space.S))
        heading = in_row(named(QLabel(tr("Profile")), "profile_title", "title"), margins=(Space.M, 0, 0, Space.S))
        in_column(heading, (scroll, 1), self.strip, foot, of=self, spacing=0, margins=0)
