"""Editor of a profile: limits of the pre-flight check, guided tests, manual checks.

The profile's settings are edited on the Settings page. A profile is valid where its file could be read again.
"""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFrame, QLabel, QLineEdit, QPushButton, QWidget

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
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.layouts import FlowRow, captioned_row, in_column, in_row, scroll_area
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.number_line import NumberKind, NumberLine
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_STEP = 0.0001
"""The finest that a profile's number may be."""
_NUMBER_PX = 120


class OptionalNumber(QWidget):
    """A number with a check box; `value` is None while it is not checked, or where what is typed cannot be used."""

    changed = Signal()

    def __init__(
        self, name: str, default: float, low: float, high: float, *, unit: str = "", step: float = _STEP
    ) -> None:
        super().__init__()
        self.setObjectName(name)
        self._default = default
        self.tick = named(QCheckBox(), f"{name}_tick")
        self.box = named(NumberLine(NumberKind.of(low, high, step, unit.strip()), start=default), f"{name}_value")
        self.box.setMinimumWidth(_NUMBER_PX)
        self.unit = named(QLabel(unit.strip()), f"{name}_unit", "muted")
        self.range = named(QLabel(), f"{name}_range", "danger")
        self.range.hide()
        self.tick.toggled.connect(self._on_tick)
        self.box.edited.connect(self._on_edit)
        in_row((self.tick, 1), self.range, self.box, self.unit, of=self, spacing=Space.S, margins=0)
        self.show_value(None)

    @property
    def value(self) -> float | int | None:
        number = self.box.number if self.tick.isChecked() else None
        if number is None:
            return None
        return int(number) if number.is_integer() else number

    @property
    def is_wrong(self) -> bool:
        return self.tick.isChecked() and self.box.is_wrong

    def show_value(self, value: float | None) -> None:
        with QSignalBlocker(self.tick):
            self.tick.setChecked(value is not None)
        self.box.show_number(self._default if value is None else value)
        self.box.setEnabled(value is not None)
        self._show_range()

    def show_title(self, title: str, why: str) -> None:
        self.tick.setText(title)
        self.tick.setToolTip(why)
        self.tick.setAccessibleName(title)
        self.box.setAccessibleName(title)
        self.box.setToolTip(why)

    def _on_tick(self, is_on: bool) -> None:
        self.box.setEnabled(is_on)
        if not is_on:
            self.box.show_number(self._default)
        self._on_edit()

    def _on_edit(self) -> None:
        self._show_range()
        self.changed.emit()

    def _show_range(self) -> None:
        self.range.setText(self.box.kind.range_text if self.is_wrong else "")
        self.range.setVisible(self.is_wrong)


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


