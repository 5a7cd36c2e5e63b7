"""Pre-flight page: verdict, form, one row per check, one main button.

The verdict is watched as long as the program runs; what voids it is announced at once, also while the page is hidden.
"""

from dataclasses import replace
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QPushButton, QStackedLayout, QWidget

from app.preflight.findings import Person
from app.records.checks import document_of
from app.records.record import stored_record
from app.safety.acts import Act
from app.settings.profile_file import save_or_say_why_not
from app.store.fact_store import Store
from app.text.i18n import tr
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from ui.acts.act_row import ActRow
from ui.pages.preflight.check_history import CheckHistory
from ui.pages.preflight.check_list import CheckList
from ui.pages.preflight.controller import PreflightController
from ui.pages.preflight.form import PreflightForm
from ui.pages.preflight.profile_editor import ProfileEditor
from ui.pages.preflight.record_files import SUFFIXES, RecordFiles
from ui.pages.preflight.row import LOCK_AND_ENABLE, Mend, Remedy
from ui.pages.preflight.verdict import HEIGHT_PX, SPOKEN, VerdictBanner, announcement, low_px
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, PageHeader, WaysBack
from ui.session.check import PASSED, Standing
from ui.session.shown_module import ShownModule
from ui.simulator.panel import rest_offer
from ui.style.accessible_roles import announce
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import Shortcut, control, named, set_role
from ui.widgets.layouts import FlowRow, in_column, in_row, stacked
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer


class PreflightButtons(QWidget):
    """Makes the next step the primary button: enable and check, start, check again, or export."""

    def __init__(self, header: PageHeader) -> None:
        super().__init__()
        self.setObjectName("preflight_buttons")
        self.run = control(QPushButton(tr("Start")), "preflight_run", key="Ctrl+Return", picture=Icon.CHECKLIST)
        self._main = self.run
        # Cancel disappears when the check ends: a press that comes too late must not enable anything.
        self.enable = named(StepButton(tr("Enable triggers and check")), "preflight_enable")
        self.cancel = control(StepButton(tr("Cancel"), is_safe=True), "preflight_cancel", key="Esc", picture=Icon.CROSS)
        self.print = control(QPushButton(tr("Export report…")), "preflight_print", keys="Ctrl+P", picture=Icon.SAVE)
        self.history = control(QPushButton(tr("Past checks")), "preflight_history", keys="Ctrl+H", picture=Icon.HISTORY)
        header.add(self.history)
        self.verify = header.add_rare("preflight_verify", tr("Verify a file…"), lambda: None)
        buttons = self.cancel, self.run, self.enable, self.print
        FlowRow(right=buttons, of=self, margins=(Space.M, Space.XS, Space.M, Space.S))

    def press_main(self) -> None:
        """Ctrl+Return is the main button, whichever that is."""
        if self._main.isVisible():
            self._main.click()

    def show_work(self, work: PreflightController) -> None:
        is_checking = work.standing is Standing.CHECKING
        self.run.setEnabled(work.can_check)
        self.enable.setEnabled(work.can_enable)
        self.enable.setText(tr(LOCK_AND_ENABLE if work.needs_lock else "Enable triggers and check"))
        self.print.setEnabled(work.signed is not None)
        # In a new connection a check without enabling the triggers can only end with NO-GO.
        is_enabling = work.can_enable and not work.are_triggers_known
        self._main = self.print if work.standing in PASSED else self.enable if is_enabling else self.run
        for button in (self.run, self.enable, self.print):
            set_role(button, "primary" if button is self._main else "")
        if work.last is not None:
            self.run.setText(tr("Check again"))
        else:
            self.run.setText(tr("Start" if self._main is self.run else "Check only"))
        self.enable.setVisible(not is_checking)
        self.cancel.setVisible(is_checking)


REFRESH_EVERY_MS: Final = 250
_LOW_PAGE_PX: Final = 380
"""A lower page has a lower banner, so that its buttons are in sight."""


