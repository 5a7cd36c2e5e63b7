"""Tests page: the guided tests at the left, the chosen one at the right, step by step.

Leaving the page during a test (another page, a closed or minimised window, a program error) ends the test, and locks
the module if the test may have made it active.
"""

import json
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, QTimer
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QFrame,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QSizePolicy,
    QStackedLayout,
    QWidget,
)

from app.guided.catalogue import GUIDED_TESTS
from app.guided.results import TITLES, GuidedKind, GuidedResult
from app.modules.labels import A4
from app.procedures.act import Performed
from app.procedures.lock import SENTENCES
from app.records.report import guided_html
from app.records.report_files import check_target, is_report
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.last_known import Activation
from app.safety.ritual import Input
from app.system.files import write_whole
from app.text.i18n import tr
from app.text.json_objects import object_in
from app.text.messages import clean
from protocol.translatable import marked
from ui.acts.act_row import ActRow
from ui.acts.ritual_guard import RitualGuard
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.files.report_printer import print_pages
from ui.pages.tests.widgets import (
    VERDICT_MEANINGS,
    GuidedPicture,
    ResultView,
    StepList,
    instruction,
    last_text,
    live_caption,
    show_live,
)
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, WaysBack
from ui.session.guided import FAILED, Guided, Stage
from ui.session.module_field import ModuleField
from ui.session.shown_module import ShownModule
from ui.style.icons import MEANING_ICONS, Icon, icon, set_icon_size
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area, stacked
from ui.widgets.notice_bar import Notice, NoticeBar
from ui.widgets.readout import Readout
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 100
MAX_NAME_LENGTH: Final = 80
_LIST_PX: Final = 196
_STEPS_PX: Final = 660
"""Beside the list, whose names may be elided for it."""
_FIELD_PX: Final = 148


class TestsPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("tests")
        self._services, self._ports = services, services.ports
        self._guard = RitualGuard(self)
        self._watched: QWidget | None = None
        self.list = control(QListWidget(), "tests_list", says=tr("Guided tests"))
        self.who = control(QLineEdit(), "tests_who", says=tr("Tested by"))
        self.who.setMaxLength(MAX_NAME_LENGTH)
        self.name_field = ModuleField("tests_module", services.ports)
        self.name_field.setMinimumContentsLength(10)
        self.known_by = text_label("tests_known_by", "small")
        self.title = named(ElidedLabel(), "tests_chosen", "title")
        self.picture, self.steps = GuidedPicture(), StepList()
        self.instruction = text_label("tests_instruction", "title")
        self.safety = text_label("tests_safety")
        self.made_safe = control(QCheckBox(), "tests_made_safe", about=tr("The test makes the module fire."))
        self.activate = ActRow(services, Act.ACTIVATE, place="tests")
        self.live = named(Readout("", template="00.0 V"), "tests_live")
        self.result = ResultView()
        self.notice_bar = named(NoticeBar(), "tests_said")
        self.cancel = control(
            StepButton(tr("Cancel"), is_safe=True),
            "tests_cancel",
            tip=tr("Locks an activated module"),
            key="Esc",
            slot=self._cancel,
        )
        self.primary = control(
            StepButton(tr("Start"), is_safe=True), "tests_run", keys="Ctrl+Return", role="primary", slot=self._continue
        )
        self.ask_path: AskPath = ask_path
        self.export = control(
            QPushButton(tr("Export report…")), "tests_export", keys="Ctrl+P", picture=Icon.SAVE, slot=self._export
        )
        self.exporting = self.export
        self.exported = JobNotice(self)
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self.tick, hidden=self._cancel)
        self._lay_out()
        self._wire()

    @property
    def work(self) -> Guided:
        """Of the module shown."""
        return self.module.guided

    def show_module(self, module: ShownModule) -> None:
        if self._module is not None:
            self._module.guided.cancel()
            self._module.guided.changed.disconnect(self._on_work)
        super().show_module(module)
        module.guided.who = self._services.preferences.who
        module.guided.changed.connect(self._on_work)
        module.guided.load_last()
        self._on_work()

    def _cancel(self) -> None:
        if self._module is not None:
            self.work.cancel()

    # Display

    def refresh(self) -> None:
        self._show_list()
        self._show_stage()
        self.tick()

    def tick(self) -> None:
        """Update what changes by itself."""
        work = self.work
        if work.is_running:
            show_live(self.live, work, self._ports)
        if work.stage is Stage.CONFIRMING:
            self.activate.refresh()
        self.notice_bar.show_notice(self._notice())
        self.primary.setEnabled(self._can_continue)

    @property
    def _can_continue(self) -> bool:
        work = self.work
        is_asked_again = work.stage is Stage.DONE and bool(work.test.statement) and not work.owes_lock
        return work.can_start or bool(work.confirm_words) or is_asked_again

    def _show_list(self) -> None:
        for row, test in enumerate(GUIDED_TESTS):
            item, last = self.list.item(row), self.work.last.get(test.kind)
            title, when = tr(TITLES[test.kind]), last_text(last)
            item.setText(f"{title}\n{when}")
            item.setData(Qt.ItemDataRole.AccessibleTextRole, f"{title}: {when}")
            item.setToolTip(f"{title}: {when}")
            meaning = Meaning.UNKNOWN if last is None else VERDICT_MEANINGS[last.verdict]
            item.setIcon(icon(MEANING_ICONS[meaning], meaning))
        with QSignalBlocker(self.list):
            self.list.setCurrentRow([test.kind for test in GUIDED_TESTS].index(self.work.kind))
        self.list.setEnabled(not self.work.is_running)
        self.export.setEnabled(bool(self.work.last) and not self.work.is_running)
        self.known_by.setText(self.module.known_by.translated())

    def _show_stage(self) -> None:
        work, test = self.work, self.work.test
        self.title.setText(tr(TITLES[test.kind]))
        steps = tuple(step.translated() for step in test.steps)
        step, text = work.step, instruction(work)
        number = min(step, len(steps) - 1)
        is_level = work.stage is Stage.MEASURING and text != steps[number]  # before and after a tilt
        self.picture.show_step(work.kind, 0 if is_level else number, text if is_level else steps[number])
        self.steps.show_steps(steps, step, is_running=work.is_running)
        self.live.set_caption(live_caption(work.kind))
        if text != self.instruction.text():
            self.instruction.setText(text)
            self.instruction.setAccessibleName(text)  # screen readers tell a new one
        self.instruction.setVisible(bool(text))
        self.title.setVisible(not text)  # the list shows which test it is
        self._show_safety()
        places = {Stage.READY: self._ready, Stage.PREPARING: self.live, Stage.MEASURING: self.live}
        place = self._act_corner if work.stage is Stage.CONFIRMING else places.get(work.stage, self._ready)
        if place is self._act_corner and self._region.currentWidget() is not place:
            QTimer.singleShot(0, self, lambda: self._scroll.ensureWidgetVisible(self._act_corner))
        self._region.setCurrentWidget(place)
        is_done = work.stage is Stage.DONE
        self._doing.setVisible(not is_done)
        self.result.setVisible(is_done)
        self.result.show_outcome(work.outcome)
        self._name_buttons()
        for field in (self.who, self.name_field):
            field.setEnabled(not work.is_running)

    def _on_work(self) -> None:
        if self.work.stage is Stage.CONFIRMING:
            self._guard.begin()
        elif not self.work.is_running:
            self._guard.end()
        if self.isVisible():
            self.refresh()

    def _show_safety(self) -> None:
        test = self.work.test
        self.safety.setText(test.precautions)
        meaning = Meaning.DANGER if test.is_active else Meaning.INFORMATION
        self._safety_mark.show_icon(MEANING_ICONS[meaning], meaning)
        self.made_safe.setVisible(bool(test.statement))
        self.made_safe.setText(tr(test.statement) if test.statement else "")
        with QSignalBlocker(self.made_safe):
            self.made_safe.setChecked(self.work.is_stated_safe)

    def _name_buttons(self) -> None:
        work = self.work
        words = {Stage.READY: marked("Start"), Stage.DONE: marked("Test again")}.get(work.stage, marked("Next"))
        words = work.confirm_words or words
        self.primary.setText(tr(words))
        self.cancel.setEnabled(work.is_running)
        self.primary.setEnabled(self._can_continue)
        if self.isVisible() and self.primary.isEnabled() and QApplication.focusWidget() is None:
            self.primary.setFocus()

    def _notice(self) -> Notice | None:
        work, lock = self.work, self._ports.current.lock
        locking = lock.notice()
        if locking is not None:
            return locking
        if self.module.activation.state is Activation.ACTIVE and not work.is_running:
            return Notice(Meaning.DANGER, tr("The module is ACTIVE: lock it first."))
        exported = None if work.is_running else self.exported.result_notice()
        if exported is not None:
            return exported
        if work.stage is Stage.DONE and lock.is_reported and work.test.is_active:
            # No success beside a test that was cancelled or has failed.
            return Notice(Meaning.INFORMATION, tr(SENTENCES[Outcome.CONFIRMED]))
        if work.trouble is not None:
            return Notice(Meaning.ATTENTION, work.trouble)
        if work.stage is not Stage.DONE or not isinstance(work.outcome, GuidedResult):
            return None
        if not work.tested_as:
            return Notice(Meaning.ATTENTION, tr("Without a name the result counts for no check."))
        if work.tested_as != self.module.name:
            return Notice(Meaning.ATTENTION, tr("The result is that of {module}.", module=work.tested_as))
        return None

    # What a person does

    def _choose(self, row: int) -> None:
        if 0 <= row < len(GUIDED_TESTS):
            self.work.choose(GUIDED_TESTS[row].kind)

    def _state_safe(self, is_safe: bool) -> None:
        self.work.state_safe(is_safe)

    def _act_begun(self) -> None:
        self.work.act_begun()

    def _act_ended(self, done: Performed | None) -> None:
        self.work.act_ended(done)

    def _continue(self) -> None:
        if self.work.stage is Stage.DONE and self.work.test.statement:
            self.work.choose(self.work.kind)  # the statement has to be made again
        elif self.work.confirm_words:
            self.work.confirm()
        else:
            self._commit_names()
            self.work.start()

    def _export(self) -> None:
        """The last result of each test of this module."""
        module = self.module.name
        tests = [test.plain() for test in self.work.last.values()]
        suggested = Path.home() / default_name(module, ".pdf", datetime.now().astimezone())
        self.ask_path(self, tr("Export report…"), suggested, "*.pdf", partial(self._write_report, module, tests))

    def _write_report(self, module: str, tests: list[dict[str, object]], path: Path) -> None:
        def write() -> None:
            check_target(path, _may_replace)
            plain = json.dumps({"module": module, "tests": tests}, ensure_ascii=False, indent=1, allow_nan=False)
            write_whole(path.with_suffix(".json"), f"{plain}\n".encode())
            write_whole(path, print_pages([guided_html(module, tests)], A4))

        self.exported.write_file(path, write, beside=".json")

    def _commit_names(self) -> None:
        self.name_field.apply()
        self._services.preferences.who = self.work.who = clean(self.who.text().strip())

    def go_to(self, view: str) -> None:
        """`view`: the name of a test."""
        self._choose([test.kind for test in GUIDED_TESTS].index(GuidedKind(view)))

    def ways_back(self) -> WaysBack:
        return ((self.work.is_running, self.work.cancel),)

    def fit(self) -> None:
        for widget in (self.list, self.known_by):
            widget.setFixedWidth(max(_LIST_PX, min(scaled(_LIST_PX), self.width() - _STEPS_PX)))

    # Leaving the page

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        window = self.window()
        if self._watched is not window:
            window.installEventFilter(self)
            self._watched = window
        self.who.setText(self._services.preferences.who)
        self.work.load_last()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        is_minimised = event.type() == QEvent.Type.WindowStateChange and self.window().isMinimized()
        if watched is self._watched and (event.type() == QEvent.Type.Close or is_minimised):
            self.work.cancel()
        return False

    def _on_broken(self, why: Input) -> None:
        """Only a program error ends a test; another window in front does not, as the hands are on the module."""
        if why is Input.FAILED:
            self.work.cancel(FAILED)

    # Construction

    def _wire(self) -> None:
        self.list.currentRowChanged.connect(self._choose)
        self.made_safe.toggled.connect(self._state_safe)
        self.who.editingFinished.connect(self._commit_names)
        self.activate.begun.connect(self._act_begun)
        self.activate.ended.connect(self._act_ended)
        self._guard.broken.connect(self._on_broken)

    def _lay_out(self) -> None:
        set_icon_size(self.list, 18)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setSpacing(2)
        for _test in GUIDED_TESTS:
            self.list.addItem(QListWidgetItem())
        header = self.make_header(tr("Tests"))
        for caption, field in ((marked("Tested by"), self.who), (marked("Module"), self.name_field)):
            label = named(QLabel(tr(caption)), f"{field.objectName()}_caption", "small")
            label.setBuddy(field)
            field.setMinimumWidth(_FIELD_PX)
            field.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
            both = QWidget()
            in_row(label, field, of=both, spacing=Space.S, margins=0)
            header.add(both)
        self._make_step_area()
        content = named(QWidget(), "tests_content")
        in_column(self._doing, self.result, of=content, spacing=0, margins=0)
        scroll = self._scroll = scroll_area(content, "tests_scroll", tr("Guided tests"))
        foot = in_row(self.export, 1, self.cancel, self.primary, spacing=Space.S)
        pane = in_column(self.title, self.instruction, (scroll, 1), self.notice_bar, foot, spacing=Space.S)
        body = in_row(in_column((self.list, 1), self.known_by, spacing=Space.S), (pane, 1), spacing=Space.M)
        in_column(header, (body, 1), of=self, spacing=0, margins=(Space.M, 0, Space.M, Space.S))

    def _make_step_area(self) -> None:
        """What the stage needs, first of all what makes it safe; below it picture and steps."""
        self._safety_mark = IconLabel("tests_safety_mark", 20)
        self._ready = named(QFrame(), "tests_ready", "card")
        words = in_column(self.safety, self.made_safe, 1, spacing=Space.S, margins=0)
        in_row((self._safety_mark, Qt.AlignmentFlag.AlignTop), (words, 1), of=self._ready, spacing=Space.S,
               margins=Space.M)  # fmt: skip
        self._act_corner = named(QFrame(), "tests_act", "danger-corner")
        in_column(self.activate, of=self._act_corner, margins=2)
        set_role(self.activate, "")  # no line below it
        self._region = stacked(QStackedLayout(), self._ready, self.live, self._act_corner)
        top = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.steps, 1), spacing=Space.S)
        self._doing = named(QWidget(), "tests_doing")
        in_column(self._region, top, 1, of=self._doing, spacing=Space.M, margins=0)


def _may_replace(data: bytes) -> bool:
    """The dialog asked about the report; beside it only results of guided tests may be replaced."""
    return is_report(data) or object_in(data).keys() == {"module", "tests"}
