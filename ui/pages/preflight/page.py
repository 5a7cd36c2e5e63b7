"""Pre-flight page: the checks with their verdict and one main button; the guided tests; the past checks; the profile.

The verdict is watched as long as the program runs; what voids it is announced at once, also while the page is hidden.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLineEdit, QMenu, QPushButton, QSizePolicy, QTabBar, QToolButton, QWidget

from app.modules.labels import Printer
from app.preflight.checks import Person
from app.preflight.verdict import CheckState, Standing
from app.records.filing import aircraft_of, kept_record
from app.records.record import Record, SignedRecord
from app.records.report import write_report
from app.records.verification import RecordState, Verification, verify_file
from app.safety.journal import Act
from app.settings.profile_file import save_profile
from app.settings.profiles import NO_PROFILE, ActivatedBy, Profile
from app.store.fact_store import StoreError
from app.system.files import CANNOT_READ, CANNOT_WRITE
from app.text.i18n import tr
from app.text.messages import MAX_TEXT_LENGTH, UserError, clean, error_text, join_sentences, labelled, not_written
from ui.acts.act_row import ActRow
from ui.core.background_task import Running
from ui.files.file_dialogs import AskOpen, AskPath, ThenPath, add_recent, ask_open, ask_path, ask_profile, default_name
from ui.files.report_printer import print_pages
from ui.pages.preflight.checks import CheckList
from ui.pages.preflight.guided import GuidedPanel
from ui.pages.preflight.past_checks import PastChecks
from ui.pages.preflight.profile_editor import ProfileEditor
from ui.pages.preflight.verdict import SPOKEN, VerdictBanner, announcement, can_check, can_enable, has_to_enable
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.check import ENTRIES
from ui.session.module_field import ModuleField
from ui.session.page_job import PageJob
from ui.session.shown_module import ShownModule
from ui.style.appearance import announce
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import Shortcut, captioned_row, in_column, in_row, named, retain_size, set_role, without_key
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 250
MAX_NAME_LENGTH: Final = 80
VIEWS: Final = ("checks", "guided", "past")


class PreflightForm(QWidget):
    """Person, module, aircraft, profile. `changed`: an entry. `edit_wanted`: of the profile, or of a new one."""

    changed = Signal()
    edit_wanted = Signal()

    def __init__(self, services: Services, result: PageJob) -> None:
        super().__init__()
        self.setObjectName("preflight_form")
        self._services, self._result = services, result
        self.ask_open: AskOpen = ask_profile
        self.profile: Profile | None = None
        self.path: Path | None = None  # the profile's file
        self.who = named(QLineEdit(services.preferences.who), "preflight_who")
        self.who.setMaxLength(MAX_NAME_LENGTH)
        self.name_field = ModuleField("preflight_module", services.ports)
        self.aircraft = named(QLineEdit(), "preflight_aircraft")
        self.aircraft.setMaxLength(MAX_TEXT_LENGTH)
        self.choose = named(QToolButton(), "preflight_profile")
        self.choose.setIcon(icon(Icon.CHEVRON_DOWN))
        self.choose.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.choose.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.choose.setLayoutDirection(Qt.LayoutDirection.RightToLeft)  # the arrow behind the name
        self.choose.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.menu = named(QMenu(self.choose), "preflight_profile_menu")
        self.menu.aboutToShow.connect(self._fill_menu)
        self.choose.setMenu(self.menu)
        # Person and aircraft, as they were entered last.
        self.committed = (clean(self.who.text().strip()), "")
        self.enter_aircraft()
        for title, field in ((tr("Checked by"), self.who), (tr("Aircraft"), self.aircraft)):
            field.setAccessibleName(title)
            field.editingFinished.connect(self.commit)
        self.setLayout(
            captioned_row(
                (tr("Checked by"), self.who),
                (tr("Module"), self.name_field),
                (tr("Aircraft"), self.aircraft),
                (tr("Profile"), self.choose),
            )
        )
        self._use(None, None)

    def commit(self) -> None:
        entered = (clean(self.who.text().strip()), clean(self.aircraft.text().strip()))
        if entered != self.committed:
            self.committed = entered
            self._services.preferences.who = entered[0]
            self.changed.emit()

    def commit_edits(self) -> None:
        """Commit what is typed in a field that still has the focus, as when a key starts the check."""
        self.name_field.apply()
        self.commit()

    def enter_aircraft(self) -> None:
        """Enter the aircraft of the module's last check."""
        store, module = self._services.storage.ready, self._services.ports.module.name
        if store is not None and module and not self.aircraft.text():
            with suppress(StoreError):
                self.aircraft.setText(store.read(lambda facts: aircraft_of(facts, module)))
                self.commit()

    # The profile

    def use_profile(self, path: Path) -> None:
        profile = self._result.read_profile(path)
        if profile is not None:
            self._services.preferences.add_profile(path)
            self._use(profile, path)

    def read_again(self) -> bool:
        """Take what another page or program wrote into the file since; False where it is no profile any more, which is
        said."""
        profile = None if self.path is None else self._result.read_profile(self.path)
        if profile is not None and profile != self.profile:
            self._use(profile, self.path)
        return self.path is None or profile is not None

    def _use(self, profile: Profile | None, path: Path | None) -> None:
        self.profile, self.path = profile, path
        self._services.in_use.profile = self.profile or NO_PROFILE
        self._services.exchange.limits_used.emit()
        name = tr("Vendor's advice") if self.profile is None else clean(self.profile.name, longest=40)
        self.choose.setText(without_key(name))
        self.choose.setToolTip(labelled(tr("Profile"), name))
        self.choose.setAccessibleName(labelled(tr("Profile"), name))
        self.changed.emit()

    def choose_file(self) -> None:
        self.ask_open(self, self._services.preferences.profile_folder, self.use_profile)

    def _fill_menu(self) -> None:
        menu, edit = self.menu, tr("New profile…") if self.profile is None else tr("Edit profile…")
        menu.clear()
        named(menu.addAction(tr("Vendor's advice"), lambda: self._use(None, None)), "preflight_profile_none")
        add_recent(menu, "preflight_profile", self._services.preferences.recent_profiles, self.use_profile)
        menu.addSeparator()
        named(menu.addAction(tr("Open profile…"), self.choose_file), "preflight_profile_open")
        named(menu.addAction(edit, self.edit_wanted.emit), "preflight_profile_edit")


