"""Fleet page: all connected modules in one table, and all modules ever seen."""

from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QPushButton, QWidget

from app.fleet.card import Applied, result_line
from app.preflight.checks import Person
from app.procedures.write import SettingChange, risk_message
from app.settings.profiles import NO_PROFILE
from app.text.i18n import tr
from app.text.messages import capitalised, labelled
from ui.files.file_dialogs import AskOpen, ask_profile
from ui.pages.fleet.archive_panel import ArchivePanel
from ui.pages.fleet.board import Board
from ui.pages.fleet.group_jobs import GroupProfile
from ui.pages.fleet.members import AddPort, FleetMembers
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.page_job import PageJob, progress_notice
from ui.session.port import Port
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import EmptyState, control, in_column, in_row, named, tabbed
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Choice, Notice
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 250


class FleetPage(Page):
    """Two views: the `Board` of connected modules, in whose place a profile is compared and written, and the
    `ArchivePanel`. `FleetMembers` has the ports, `GroupProfile` writes to several."""

    def __init__(self, services: Services) -> None:
        super().__init__("fleet")
        self._services, self._ports = services, services.ports
        self.ask_profile: AskOpen = ask_profile
        self.result = PageJob(self)
        self.members = FleetMembers(services)
        # The last set of checks.
        self._checked: tuple[Port, ...] = ()
        self.profile = GroupProfile(services, self.members, self)
        self.board = Board(self.members, self.profile)
        self._lay_out()
        self._timer = VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)
        for changed in (self.board.ticked, self.profile.changed, self.result.changed, self._ports.watcher.listed):
            changed.connect(self._timer.refresh_seen)

    def _lay_out(self) -> None:
        self.lock_all = control(QPushButton(tr("LOCK ALL")), "fleet_lock_all", picture=Icon.LOCK, role="primary")
        self.lock_all.clicked.connect(self._lock_all)
        head = self.make_header(tr("Fleet"), self.lock_all)
        enable = partial(self._check, is_enabling=True)
        self.enable = head.add_rare("fleet_enable", tr("Enable triggers and check"), enable)
        self.show_marked = head.add_rare("fleet_show", tr("Show on all pages"), lambda: self._choose(self.board.marked))
        self.board.chosen.connect(self._choose)
        self.add = AddPort(self.members, self._ports.watcher.refresh)
        self.check = control(QPushButton(tr("Check selected")), "fleet_check", picture=Icon.CHECKLIST, slot=self._check)
        self.open_profile = control(QPushButton(tr("Profile…")), "fleet_profile", picture=Icon.SETTINGS)
        self.open_profile.clicked.connect(self._choose_profile)
        self.empty = EmptyState("fleet_empty", Icon.FLEET, tr("Not connected"), tr("Add the port of each module."))
        self.first = control(QPushButton(tr("Connect all ports")), "fleet_connect_all", role="primary")
        self.first.clicked.connect(self.members.connect_all)
        self.empty.column.insertWidget(4, self.first, 0, Qt.AlignmentFlag.AlignHCenter)
        self.notice_bar = named(NoticeBar(), "fleet_said")
        connected = QWidget()
        buttons = in_row(self.add, self.check, self.open_profile, 1)
        # The notice below the table, so that it moves no LOCK.
        parts = (buttons, (self.empty, 1), (self.board, 1), self.notice_bar)
        in_column(*parts, of=connected, margins=(0, Space.S, 0, 0))
        self.archive = ArchivePanel(self._services, self)
        self.tabs = tabbed("fleet", tr("Fleet"))
        self.tabs.addTab(connected, tr("Connected"))
        self.tabs.addTab(self.archive, tr("All modules"))
        in_column(head, (self.tabs, 1), of=self, margins=(Space.M, 0, Space.M, Space.S))

    # What is shown

    def go_to(self, view: str) -> None:
        self.tabs.setCurrentIndex(("connected", "archive").index(view))

    def refresh(self) -> None:
        connections = self.members.connections
        cards = {port: self.members.card(port) for port in connections}
        self.board.show_cards(cards, self.members.now())
        self.empty.setVisible(not cards)
        self.board.setVisible(bool(cards))
        is_free = not self.profile.is_running and not any(port.module.is_checking for port in connections)
        for one in (self.check, self.enable):
            one.setEnabled(is_free and bool(self.members.reachable))
        self.open_profile.setEnabled(is_free and bool(self.members.ticked))
        self.lock_all.setEnabled(bool(cards))
        self.first.setVisible(bool(self.members.unconnected))
        self.notice_bar.show_notices(self._notices())

    def _notices(self) -> list[Notice]:
        """Return what is going on, else what it came to, else the profile that is open."""
        if self.is_checking:
            done, total = sum(not port.module.is_checking for port in self._checked), len(self._checked)
            text = tr("{what} ({done} of {total})", what=capitalised(tr("checking…")), done=done, total=total)
            return [progress_notice(text, self.cancel_checks)]
        results = self.profile.named_results()
        if self.profile.is_running:
            return [progress_notice(result_line(results), self.profile.cancel)]
        notices, profile = self.result.notices, self.profile.profile
        if notices or profile is None:
            return notices
        states = [result.state for _, result in results]
        meaning = Meaning.INFORMATION if all(state.is_fine for state in states) else Meaning.ATTENTION
        if Applied.FAILED in states:
            meaning = Meaning.DANGER
        text = result_line(results) or tr("Never written: baud rate, serial output, an active module.")
        count = len(self.profile.writable)
        label = tr("Write ({count})", count=count)
        write = Choice("write", label, self._write_profile, is_main=True, is_step=True, is_enabled=count > 0)
        close = Choice("close_profile", tr("Close"), self._close_profile)
        return [Notice(meaning, f"{labelled(tr('Profile'), profile.name)} · {text}", (close, write))]

    # What a person does

    def _choose(self, port: Port | None) -> None:
        """Show this module on the other pages. What was edited for the one shown before stays with it."""
        if port is not None:
            self._ports.choose(port)

    def _lock_all(self) -> None:
        self._services.lock.press_all()
        self.refresh()

    def _check(self, _is_checked: bool = False, *, is_enabling: bool = False) -> None:
        """They send queries only, or enable the triggers of each locked module first."""
        if not any(port.module.is_checking for port in self.members.ticked):
            self._checked = self.members.reachable
            for port in self._checked:
                port.module.begin_check(self.profile.profile or NO_PROFILE, Person(), is_enabling=is_enabling)
            self.result.dismiss()

    @property
    def is_checking(self) -> bool:
        return any(port.module.is_checking for port in self._checked)

    def cancel_checks(self) -> None:
        for port in self._checked:
            if port.module.check is not None:
                port.module.check.cancel()

    def _choose_profile(self) -> None:
        self.ask_profile(self, self._services.preferences.profile_folder, self.open_profile_file)

    def open_profile_file(self, path: Path) -> None:
        profile = self.result.read_profile(path)
        if profile is not None:
            self.result.dismiss()
            self.profile.open(profile)

    def _close_profile(self) -> None:
        self.result.dismiss()
        self.profile.open(None)

    def _write_profile(self, *, accepted: frozenset[SettingChange] = frozenset()) -> None:
        """Writes the profile to the ticked modules; asks first where it takes protection away."""
        changes = self.profile.changes()
        self.result.dismiss()
        risk = risk_message(changes)
        if risk is None or not any(change.risks and change not in accepted for change in changes):
            self.profile.apply(accepted)
            return
        anyway = partial(self._write_profile, accepted=frozenset(changes))
        write = Choice("write_anyway", tr("Write anyway"), anyway, is_step=True)
        choices = (Choice("not_now", tr("Cancel"), self.result.dismiss), write)
        self.result.set_notice(Notice(Meaning.ATTENTION, risk.translated(), choices))

    def ways_back(self) -> WaysBack:
        return ((self.profile.profile is not None and not self.profile.is_running, self._close_profile),)
