"""Fleet page: every connected module as a card, LOCK for one and for all, checks and one profile for several."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from math import inf
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton, QStackedWidget

from app.fleet.card import Card, Need
from app.fleet.check_set import SetMember, summary, write_set_reports
from app.fleet.profile_table import Applied, result_line
from app.preflight.module_checks import RecordsWord
from app.procedures.write import SettingChange
from app.safety.last_known import Activation
from app.store.fact_store import Store
from app.store.trouble import StoreTrouble
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences, labelled
from app.trigger_records.filing import say_new
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.files.report_printer import print_pages
from ui.pages.fleet.add_port import AddPort
from ui.pages.fleet.card_widget import NEED_MEANINGS, Board, CardWidget
from ui.pages.fleet.group_jobs import GroupChecks, GroupProfile
from ui.pages.fleet.members import FleetMembers
from ui.pages.fleet.profile_panel import ProfilePanel
from ui.services.context import Services
from ui.services.job_notice import JobNotice, progress_notice
from ui.services.page import Page, WaysBack
from ui.session.port import Port
from ui.session.running_job import is_risk_open, risk_notice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import EmptyState, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area, stacked
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 220
HELD_S: Final = 5.0
"""After the pointer or the focus has left the board, the cards keep their places for this long."""
ALL_EVERY: Final = 4
_LOWEST_PX: Final = 110


class FleetPage(Page):
    """A `Board` of cards, a `ProfilePanel` in its place, and a notice below; `FleetMembers` has the ports,
    `GroupChecks` and `GroupProfile` run what several modules do at once.

    Cards keep their places while the pointer is over the board: no LOCK moves under a hand.
    """

    def __init__(self, services: Services) -> None:
        super().__init__("fleet")
        self._services, self._ports = services, services.ports
        self.ask_profile: AskOpen = ask_profile
        self.ask_report: AskPath = ask_path
        self.result = JobNotice(self)
        self.members = FleetMembers(services, self)
        self.members.leaving_wanted.connect(self.leave_wanted)
        for is_over in (self.members.replaced, self._ports.removed):
            is_over.connect(self.result.dismiss)  # before a check that ends with it says what came of the others
        self.checks = GroupChecks(services, self.members, self)
        self.profile = GroupProfile(services, self.members, self)
        self._widgets: dict[Port, CardWidget] = {}
        self._wording: BackgroundTask[None] = BackgroundTask("dps-s new modules", self)
        self._make_controls()
        self._lay_out()
        self._timer = VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, tick=self._tick)
        for changed in (
            self.members.changed,
            self.checks.changed,
            self.result.changed,
            self._ports.watcher.listed,
        ):
            changed.connect(self._timer.refresh_seen)
        self.checks.finished.connect(self._on_finished)
        self.profile.changed.connect(self._show_profile)
        self._turn, self._pointed_at = 0, -inf

    # Construction

    def _make_controls(self) -> None:
        self.summary = text_label("fleet_summary", "strong")
        self.summary.setWordWrap(False)
        self.add = AddPort(self._ports.watcher, self.members)
        self.check = control(QPushButton(tr("Check all")), "fleet_check", picture=Icon.CHECKLIST, slot=self._check)
        self.open_profile = control(
            QPushButton(tr("Profile for all…")), "fleet_profile", picture=Icon.SETTINGS, slot=self._choose_profile
        )
        self.lock_all = control(
            QPushButton(tr("LOCK ALL")), "fleet_lock_all", picture=Icon.LOCK, role="primary", slot=self._lock_all
        )
        self.notice_bar = named(NoticeBar(), "fleet_said")
        words = tr("Not connected"), tr("Add the port of each module.")
        self.empty = EmptyState("fleet_empty", Icon.FLEET, *words)
        self.first = control(
            QPushButton(tr("Connect all ports")), "fleet_connect_all", role="primary", slot=self.members.connect_all
        )
        self.empty.column.insertWidget(4, self.first, 0, Qt.AlignmentFlag.AlignHCenter)
        self.board = Board()
        self.view = scroll_area(self.board, "fleet_scroll", tr("Modules"), is_vertical=True)
        self.panel = ProfilePanel(self.profile, self.members)
        self.panel.closed.connect(self._close_profile)
        self.panel.write_pressed.connect(self._write_profile)

    def _lay_out(self) -> None:
        head = self.make_header(tr("Fleet"), self.add, self.check, self.open_profile, self.lock_all)
        self.enable = head.add_rare(
            "fleet_enable", tr("Enable triggers and check all"), partial(self._check, is_enabling=True)
        )
        self.report = head.add_rare("fleet_report", tr("Export report…"), self._choose_report)
        self.stack = stacked(named(QStackedWidget(), "fleet_stack"), self.empty, self.view, self.panel)
        top = in_column(head, self.summary, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))
        # Below the cards, so that a notice moves none of them.
        foot = in_row(self.notice_bar, margins=(Space.M, 0, Space.M, Space.S))
        in_column(top, (self.stack, 1), foot, of=self, spacing=0, margins=0)

    # What is shown

    def refresh(self) -> None:
        connections = self.members.connections
        self.members.read_due()
        for gone in [widget for widget in self._widgets if widget not in connections]:
            self._widgets.pop(gone).deleteLater()
        cards = {connection: self.members.card(connection) for connection in connections}
        now = self._ports.clock()
        for connection, card in cards.items():
            self._widget(connection).show_card(card, now)
        self._order(cards)
        self._show_summary(list(cards.values()))
        self._show_controls()
        if self.profile.profile is not None:
            self.panel.refresh()
            self.stack.setCurrentWidget(self.panel)
        else:
            self.stack.setCurrentWidget(self.view if cards else self.empty)
        self.notice_bar.show_notice(self._notice(list(cards.values())))

    def _tick(self) -> None:
        """Update the visible cards; every fourth time everything."""
        self._turn += 1
        self._is_held()
        if self._turn % ALL_EVERY == 0 or self.stack.currentWidget() is not self.view:
            self.refresh()
            return
        now = self._ports.clock()
        for connection, widget in self._widgets.items():
            if not widget.visibleRegion().isEmpty() and connection in self._ports.all:
                widget.show_card(self.members.card(connection), now)

    def _widget(self, connection: Port) -> CardWidget:
        widget = self._widgets.get(connection)
        if widget is None:
            widget = CardWidget(connection, partial(self.members.disconnect_port, connection))
            widget.chosen.connect(partial(self._choose, connection))
            self._widgets[connection] = widget
        return widget

    def _order(self, cards: dict[Port, Card]) -> None:
        """Sort the cards by urgency, but not under a hand."""
        order = list(Need)
        ports = sorted(cards, key=lambda port: order.index(cards[port].need))
        self.board.arrange([self._widgets[port] for port in ports], is_held=self._is_held())

    def _is_held(self) -> bool:
        """Whether the pointer or the focus is on the board, or was a moment ago."""
        now, focus = self._ports.clock(), QApplication.focusWidget()
        if self.board.underMouse() or (focus is not None and self.board.isAncestorOf(focus)):
            self._pointed_at = now
        return now - self._pointed_at < HELD_S

    def _show_summary(self, cards: list[Card]) -> None:
        parts = [labelled(tr("Modules"), len(cards))] if cards else []
        counts = Counter(card.need for card in cards)
        if counts[Need.NOTHING]:
            parts.append(f"{counts[Need.NOTHING]} {tr('GO')}")
        active = sum(card.activation.may_fire for card in cards)
        if active:
            parts.append(f"{active} {tr('ACTIVE')}")
        urgent = sum(count for need, count in counts.items() if NEED_MEANINGS[need] in _URGENT)
        if urgent:
            parts.append(tr("Attention: {count}", count=urgent))
        self.summary.setText(" · ".join(parts))

    def _show_controls(self) -> None:
        connections = self.members.connections
        has_members, is_checking = bool(connections), any(connection.module.is_checking for connection in connections)
        is_free = not (is_checking or self.profile.is_running)
        has_reachable = bool(self.members.reachable)
        self.check.setEnabled(has_reachable and is_free)
        self.enable.setEnabled(has_reachable and is_free)
        self.open_profile.setEnabled(has_members and is_free)
        self.report.setEnabled(bool(self.checks.results) and is_free and not self.result.is_writing)
        self.lock_all.setEnabled(any(connection.is_open for connection in connections))
        for button in (self.check, self.open_profile, self.lock_all):
            button.setVisible(has_members)
        self.summary.setVisible(has_members)
        self.first.setVisible(any(not self.members.is_connected(port) for port in self._ports.watcher.ports))

    def _notice(self, cards: list[Card]) -> Notice | None:
        locking = self._lock_notice(cards)
        if locking is not None:
            return locking
        if self.checks.is_running:
            done, total = len(self.checks.results), self.checks.total
            text = tr("{what} ({done} of {total})", what=capitalised(tr("checking…")), done=done, total=total)
            return progress_notice(text, self.checks.cancel)
        if self.profile.is_running:
            return progress_notice(result_line(self.profile.named_results()), self.profile.cancel)
        return self.result.result_notice()

    def _lock_notice(self, cards: list[Card]) -> Notice | None:
        """LOCK of all modules, until every one has reported."""
        going = [card for card in cards if card.lock_sent is not None]
        failed = [card for card in cards if card.lock_failed is not None]
        if not going and not failed:
            return None
        locked = sum(card.activation.state is Activation.LOCKED for card in cards)
        parts = [tr("{count} report LOCKED", count=locked)]
        if going:
            parts.append(tr("LOCK goes on: {names}", names=_names(going)))
        if failed:
            parts.append(
                tr(
                    "NOT reported, treat as ACTIVE: {names}",
                    names=join_names(card.name or card.port for card in failed),
                )
            )
        return Notice(Meaning.DANGER if failed else Meaning.ATTENTION, " · ".join(parts))

    # What a person does

    def _choose(self, connection: Port) -> None:
        """Show this module on the other pages. What was edited for the one shown before stays with it."""
        self._ports.choose(connection)

    def _lock_all(self) -> None:
        self._services.lock.press_all()
        self.refresh()

    def _check(self, *, is_enabling: bool = False) -> None:
        self.result.dismiss()
        self.checks.profile = self.profile.profile
        self.checks.check(self.members.connections, is_enabling=is_enabling)

    def _on_finished(self) -> None:
        if not self.members.connections:
            return  # a person disconnected them all, which cancelled it
        self.result.set_notice_of_now(self._ended_notice)

    def _ended_notice(self) -> Notice:
        members = tuple(self.checks.results.values())
        is_fine = not any(member.why for member in members)
        meaning = Meaning.INFORMATION if is_fine else Meaning.ATTENTION
        silent = [member.name for member in members if member.name and member.word is RecordsWord.NEW_MODULE]
        return Notice(meaning, summary(members), self._new_choices(silent), self.result.dismiss)

    def _new_choices(self, silent: list[str]) -> tuple[Choice, ...]:
        """A person can say once that named modules, silent to the query for their records, are new."""
        if not silent or not isinstance(self._services.storage.store, Store):
            return ()
        words = labelled(tr(RecordsWord.NEW_MODULE.value), join_names(silent))
        return (Choice("say_new", words, partial(self._say_new, silent)),)

    def _say_new(self, silent: list[str]) -> None:
        """Keeps the word, then checks again."""
        store = self._services.storage.store
        if isinstance(store, Store):
            self.result.dismiss()
            self._wording.run_in(
                store, partial(say_new, names=silent), lambda _none: self._check(), self._show_unworded
            )

    def _show_unworded(self, trouble: StoreTrouble) -> None:
        self.result.notify(Meaning.DANGER, join_sentences((trouble.sentence, tr("Not kept."))))

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
        """Writes the profile to all modules; asks first where it takes protection away."""
        changes = self.profile.changes()
        if is_risk_open(changes, accepted):
            self.result.set_notice(risk_notice(changes, self._write_profile, self.result.dismiss))
            return
        self.result.dismiss()
        self.profile.apply(self.members.connections, accepted)

    def _show_profile(self) -> None:
        if self.profile.applied and not self.profile.is_running and self.members.connections:
            self.result.set_notice_of_now(self._applied_notice)
        self._timer.refresh_seen()

    def _applied_notice(self) -> Notice | None:
        """Of those that are still the modules it was written to."""
        applied = self.profile.named_results()
        if not applied:
            return None
        has_failed = any(result.state is Applied.FAILED for _, result in applied)
        is_fine = all(result.state.is_fine for _, result in applied)
        meaning = Meaning.DANGER if has_failed else Meaning.GOOD if is_fine else Meaning.ATTENTION
        return Notice(meaning, result_line(applied))

    def _choose_report(self) -> None:
        """Of what is shown when it is asked for."""
        suggested, export = Path.home() / "fleet.pdf", partial(self._export, tuple(self.checks.results.values()))
        self.ask_report(self, tr("Export report…"), suggested, "*.pdf", export)

    def _export(self, members: Sequence[SetMember], path: Path) -> None:
        def saved(written: tuple[Path, ...]) -> str:
            return tr("Written: {names}.", names=join_names(file.name for file in written))

        self.result.write_file(path, partial(write_set_reports, path, members, print_pages), saved)

    def ways_back(self) -> WaysBack:
        return ((self.profile.profile is not None and not self.profile.is_running, self._close_profile),)

    def fit(self) -> None:
        self.board.place()
        self.stack.setMinimumHeight(scaled(_LOWEST_PX))


def _names(cards: Sequence[Card]) -> str:
    """By name, or by port where there is none."""
    return join_names(card.name or card.port for card in cards)


_URGENT: Final = (Meaning.DANGER, Meaning.ATTENTION)
