"""The panel that edits a profile: limits, guided tests, manual checks. Its settings are edited on the Settings page."""

from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QLabel, QLineEdit, QPushButton, QWidget

from app.guided.results import TITLES, GuidedKind
from app.preflight.checks import CHECKS
from app.settings import profile_file
from app.settings.profile_file import ProfileRefused
from app.settings.profiles import LIMITS, NO_PROFILE, ActivatedBy, ManualLine, Profile
from app.text.i18n import tr
from app.text.messages import in_brackets, not_written
from ui.files.file_dialogs import AskPath, ask_path
from ui.services.page import PageHeader
from ui.style.theme import Meaning, Space
from ui.widgets.controls import Shortcut, in_column, in_row, named, scroll_area
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Choice, Notice
from ui.widgets.number_line import NumberKind, NumberLine, WheelGuard


class ProfileEditor(QWidget):
    """The editor of a profile, made again for each one. `closed` has the path it was saved to, or None."""

    closed = Signal(object)

    def __init__(self, profile: Profile | None, path: Path | None, folder: Path) -> None:
        super().__init__()
        self.setObjectName("profile_editor")
        self.ask_save: AskPath = ask_path
        self._path, self._folder = path, folder
        one = self._original = profile or NO_PROFILE
        content = named(QWidget(), "profile_editor_content")
        self._form = QFormLayout(content)
        self._form.setContentsMargins(Space.M, Space.XS, Space.M, Space.S)
        self._form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self._form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        self.name, self.airframe = QLineEdit(one.name), QLineEdit(one.airframe)
        self.activated_by = QComboBox()
        self.activated_by.addItems([tr("a person"), tr("the aircraft")])  # in the order of `ActivatedBy`
        self.activated_by.setCurrentIndex(list(ActivatedBy).index(one.activated_by))
        WheelGuard(self.activated_by)
        for key, title, field in (
            ("name", tr("Name"), self.name),
            ("airframe", tr("Airframe"), self.airframe),
            ("activated_by", tr("Activated by"), self.activated_by),
        ):
            self._form.addRow(title, named(field, f"profile_{key}", says=title))
        self.service = named(QCheckBox(tr("Overdue service is NO-GO")), "profile_service")
        self.service.setChecked(one.is_service_required)
        self._form.addRow(self.service)
        self._form.addRow(named(QLabel(tr("Limits")), "profile_caption", "caption"))
        self.limits: dict[str, NumberLine] = {}
        titles = {check.id: tr(check.title) for check in CHECKS}
        for name, limit in LIMITS.items():
            # In steps finer than any of use, so that what a file says is kept as it is.
            kind = NumberKind.of(limit.low, limit.high, 0.0001, limit.shown.partition("}")[2].strip(), 4)
            title = f"{titles[limit.check]} {'≤' if limit.is_maximum else '≥'}"
            most = limit.shown.format(limit.high)
            line = self.limits[name] = self._add_number(f"profile_limit_{name}", title, kind, f"{limit.low:g}", most)
            line.setPlaceholderText(limit.shown.format(limit.usual))  # what holds while it is empty
            line.show_text(f"{one.limits[name]:.10g}" if name in one.limits else "")
        self._form.addRow(named(QLabel(tr("Guided tests")), "profile_caption", "caption"))
        days = NumberKind.of(1, profile_file.MAX_TEST_DAYS, 1, tr("days"), 0)
        self.tests: dict[GuidedKind, NumberLine] = {}
        for test, title in TITLES.items():
            most = f"{profile_file.MAX_TEST_DAYS} {days.unit}"
            line = self.tests[test] = self._add_number(f"profile_test_{test.value}", f"{tr(title)} ≤", days, "1", most)
            line.show_number(one.tests_within_days.get(test))
        self._form.addRow(named(QLabel(tr("Manual checks")), "profile_manual_caption", "caption"))
        self.manual: list[tuple[QLineEdit, QCheckBox]] = []
        for item in one.manual:
            self._add_manual(item)
        self.strip = named(NoticeBar(), "profile_editor_notice")
        self.cancel = named(QPushButton(tr("Cancel")), "profile_cancel")
        self.save_as = named(QPushButton(tr("Save as…")), "profile_save_as")
        self.save = named(QPushButton(tr("Save")), "profile_save", "primary")
        for text in (self.name, self.airframe):
            text.textEdited.connect(self.refresh)
        self.activated_by.activated.connect(self.refresh)
        self.service.toggled.connect(self.refresh)
        self.cancel.clicked.connect(self.close_editor)
        self.save_as.clicked.connect(self._choose_and_save)
        self.save.clicked.connect(lambda: self._choose_and_save() if path is None else self._save_to(path))
        Shortcut(self.save, "Ctrl+S")
        heading = in_row(PageHeader("profile", tr("Profile")), margins=(Space.M, 0))
        scroll = scroll_area(content, "profile_editor_scroll", tr("Profile"), is_vertical=True)
        foot = in_row(1, self.cancel, self.save_as, self.save, spacing=Space.S, margins=(Space.M, Space.XS))
        in_column(heading, (scroll, 1), self.strip, foot, of=self, spacing=0, margins=0)
        self._unedited = self.profile
        self.refresh()

    def _add_number(self, name: str, title: str, kind: NumberKind, least: str, most: str) -> NumberLine:
        line = named(NumberLine(kind, may_be_empty=True), name, says=title)
        span = tr("{low} to {high}", low=least, high=most)
        line.setAccessibleDescription(span)
        line.edited.connect(self.refresh)
        self._form.addRow(title + in_brackets(span), line)
        return line

    def _add_manual(self, item: ManualLine) -> None:
        number = len(self.manual) + 1
        says = f"{tr('Manual checks')} {number}"
        text = named(QLineEdit(item.text), f"profile_manual_{number}_text", says=says)
        required = named(QCheckBox(tr("Required")), f"profile_manual_{number}_required")
        required.setChecked(item.is_required)
        text.textEdited.connect(self.refresh)
        required.toggled.connect(self.refresh)
        self._form.addRow(in_row((text, 1), required, spacing=Space.S))
        if self.manual:  # else Tab would reach it after the buttons
            self.setTabOrder(self.manual[-1][1], text)
            self.setTabOrder(text, required)
        self.manual.append((text, required))

    @property
    def profile(self) -> Profile:
        lines = (ManualLine(text.text().strip(), required.isChecked()) for text, required in self.manual)
        return self._original._replace(
            name=self.name.text().strip(),
            airframe=self.airframe.text().strip(),
            activated_by=list(ActivatedBy)[self.activated_by.currentIndex()],
            is_service_required=self.service.isChecked(),
            limits={name: line.number for name, line in self.limits.items() if line.number is not None},
            tests_within_days={test: int(line.number) for test, line in self.tests.items() if line.number is not None},
            manual=tuple(line for line in lines if line.text),
        )

    def refresh(self) -> None:
        if len(self.manual) < profile_file.MAX_ITEMS and (not self.manual or self.manual[-1][0].text().strip()):
            self._add_manual(ManualLine(""))  # one more is typed there
        lines = (*self.limits.values(), *self.tests.values())
        # Said also where the field is out of sight.
        wrong = [one.accessibleName() + in_brackets(one.accessibleDescription()) for one in lines if one.is_wrong]
        self.strip.show_notices([Notice(Meaning.ATTENTION, wrong[0])] if wrong else [])
        self.setWindowModified(bool(wrong) or self.profile != self._unedited)  # closing the window asks, too
        self.save.setEnabled(not wrong and (self.isWindowModified() or self._path is None))
        self.save_as.setEnabled(not wrong)

    def close_editor(self) -> None:
        keep = Choice("keep", tr("Cancel"), self.refresh)
        discard = Choice("discard", tr("Discard edits"), lambda: self.closed.emit(None), is_step=True)
        if self.isWindowModified():
            self.strip.show_notices([Notice(Meaning.ATTENTION, tr("Unsaved edits."), (keep, discard))])
        else:
            self.closed.emit(None)

    def _choose_and_save(self) -> None:
        suggested = self._path or self._folder / "profile.toml"
        self.ask_save(self, tr("Save as profile…"), suggested, "*.toml", self._save_to)

    def _save_to(self, path: Path) -> None:
        if self._path is not None:
            with suppress(ProfileRefused):  # another page may have written its settings meanwhile
                self._original = profile_file.read_profile(self._path)
        profile = self.profile
        try:
            profile_file.save_profile(path, profile._replace(name=profile.name or path.stem), source=self._path)
        except (ProfileRefused, OSError, ValueError) as error:
            self.strip.show_notices([Notice(Meaning.DANGER, not_written(path, error), dismiss=self.refresh)])
        else:
            self.closed.emit(path)