def _name_of(record: Record) -> str:
    """The name of the report's file."""
    return default_name(f"{record.verdict.value} {record.module or ''}".strip(), ".pdf", record.at)


class PreflightPage(Page):
    suffixes = (".json", ".pdf")

    def __init__(self, services: Services) -> None:
        super().__init__("preflight")
        self._services, self._ports, self.exchange = services, services.ports, services.exchange
        self.result = PageJob(self)
        self.ask_path: AskPath = ask_path
        self.ask_open: Callable[[QWidget, Path, str, str, ThenPath], object] = ask_open
        self.printer: Printer = print_pages
        self.form = PreflightForm(services, self.result)
        self.banner = VerdictBanner()
        self.activation = ActRow(services, Act.ACTIVATE, place="preflight")
        self.list = CheckList(services)
        self.guided = GuidedPanel(services, self._committed_person)
        self.past = PastChecks(services)
        self.editor: ProfileEditor | None = None  # while a profile is edited, in place of everything else
        self.strip = named(NoticeBar(), "preflight_notice")
        self.run = named(QPushButton(tr("Start")), "preflight_run")
        # Cancel disappears when the check ends: a press that comes too late must not enable anything.
        self.enable = named(StepButton(tr("Enable triggers and check")), "preflight_enable")
        retain_size(self.enable, is_kept=False)  # no hole at the right of the main button
        self.cancel = named(StepButton(tr("Cancel"), is_safe=True), "preflight_cancel")
        if is_text_large():  # nothing else lies in its row then
            retain_size(self.cancel, is_kept=False)
        self.export = named(QPushButton(tr("Export report…")), "preflight_export")
        self._main: QPushButton = self.run
        # For which module ticks and aircraft were entered, by its name.
        self._named = ""
        # Once the record with the last entries is kept.
        self._is_export_wanted = False
        # What was announced last.
        self._announced = Standing.NOT_CHECKED
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self.tick)
        self._lay_out()
        self._wire()

    @property
    def state(self) -> CheckState:
        return self._ports.module.check_state

    @property
    def signed(self) -> SignedRecord | None:
        check = self._ports.module.check
        return None if check is None else check.signed

    @property
    def view(self) -> str:
        return VIEWS[self.tabs.currentIndex()]

    def show_view(self, view: str) -> None:
        if self.editor is not None:
            self.editor.close_editor()  # which asks where edits would be lost
        self.tabs.setCurrentIndex(VIEWS.index(view))

    def _on_view(self, row: int) -> None:
        for number, part in enumerate(self._parts):  # no stack: that would be as high as the highest of them
            part.setVisible(number == row and self.editor is None)
        self.form.setVisible(self.view != "past" and self.editor is None)
        self.header.setVisible(self.editor is None)
        if self.view == "past":
            self.past.open()
        self._refresh_if_seen()

    # Display

    def refresh(self) -> None:
        self.list.show_check()
        self.tick()

    def tick(self) -> None:
        """Update what changes by itself: ages, progress, and whether the verdict still holds."""
        self._poll()
        standing = self.state.standing
        if standing in (Standing.NOT_CHECKED, Standing.VOID):
            self.list.clear_old_ticks()
        self.banner.show_announcement(announcement(self._ports))
        self._show_buttons()
        self.list.enable_acts()
        self.form.setEnabled(standing is not Standing.CHECKING and not self.guided.work.is_running)

    def _show_buttons(self) -> None:
        """The main button is the next step: start, enable and check, activate, or export."""
        check, state, is_enabling = self._ports.module.check, self.state, has_to_enable(self._ports)
        is_checking, has_passed = state.standing is Standing.CHECKING, state.has_passed
        is_persons = check is not None and check.profile.activated_by is ActivatedBy.PERSON
        leads_to_activation = state.standing is Standing.READY and is_persons
        if leads_to_activation:
            self._main = self.activation.confirm.ask
        else:
            self._main = self.export if has_passed else self.enable if is_enabling else self.run
        for button in (self.run, self.enable, self.export, self.activation.confirm.ask):
            set_role(button, "primary" if button is self._main else "")
        self.run.setEnabled(can_check(self._ports))
        # Large text leaves no room for more than the activation; the menu has them, too.
        has_room = not (leads_to_activation and is_text_large())
        self.run.setVisible(not is_checking and has_room)
        self.run.setText(tr("Check again" if check is not None else "Check only" if is_enabling else "Start"))
        self.enable.setEnabled(can_enable(self._ports))
        self.enable.setVisible(is_enabling and not has_passed)
        for control in (self.export, *self._of_report):
            control.setEnabled(self.signed is not None)
        self.export.setVisible(has_passed and has_room)
        self.cancel.setVisible(is_checking)
        self.activation.setVisible(leads_to_activation)
        if leads_to_activation:
            self.activation.refresh()

    def press_main(self) -> None:
        """Ctrl+Return is the main button, whichever that is."""
        if self._main.isVisible():
            self._main.click()

    # What a person does

    def _committed_person(self) -> str:
        self.form.commit_edits()
        return self.form.committed[0]

    def check(self, stated: Person | None = None, *, is_enabling: bool = False) -> None:
        self.form.commit_edits()
        self.list.clear_old_ticks()
        if can_check(self._ports):
            self.result.dismiss()
            self.form.read_again()
            who, aircraft = self.form.committed
            person = replace(stated or Person(), who=who, aircraft=aircraft)
            self.module.begin_check(self.list.answered(), person, is_enabling=is_enabling)

    def lead_to(self, page: str, then: Callable[[], object]) -> None:
        """Lead to the page that has the control for it; nothing is sent."""
        self.page_wanted.emit(page)
        then()

    def edit_profile(self) -> None:
        if self.editor is None and self.form.read_again():
            self.editor = ProfileEditor(self.form.profile, self.form.path, self._services.preferences.profile_folder)
            self.editor.closed.connect(self._on_edited)
            self._column.addWidget(self.editor, 1)
            self._on_view(self.tabs.currentIndex())
            self.editor.name.setFocus()

    def _on_edited(self, saved: Path | None) -> None:
        self.setFocus()  # else Qt gives it to whichever button comes next
        editor, self.editor = self.editor, None
        if editor is not None:
            editor.setParent(None)
            editor.deleteLater()
        self._on_view(self.tabs.currentIndex())
        if saved is not None:
            self.form.use_profile(saved)

    def approve(self) -> None:
        """Keep the code of the checked settings as the approved one in the profile, or without one in the record; and
        check again."""
        assessment, is_read = self.state.assessment, self.form.read_again()
        profile, path = self.form.profile, self.form.path
        if profile is None or path is None:
            self.check(Person(are_settings_approved=True))
            return
        if not is_read or assessment is None:
            return
        code = assessment.case.settings_code
        try:
            save_profile(path, profile._replace(approved_fingerprint=code), source=path)
        except OSError as error:
            self.result.notify(Meaning.DANGER, tr(CANNOT_WRITE, file=path, why=error_text(error)))
        else:
            self.form.use_profile(path)
            self.check()

    # Its files

    def export_check(self) -> None:
        """Export the check that is shown, while it holds; with what was entered just now."""
        self.form.commit_edits()
        self._poll()
        signed, last = self.signed, self._ports.module.check
        self._is_export_wanted = signed is None and last is not None and last.is_busy and last.void is None
        if signed is not None:
            self._export(signed)

    def _export_stored(self, id_: str) -> None:
        """Export a check of the store as it was kept."""
        store = self._services.storage.ready
        if store is not None:
            try:
                self._export(store.read(lambda facts: kept_record(facts, id_)))
            except UserError as error:
                self.result.notify(Meaning.DANGER, error.sentence)
            self.show_view("checks")  # where what came of it is said

    def _export(self, signed: SignedRecord) -> None:
        """Ask for a file name, then write the report as PDF and JSON."""

        def write(path: Path) -> None:
            saved = tr("Saved to {path}.", path=f"{path}, {path.with_suffix('.json')}")
            self._write_report(signed, path, lambda: self.result.notify_saved(path, saved))

        self.ask_path(self, tr("Export report…"), Path(_name_of(signed.record)), "*.pdf", write)

    def _print(self) -> None:
        """Open the report in the system's own viewer, which knows the printers."""
        self._poll()
        signed = self.signed
        if signed is not None:
            path = Path(mkdtemp(prefix="dps-s-")) / _name_of(signed.record)
            self._write_report(signed, path, lambda: self.result.open_file(path))

    def _write_report(self, signed: SignedRecord, path: Path, then: Callable[[], object]) -> None:
        def write(_running: Running) -> object:
            return write_report(path, signed, self.printer)

        self.result.begin(tr("Saving…"), write, lambda _done: then(), partial(not_written, path))

    def _choose_and_verify(self) -> None:
        self.ask_open(self, Path.home(), tr("Verify a file…"), "*.json *.pdf", self.open_file)

    def open_file(self, path: Path) -> None:
        """Verify a record or a report in the background: it may be large, and on a slow disk."""
        storage, file = self._services.storage, clean(path.name, longest=60)

        def verify(_running: Running) -> Verification:
            from app.archive.archive import known_names  # no start waits for it

            return verify_file(path, known_names(storage.begun))

        def tell(done: Verification) -> None:
            meaning = Meaning.GOOD if done.is_green else Meaning.INFORMATION  # an intact NO-GO is not shown in green
            if done.state is not RecordState.INTACT:
                meaning = Meaning.DANGER
            said = join_sentences(one.translated() for one in done.sentences())
            self.result.notify(meaning, f"{file} — {said}", str(path))

        def refuse(error: Exception) -> str:
            if isinstance(error, UserError):
                return f"{file} — {tr('No pre-flight record: {why}.', why=error.sentence)}"
            return tr(CANNOT_READ, file=file, why=error_text(error))

        self.show_view("checks")
        self.result.begin(tr("Reading: {what}", what=path.name), verify, tell, refuse, writes=False, cause=str(path))

    # What happens

    def _on_form(self) -> None:
        self.list.use_profile(self.form.profile)
        self._enter()

    def _enter(self) -> None:
        """An entry changed. Where it decides (the profile, a manual item), the check is void, also a running one; what
        is only written on the record is written on it."""
        last, (who, aircraft) = self._ports.module.check, self.form.committed
        if last is not None:
            if self.list.answered() != last.profile:
                last.set_void(ENTRIES)
            last.state_again(replace(last.person, who=who, aircraft=aircraft))

    def _poll(self) -> None:
        """Void the verdict if it no longer holds."""
        if self.module.check is not None:
            self.module.check.poll()

    def _cancel(self) -> None:
        if self.module.check is not None:
            self.module.check.cancel()

    def show_module(self, module: ShownModule) -> None:
        """Ticks and aircraft are those of the former module; a name that is said again brings its aircraft back."""
        self._forget_entries()
        self._named = ""
        self._announced = Standing.NOT_CHECKED
        self.guided.show_module(module)
        super().show_module(module)
        self.list.show_check()  # also out of sight: its rows take long to make

    def _slots(self, module: ShownModule) -> tuple[tuple[Any, Callable[..., None]], ...]:
        own = ((module.named, self._on_named), (module.check_changed, self._on_work))
        return (*own, *super()._slots(module))

    def _forget_entries(self) -> None:
        self.list.clear_ticks()
        self.form.aircraft.clear()
        self.form.commit()

    def _on_named(self) -> None:
        if self._named:
            self._forget_entries()
        self._named = self.module.name
        self.form.enter_aircraft()

    def _on_work(self) -> None:
        check, standing = self._ports.module.check, self.state.standing
        if standing is not self._announced and standing in SPOKEN:
            shown = announcement(self._ports)
            announce(f"{shown.word}. {shown.head}")
        self._announced = standing
        if self._is_export_wanted and self.signed is not None:
            self.export_check()
        if self.state.verdict is not None and check is not None and check.filed is not None:
            trouble = check.filed.trouble
            if trouble is not None:
                self.result.notify(Meaning.ATTENTION, join_sentences((trouble.sentence, tr("Not kept so far."))))
        if standing is not Standing.VOID:
            self.list.verticalScrollBar().setValue(0)  # what failed is at the top

    def ways_back(self) -> WaysBack:
        return (
            (self.guided.work.is_running, self.guided.work.cancel),
            (self.editor is not None or self.view != "checks", lambda: self.show_view("checks")),
            (self.state.standing is Standing.CHECKING, self._cancel),
            (self.strip.notice, self.result.dismiss),
        )

    # Construction

    def _wire(self) -> None:
        self.tabs.currentChanged.connect(self._on_view)
        self.run.clicked.connect(lambda _is_checked: self.check())
        self.enable.chosen.connect(lambda: self.check(is_enabling=True))
        self.cancel.chosen.connect(self._cancel)
        self.export.clicked.connect(self.export_check)
        self.list.mend_wanted.connect(lambda remedy: remedy.act(self))
        self.list.ticked.connect(self._enter)
        self.form.changed.connect(self._on_form)
        self.form.edit_wanted.connect(self.edit_profile)
        self.past.export_wanted.connect(self._export_stored)
        self.result.changed.connect(lambda: self.strip.show_notices(self.result.notices))
        Shortcut(self.run, "Ctrl+Return", self.press_main, holder=self._checks)
        Shortcut(self.guided.primary, "Ctrl+Return")

    def _lay_out(self) -> None:
        self.tabs = named(QTabBar(), "preflight_views", says=tr("Pre-flight"))
        self.tabs.setDrawBase(False)
        for title in (tr("Checks"), tr("Guided tests"), tr("Past checks")):
            self.tabs.addTab(title)
        header = self.header = self.make_header(tr("Pre-flight"), self.tabs)
        # Large tabs have no room beside it, and below it would take a line.
        header.title.setHidden(is_text_large())
        self._of_report = (
            header.add_rare("preflight_export_any", tr("Export report…"), self.export_check),
            header.add_rare("preflight_print", tr("Print…"), self._print),
        )
        self._of_report[0].setShortcut("Ctrl+P")
        header.add_rare("preflight_check_again", tr("Check again"), lambda _is_checked=False: self.check())
        self.addActions(self._of_report)
        header.add_rare("preflight_verify", tr("Verify a file…"), self._choose_and_verify)
        self._checks = named(QWidget(), "preflight_checks")
        edges = (Space.M, 0, Space.M, Space.XS)
        row = (1, self.cancel, self.export, self.run, self.enable)
        buttons = in_row(*row, spacing=Space.S, margins=(Space.M, Space.XS))
        parts = ((self.list, 1), self.strip, self.activation, buttons)
        checks = in_column(*parts, of=self._checks, spacing=0, margins=0)
        self._parts = (self._checks, self.guided, self.past)
        head = in_column(header, spacing=Space.XS, margins=edges)
        if is_text_large():  # they scroll with the rows, so that the main button stays in sight
            for part in (self.form, self.strip, self.banner):
                self.list.column.insertWidget(0, part)
        else:
            head.addWidget(self.form)
            checks.insertLayout(0, in_row(self.banner, margins=edges))
        self._column = in_column(head, *((part, 1) for part in self._parts), of=self, spacing=0, margins=0)
        self._on_view(0)