class PreflightPage(Page):
    suffixes = SUFFIXES

    def __init__(self, services: Services) -> None:
        super().__init__("preflight")
        self._services, self._ports = services, services.ports
        self.work = PreflightController(services.ports)
        self.result = JobNotice(self)
        self.files = RecordFiles(services.storage, self.result, self)
        self.banner = VerdictBanner()
        self.form = PreflightForm(services, self.result)
        self.activation = ActRow(services, Act.ACTIVATE, place="preflight")
        self.activation.hide()
        self.list = CheckList(services)
        self.history = CheckHistory(services)
        self.editor = ProfileEditor(services)
        self.banner.setWhatsThis(tr("Void after a restart, a lost link, a change, or fifteen minutes."))
        self.strip = named(NoticeBar(), "preflight_notice")
        self.header = self.make_header(tr("Pre-flight"))
        self.buttons = PreflightButtons(self.header)
        self._named = ""
        """For which module ticks and aircraft were entered, by its name."""
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self.tick)
        self._is_print_wanted = False
        """Once the record with the last entries is kept."""
        self._announced = Standing.NOT_CHECKED
        """What was announced last."""
        self._stack = QStackedLayout(self)
        self._check = self._lay_out()
        stacked(self._stack, self._check, self.history, self.editor)
        services.pending_edits.has_profile = lambda: (
            self._stack.currentWidget() is self.editor and self.editor.is_edited
        )
        self._wire()

    def open_file(self, path: Path) -> None:
        """Verify a record or a report that was dropped on the window."""
        if self._stack.currentWidget() is self.editor:
            self.editor.close_editor()
        else:
            self.show_check()
        self.files.verify(path)

    def tick(self) -> None:
        """Update what changes by itself: ages, progress, and whether the verdict still holds."""
        self.work.poll()
        if self.work.standing in (Standing.NOT_CHECKED, Standing.VOID) and self.list.clear_old_ticks():
            self.list.show_work(self.work)
        self.banner.show_announcement(announcement(self.work))
        self.buttons.show_work(self.work)
        self.activation.setVisible(self.work.leads_to_activation)
        if self.work.leads_to_activation:
            self.activation.refresh()
        for row in self.list.rows.values():
            row.act.setEnabled(self.work.can_enable if row.is_enabling else self.work.can_check)
        self.form.setEnabled(self.work.standing is not Standing.CHECKING)

    def refresh(self) -> None:
        self.list.show_work(self.work)
        self.tick()

    # What a person does

    def check(self, stated: Person | None = None, *, is_enabling: bool = False) -> None:
        self.form.commit_edits()
        self.list.clear_old_ticks()
        if self.work.can_check:
            self.result.dismiss()
            self.form.read_again()
            who, aircraft = self.form.committed
            person = replace(stated or Person(), who=who, aircraft=aircraft)
            self.work.check(self.list.answered(), person, is_enabling=is_enabling)

    def enable_and_check(self) -> None:
        """Enable the triggers and check; an active module is locked first, by LOCK's own path."""
        module = self.module

        def check_locked() -> None:
            if self.module is module and not self.work.may_fire:
                self.check(is_enabling=True)

        if self.work.needs_lock:
            self._services.lock.press(then=check_locked)
        else:
            self.check(is_enabling=True)

    def mend(self, remedy: Remedy) -> None:
        """Do what the button of a row says, here or on the page with the control for it."""
        exchange = self._services.exchange
        match remedy.mend:
            case Mend.CHECK:
                self.check(remedy.stated)
            case Mend.ENABLE:
                self.enable_and_check()
            case Mend.NAME:
                self.form.name_field.setFocus()
            case Mend.APPROVE:
                self._approve()
            case Mend.WRITE:
                self.page_wanted.emit("settings")
                exchange.used.emit(remedy.values)
            case Mend.MEASURE:
                self.page_wanted.emit("settings")
                exchange.measured.emit()
            case Mend.REVIEW:
                self.page_wanted.emit("triggers")
                exchange.review_wanted.emit()
            case Mend.TRIGGERS | Mend.TESTS | Mend.SERVICE:
                self.page_wanted.emit(remedy.mend.value)

    def _approve(self) -> None:
        """Keep the code of the checked settings as the approved one in the profile, and check again."""
        assessment, is_read = self.work.assessment, self.form.read_again()
        profile, path = self.form.profile, self.form.path
        if not is_read or profile is None or path is None or assessment is None:
            return
        code = assessment.case.settings_code
        fault = save_or_say_why_not(path, profile._replace(approved_fingerprint=code), source=path)
        if fault is not None:
            self.result.notify(Meaning.DANGER, fault.translated())
            return
        self.form.use_profile(path)
        self.check()

    def print(self) -> None:
        """Export the check that is shown, while it holds; with what was entered just now."""
        self.form.commit_edits()
        self.work.poll()
        signed = self.work.signed
        last = self.work.last
        self._is_print_wanted = signed is None and last is not None and last.is_busy and last.void is None
        if signed is not None:
            self.files.print_record(signed)

    def show_check(self) -> None:
        self._stack.setCurrentWidget(self._check)
        self.refresh()

    def show_history(self) -> None:
        self.history.open()
        self._stack.setCurrentWidget(self.history)

    def edit_profile(self) -> None:
        if self.form.read_again():
            self.editor.edit(self.form.profile, self.form.path)
            self._stack.setCurrentWidget(self.editor)

    def _use_profile(self, path: Path) -> None:
        self.show_check()
        self.form.use_profile(path)

    def _show_result(self) -> None:
        self.strip.show_notice(self.result.result_notice())

    def _export_stored(self, id_: str) -> None:
        """Export a check of the store as it was kept."""
        store = self._services.storage.store
        if not isinstance(store, Store):
            return
        try:
            signed = stored_record(store.read(lambda facts: document_of(facts, id_)))
        except UserError as error:
            self.result.notify(Meaning.DANGER, error.sentence)
            return
        self.show_check()
        self.files.print_record(signed)

    # What happens

    def _on_form(self) -> None:
        self.list.use_profile(self.form.profile)
        self._enter()

    def _enter(self) -> None:
        who, aircraft = self.form.committed
        self.work.enter(self.list.answered(), who=who, aircraft=aircraft)

    def show_module(self, module: ShownModule) -> None:
        """Ticks and aircraft are those of the former module; a name that is said again brings its aircraft back."""
        if self._module is not None:
            self._module.named.disconnect(self._on_named)
            self._module.check_changed.disconnect(self._on_work)
        self.list.clear_ticks()
        self.form.clear_aircraft(self._named)
        self._named = ""
        self._announced = Standing.NOT_CHECKED
        module.named.connect(self._on_named)
        module.check_changed.connect(self._on_work)
        super().show_module(module)

    def _on_named(self) -> None:
        if self._named:
            self.list.clear_ticks()
            self.form.clear_aircraft(self._named)
        self._named = self.module.name
        self.form.enter_aircraft()

    def _on_work(self) -> None:
        self._announce()
        if self._is_print_wanted and self.work.signed is not None:
            self.print()
        standing, trouble = self.work.standing, None if self.work.last is None else self.work.last.trouble
        if trouble is not None and standing in (*PASSED, Standing.NO_GO):
            self.result.notify(Meaning.ATTENTION, join_sentences((trouble.sentence, tr("Not kept."))))
        if standing in (Standing.CHECKING, *PASSED, Standing.NO_GO):
            self.list.verticalScrollBar().setValue(0)  # what failed is at the top
        if standing is Standing.NO_GO:
            self._offer_level()

    def _announce(self) -> None:
        standing = self.work.standing
        if standing is not self._announced and standing in SPOKEN:
            shown = announcement(self.work)
            announce(f"{shown.word}. {shown.head}")
        self._announced = standing

    def _offer_level(self) -> None:
        assessment = self.work.assessment
        against = () if assessment is None else assessment.open_checks
        offer = rest_offer(self._ports.current.target, against, self.check)
        if offer is not None and self.strip.notice is None:
            self.result.set_notice(offer._replace(dismiss=self.result.dismiss))

    # Construction

    def _wire(self) -> None:
        work, buttons = self.work, self.buttons
        buttons.run.clicked.connect(lambda _is_checked: self.check())
        buttons.enable.chosen.connect(self.enable_and_check)
        buttons.cancel.clicked.connect(work.cancel)
        buttons.print.clicked.connect(self.print)
        buttons.history.clicked.connect(self.show_history)
        buttons.verify.triggered.connect(self.files.choose_and_verify)
        self.list.mend_wanted.connect(self.mend)
        self.list.ticked.connect(self._enter)
        self.form.changed.connect(self._on_form)
        self.form.edit_wanted.connect(self.edit_profile)
        self.editor.saved.connect(self._use_profile)
        self.editor.closed.connect(self.show_check)
        self.result.changed.connect(self._show_result)
        self.history.closed.connect(self.show_check)
        self.history.print_wanted.connect(self._export_stored)
        Shortcut(buttons.run, "Ctrl+Return", buttons.press_main, holder=buttons)

    def _lay_out(self) -> QWidget:
        head = in_column(self.header, self.banner, self.form, spacing=Space.XS, margins=(Space.M, 0, Space.M, Space.S))
        view = named(QWidget(), "preflight_check")
        activation = in_row(self.activation, margins=(0, 0, 0, Space.S))
        in_column(head, activation, (self.list, 1), self.strip, self.buttons, of=view, spacing=0, margins=0)
        return view

    # Qt

    def fit(self) -> None:
        self.banner.use_height(low_px() if self.height() < scaled(_LOW_PAGE_PX) else max(HEIGHT_PX, low_px()))

    def ways_back(self) -> WaysBack:
        shown = self._stack.currentWidget()
        return (
            (shown is self.history, self.show_check),
            (shown is self.editor, self.editor.close_editor),
            (self.work.standing is Standing.CHECKING, self.work.cancel),
            (self.strip.notice, self.result.dismiss),
        )
