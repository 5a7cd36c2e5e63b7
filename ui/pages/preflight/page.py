"""Pre-flight page: the checks with their verdict and one main button; the guided tests; the past checks; the profile.

The verdict is watched as long as the program runs; what voids it is announced at once, also while the page is hidden.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QPushButton, QTabBar, QWidget

from app.guided.results import GuidedKind
from app.preflight.findings import Person
from app.records.filing import document_of
from app.records.record import stored_record
from app.safety.journal import Act
from app.settings.profiles import save_or_say_why_not
from app.store.fact_store import Store
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences
from protocol.fields import Value
from ui.acts.act_row import ActRow
from ui.pages.preflight.check_list import LOCK_AND_ENABLE, CheckList
from ui.pages.preflight.controller import PreflightController
from ui.pages.preflight.form import PreflightForm
from ui.pages.preflight.guided import GuidedPanel
from ui.pages.preflight.past_checks import SUFFIXES, PastChecks, RecordFiles
from ui.pages.preflight.profile_editor import ProfileEditor
from ui.pages.preflight.verdict import SPOKEN, VerdictBanner, announcement
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, WaysBack
from ui.session.check import ENTRIES, PASSED, Standing
from ui.session.shown_module import ShownModule
from ui.simulator.panel import rest_offer
from ui.style.appearance import announce
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import Shortcut, in_column, in_row, named, set_role
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 250
# The last one has no tab: it is opened from the form.
VIEWS: Final = ("checks", "guided", "past", "profile")


class PreflightPage(Page):
    suffixes = SUFFIXES

    def __init__(self, services: Services) -> None:
        super().__init__("preflight")
        self._services, self._ports = services, services.ports
        self.work = PreflightController(services.ports)
        self.result = JobNotice(self)
        self.files = RecordFiles(services.storage, self.result, self)
        self.form = PreflightForm(services, self.result)
        self.banner = VerdictBanner()
        self.activation = ActRow(services, Act.ACTIVATE, place="preflight")
        self.list = CheckList(services)
        self.guided = GuidedPanel(services, self.form)
        self.past = PastChecks(services)
        self.editor = ProfileEditor(services)
        self.strip = named(NoticeBar(), "preflight_notice")
        self.run = named(QPushButton(tr("Start")), "preflight_run")
        # Cancel disappears when the check ends: a press that comes too late must not enable anything.
        self.enable = named(StepButton(tr("Enable triggers and check")), "preflight_enable")
        policy = self.enable.sizePolicy()
        policy.setRetainSizeWhenHidden(False)  # no hole at the right of the main button
        self.enable.setSizePolicy(policy)
        self.cancel = named(StepButton(tr("Cancel"), is_safe=True), "preflight_cancel")
        if is_text_large():  # nothing else lies in its row then
            self.cancel.setSizePolicy(policy)
        self.export = named(QPushButton(tr("Export report…")), "preflight_export")
        self.exporting = self.export
        self._main: QPushButton = self.run
        self.view = "checks"
        # For which module ticks and aircraft were entered, by its name.
        self._named = ""
        # Once the record with the last entries is kept.
        self._is_export_wanted = False
        # What was announced last.
        self._announced = Standing.NOT_CHECKED
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self.tick)
        self._lay_out()
        self._wire()

    # The views

    @property
    def has_unsaved_profile(self) -> bool:
        return self.view == "profile" and self.editor.is_edited

    def show_view(self, view: str) -> None:
        """Leaving the profile asks first where something was edited."""
        if self.view == "profile" != view and self.editor.is_edited:
            self.editor.close_editor()
        else:
            self._show(view)
        if self.view != "profile":
            self.tabs.setCurrentIndex(VIEWS.index(self.view))

    def _show(self, view: str) -> None:
        self.view = view
        for name, part in self._views.items():
            part.setVisible(name == view)
        self.form.setVisible(view in ("checks", "guided"))
        self.tabs.setVisible(view != "profile")
        # Large tabs have no room beside it, and below it would take a line.
        self._title.setVisible(view == "profile" or not is_text_large())
        if view == "past":
            self.past.open()
        if view == "checks":
            self.tabs.setCurrentIndex(0)
            self._refresh_if_seen()

    def go_to(self, view: str) -> None:
        """`view`: one of the page's, or the name of a guided test."""
        if view not in VIEWS:
            self.guided.choose(GuidedKind(view))
        self.show_view(view if view in VIEWS else "guided")

    def open_file(self, path: Path) -> None:
        """Verify a record or a report that was dropped on the window."""
        self.show_view("checks")
        self.files.verify(path)

    # Display

    def refresh(self) -> None:
        self.list.show_work(self.work)
        self.tick()

    def tick(self) -> None:
        """Update what changes by itself: ages, progress, and whether the verdict still holds."""
        self._poll()
        if self.work.standing in (Standing.NOT_CHECKED, Standing.VOID) and self.list.clear_old_ticks():
            self.list.show_work(self.work)
        self.banner.show_announcement(announcement(self.work, self._ports))
        self._show_buttons()
        self.list.enable_acts(self.work)
        self.form.setEnabled(self.work.standing is not Standing.CHECKING and not self.guided.work.is_running)

    def _show_buttons(self) -> None:
        """The main button is the next step: start, enable and check, activate, or export."""
        work = self.work
        is_checking, has_passed = work.standing is Standing.CHECKING, work.standing in PASSED
        # In a new connection a check without enabling the triggers can only end with NO-GO.
        is_enabling = work.can_enable and not work.are_triggers_known
        if work.leads_to_activation:
            self._main = self.activation.confirm.ask
        else:
            self._main = self.export if has_passed else self.enable if is_enabling else self.run
        for button in (self.run, self.enable, self.export, self.activation.confirm.ask):
            set_role(button, "primary" if button is self._main else "")
        self.run.setEnabled(work.can_check)
        # Large text leaves no room for more than the activation; the menu has them, too.
        has_room = not (work.leads_to_activation and is_text_large())
        self.run.setVisible(not is_checking and has_room)
        self.run.setText(tr("Check again" if work.last is not None else "Check only" if is_enabling else "Start"))
        self.enable.setEnabled(work.can_enable)
        self.enable.setText(tr(LOCK_AND_ENABLE if work.needs_lock else "Enable triggers and check"))
        self.enable.setVisible(is_enabling and not has_passed)
        self.export.setEnabled(work.signed is not None)
        self.export.setVisible(has_passed and has_room)
        for action in self._of_report:
            action.setEnabled(work.signed is not None)
        self.cancel.setVisible(is_checking)
        self.activation.setVisible(work.leads_to_activation)
        if work.leads_to_activation:
            self.activation.refresh()

    def press_main(self) -> None:
        """Ctrl+Return is the main button, whichever that is."""
        if self._main.isVisible():
            self._main.click()

    # What a person does

    def check(self, stated: Person | None = None, *, is_enabling: bool = False) -> None:
        self.form.commit_edits()
        self.list.clear_old_ticks()
        if self.work.can_check:
            self.result.dismiss()
            self.form.read_again()
            who, aircraft = self.form.committed
            person = replace(stated or Person(), who=who, aircraft=aircraft)
            self.module.begin_check(self.list.answered(), person, is_enabling=is_enabling)

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

    # What mends a check, beside those: see `Remedy`

    def use_in_settings(self, values: Mapping[str, Value]) -> None:
        """Put values into Settings, by key; nothing is written."""
        self.page_wanted.emit("settings")
        self._services.exchange.used.emit(values)

    def measure_light(self) -> None:
        self.page_wanted.emit("settings")
        self._services.exchange.measured.emit()

    def look_at_records(self) -> None:
        self.page_wanted.emit("triggers")
        self._services.exchange.review_wanted.emit()

    def approve(self) -> None:
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

    # Its files

    def export_check(self) -> None:
        """Export the check that is shown, while it holds; with what was entered just now."""
        self.form.commit_edits()
        self._poll()
        signed, last = self.work.signed, self.work.last
        self._is_export_wanted = signed is None and last is not None and last.is_busy and last.void is None
        if signed is not None:
            self.files.export(signed)

    def _print(self) -> None:
        self._poll()
        if self.work.signed is not None:
            self.files.print(self.work.signed)

    def _export_stored(self, id_: str) -> None:
        """Export a check of the store as it was kept."""
        store = self._services.storage.store
        if not isinstance(store, Store):
            return
        try:
            signed = stored_record(store.read(lambda facts: document_of(facts, id_)))
        except UserError as error:
            self.result.notify(Meaning.DANGER, error.sentence)
        else:
            self.files.export(signed)
        self._show("checks")  # where what came of it is said

    def edit_profile(self) -> None:
        if self.form.read_again():
            self.editor.edit(self.form.profile, self.form.path)
            self.show_view("profile")

    def _use_profile(self, path: Path) -> None:
        self._show("checks")
        self.form.use_profile(path)

    # What happens

    def _on_form(self) -> None:
        self.list.use_profile(self.form.profile)
        self._enter()

    def _enter(self) -> None:
        """An entry changed. Where it decides (the profile, a manual item), the check is void, also a running one; what
        is only written on the record is written on it."""
        last, (who, aircraft) = self.work.last, self.form.committed
        if last is not None:
            if self.list.answered() != last.profile:
                last.set_void(ENTRIES)
            last.state_again(replace(last.person, who=who, aircraft=aircraft))

    def _poll(self) -> None:
        """Void the verdict if it no longer holds."""
        if self.work.last is not None:
            self.work.last.poll()

    def _cancel(self) -> None:
        if self.work.last is not None:
            self.work.last.cancel()

    def show_module(self, module: ShownModule) -> None:
        """Ticks and aircraft are those of the former module; a name that is said again brings its aircraft back."""
        if self._module is not None:
            self._module.named.disconnect(self._on_named)
            self._module.check_changed.disconnect(self._on_work)
        self.list.clear_ticks()
        self.form.clear_aircraft()
        self._named = ""
        self._announced = Standing.NOT_CHECKED
        module.named.connect(self._on_named)
        module.check_changed.connect(self._on_work)
        self.guided.show_module(module)
        super().show_module(module)

    def _on_named(self) -> None:
        if self._named:
            self.list.clear_ticks()
            self.form.clear_aircraft()
        self._named = self.module.name
        self.form.enter_aircraft()

    def _on_work(self) -> None:
        self._announce()
        if self._is_export_wanted and self.work.signed is not None:
            self.export_check()
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
            shown = announcement(self.work, self._ports)
            announce(f"{shown.word}. {shown.head}")
        self._announced = standing

    def _offer_level(self) -> None:
        assessment = self.work.assessment
        against = () if assessment is None else assessment.open_checks
        offer = rest_offer(self._ports.current.target, against, self.check)
        if offer is not None and self.strip.notice is None:
            self.result.set_notice(offer._replace(dismiss=self.result.dismiss))

    def ways_back(self) -> WaysBack:
        return (
            (self.guided.work.is_running, self.guided.work.cancel),
            (self.view == "profile", self.editor.close_editor),
            (self.view != "checks", lambda: self.show_view("checks")),
            (self.work.standing is Standing.CHECKING, self._cancel),
            (self.strip.notice, self.result.dismiss),
        )

    # Construction

    def _wire(self) -> None:
        self.tabs.currentChanged.connect(lambda row: self.show_view(VIEWS[row]))
        self.run.clicked.connect(lambda _is_checked: self.check())
        self.enable.chosen.connect(self.enable_and_check)
        self.cancel.chosen.connect(self._cancel)
        self.export.clicked.connect(self.export_check)
        self.list.mend_wanted.connect(lambda remedy: remedy.act(self))
        self.list.ticked.connect(self._enter)
        self.form.changed.connect(self._on_form)
        self.form.edit_wanted.connect(self.edit_profile)
        self.editor.saved.connect(self._use_profile)
        self.editor.closed.connect(lambda: self._show("checks"))
        self.past.export_wanted.connect(self._export_stored)
        self.result.changed.connect(lambda: self.strip.show_notice(self.result.result_notice()))
        Shortcut(self.run, "Ctrl+Return", self.press_main, holder=self._checks)
        Shortcut(self.guided.primary, "Ctrl+Return")

    def _lay_out(self) -> None:
        self.tabs = named(QTabBar(), "preflight_views")
        self.tabs.setDrawBase(False)
        self.tabs.setAccessibleName(tr("Pre-flight"))
        for title in (tr("Checks"), tr("Guided tests"), tr("Past checks")):
            self.tabs.addTab(title)
        header = self.make_header(tr("Pre-flight"), self.tabs)
        self._title = header.title
        self._of_report = (
            header.add_rare("preflight_export_any", tr("Export report…"), self.export_check),
            header.add_rare("preflight_print", tr("Print…"), self._print),
        )
        self._of_report[0].setShortcut("Ctrl+P")
        header.add_rare("preflight_check_again", tr("Check again"), lambda _is_checked=False: self.check())
        self.addActions(self._of_report)
        header.add_rare("preflight_verify", tr("Verify a file…"), self.files.choose_and_verify)
        self._checks = named(QWidget(), "preflight_checks")
        edges = (Space.M, 0, Space.M, Space.XS)
        buttons = in_row(
            1, self.cancel, self.export, self.run, self.enable, spacing=Space.S, margins=(Space.M, Space.XS)
        )
        parts = ((self.list, 1), self.strip, self.activation, buttons)
        checks = in_column(*parts, of=self._checks, spacing=0, margins=0)
        self._views = dict(zip(VIEWS, (self._checks, self.guided, self.past, self.editor), strict=True))
        head = in_column(header, spacing=Space.XS, margins=edges)
        if is_text_large():  # they scroll with the rows, so that the main button stays in sight
            for part in (self.form, self.strip, self.banner):
                self.list.column.insertWidget(0, part)
        else:
            head.addWidget(self.form)
            checks.insertLayout(0, in_row(self.banner, margins=edges))
        in_column(head, *((view, 1) for view in self._views.values()), of=self, spacing=0, margins=0)
        self._show("checks")