SUFFIX: Final = ".toml"
_USUAL_TEST_DAYS: Final = 180
_CHECK_TITLES: Final = {check.id: check.title for check in CHECKS}
_ACTIVATED: Final = {ActivatedBy.PERSON: marked("a person"), ActivatedBy.AIRCRAFT: marked("the aircraft")}


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
        self.title = named(QLabel(), "profile_editor_title", "title")
        self.name = control(QLineEdit(), "profile_editor_name", says=tr("Name"))
        self.airframe = control(QLineEdit(), "profile_editor_airframe", says=tr("Airframe"))
        for line in (self.name, self.airframe):
            line.setMaxLength(MAX_NAME_LENGTH)
            line.textEdited.connect(self.refresh)
        self.activated_by = control(QComboBox(), "profile_editor_activated_by", says=tr("Activated by"))
        self.service = named(QCheckBox(tr("Overdue service is NO-GO")), "profile_editor_service")
        self.service.toggled.connect(self.refresh)
        for who in _ACTIVATED:
            self.activated_by.addItem("", who)
        WheelGuard(self.activated_by)
        self.activated_by.activated.connect(self.refresh)
        self.limits = {
            name: OptionalNumber(f"profile_limit_{name}", limit.usual, limit.low, limit.high,
                                 unit=limit.shown.partition("}")[2])
            for name, limit in LIMITS.items()
        }  # fmt: skip
        days = _USUAL_TEST_DAYS, 1, MAX_TEST_DAYS
        self.tests = {
            test.kind: OptionalNumber(f"profile_test_{test.kind.value}", *days, step=1) for test in GUIDED_TESTS
        }
        for number in (*self.limits.values(), *self.tests.values()):
            number.changed.connect(self.refresh)
        self.manual: list[ManualEditor] = []
        """The last one is empty: a new check is typed there."""
        self.strip = named(NoticeBar(), "profile_editor_notice")
        self.cancel = control(QPushButton(tr("Cancel")), "profile_editor_cancel", key="Esc", slot=self.close_editor)
        self.save_as = control(QPushButton(tr("Save as…")), "profile_editor_save_as", slot=self.choose_and_save)
        self.save = control(
            QPushButton(tr("Save")),
            "profile_editor_save",
            keys="Ctrl+S",
            picture=Icon.SAVE,
            role="primary",
            slot=self._save,
        )
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

    def _wrong_numbers(self) -> list[OptionalNumber]:
        return [number for number in (*self.limits.values(), *self.tests.values()) if number.is_wrong]

    def refresh(self) -> None:
        self.title.setText(tr("Profile"))
        for name, number in self.limits.items():
            limit = LIMITS[name]
            title = f"{tr(_CHECK_TITLES[limit.check])} {'≤' if limit.is_maximum else '≥'}"
            number.show_title(title, tr(limit.why))
        for test in GUIDED_TESTS:
            number = self.tests[test.kind]
            number.show_title(tr(TITLES[test.kind]), tr("Not older than"))
            number.unit.setText(tr("days"))
        for place, who in enumerate(_ACTIVATED.values()):
            self.activated_by.setItemText(place, tr(who))
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
        self.strip.show_notice(self._unsaved_notice())

    def _unsaved_notice(self) -> Notice:
        keep = Choice("keep", tr("Cancel"), lambda: self.strip.show_notice(None))
        discard = Choice("discard", tr("Discard edits"), self.closed.emit, is_step=True)
        return Notice(Meaning.ATTENTION, tr("Unsaved edits."), (keep, discard))

    def choose_and_save(self) -> None:
        suggested = self._path or self._preferences.profile_folder / f"profile{SUFFIX}"
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

    # Construction

    def _lay_out(self) -> None:
        head = captioned_row(
            (tr("Name"), self.name),
            (tr("Airframe"), self.airframe),
            (tr("Activated by"), self.activated_by),
        )
        manual = QWidget()
        self._manual_rows = in_column(of=manual, spacing=Space.XS, margins=0)
        content = named(QWidget(), "profile_editor_content")
        in_column(
            head, self._caption("limits", marked("Limits")), _card("profile_limits", self.limits.values()),
            self._caption("tests", marked("Guided tests")), _card("profile_tests", self.tests.values()), self.service,
            self._caption("manual", marked("Manual checks")), manual, 1,
            of=content, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S),
        )  # fmt: skip
        scroll = scroll_area(content, "profile_editor_scroll", tr("Profile"))
        top = in_row(self.title, margins=(Space.M, Space.S))
        foot = in_row(
            1, self.cancel, self.save_as, self.save, spacing=Space.S, margins=(Space.M, Space.XS, Space.M, Space.S)
        )
        in_column(top, (scroll, 1), self.strip, foot, of=self, spacing=0, margins=0)

    def _caption(self, name: str, english: str) -> QLabel:
        return named(QLabel(tr(english)), f"profile_editor_{name}", "caption")


def _card(name: str, numbers: Iterable[OptionalNumber]) -> QFrame:
    card = named(QFrame(), name, "card")
    FlowRow(*numbers, of=card, margins=(Space.M, Space.S), is_even=True)
    return card
