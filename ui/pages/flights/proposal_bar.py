"""Shows the proposal; puts thresholds into Settings as edits or into a profile. Nothing is sent."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QPushButton, QStackedWidget, QWidget

from app.flights.judging import Answer
from app.flights.thresholds import (
    LEAST_ACCELERATION_G,
    LEAST_FALL_S,
    LEAST_TILT_DEG,
    MOST_ACCELERATION_G,
    MOST_FALL_S,
    MOST_TILT_DEG,
    DefaultsResult,
    FlightGroup,
    FlightMargin,
)
from app.settings.profile_file import save_or_say_why_not
from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences, labelled
from protocol.fields import Value
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.pages.flights.controller import GROUPS, FlightsWork
from ui.pages.flights.lists import limits_text, short_name
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import in_column, in_row, retain_size, stacked
from ui.widgets.notice_bar import NoticeBar

SUFFIX: Final = ".toml"
_ICON_PX: Final = 20
_LINES: Final = 4


class ProposalBar(QFrame):
    """A notice of the page stands in place of the proposal's text, so that it moves nothing."""

    settings_wanted = Signal()

    def __init__(self, services: Services, work: FlightsWork, result: JobNotice) -> None:
        super().__init__()
        named(self, "flights_proposal", "card")
        self.ask_open: AskOpen = ask_profile
        self.ask_save: AskPath = ask_path
        self._work, self._result = work, result
        self._exchange, self._remembered = services.exchange, services.preferences
        self.picture = IconLabel("flights_proposal_icon", _ICON_PX)
        self.head = named(ElidedLabel(), "flights_proposal_head", "strong")
        self.lines = [named(ElidedLabel(), f"flights_proposal_line_{number}", "small") for number in range(_LINES)]
        self.take = control(
            QPushButton(tr("Try proposal")), "flights_take", picture=Icon.CHECK, slot=self._use_proposal
        )
        self.use = control(
            QPushButton(tr("Use in Settings")),
            "flights_use",
            tip=tr("Nothing is sent."),
            picture=Icon.SETTINGS,
            slot=self._use,
        )
        self._summary = named(QWidget(), "flights_proposal_said")
        lines = in_column(self.head, *self.lines, spacing=0)
        in_row((self.picture, Qt.AlignmentFlag.AlignTop), (lines, 1), of=self._summary, spacing=Space.S, margins=0)
        self.strip = named(NoticeBar(is_fitted=True), "flights_notice")
        self.strip.changed.connect(self._share)
        self._stack = stacked(named(QStackedWidget(), "flights_proposal_stack"), self._summary, self.strip)
        self._buttons = named(QWidget(), "flights_proposal_buttons")
        in_row(self.take, self.use, of=self._buttons, spacing=Space.S, margins=0)
        self.row = in_row((self._stack, 1), self._buttons, of=self, spacing=Space.S, margins=(Space.M, Space.XS))
        for label in self.lines:
            retain_size(label)  # so that the lists do not move when a proposal comes

    def show_proposal(self, *, is_wanted: bool) -> None:
        """Without flights there is at most a notice."""
        self._buttons.setVisible(is_wanted)
        self.setVisible(is_wanted or self.strip.notice is not None)

    def _share(self) -> None:
        is_noticed = self.strip.notice is not None
        self._stack.setCurrentWidget(self.strip if is_noticed else self._summary)
        self.show_proposal(is_wanted=not self._buttons.isHidden())

    def refresh(self, *, is_mistyped: bool = False) -> None:
        """`is_mistyped`: a threshold is typed that cannot be used, so none is handed over."""
        work = self._work
        proposal, (must_not, must) = work.proposal, work.sorted_flights()
        limits = None if proposal is None else proposal.limits
        if work.is_proposing:
            self._say(Icon.CLOCK, tr("Looking for thresholds…"))
        elif proposal is None or not (must_not or must):
            self._say(Icon.INFORMATION, tr("No proposal yet"))
        elif unread := work.unread():
            limits = None
            total = len(work.flights)
            text = tr("No proposal: {count} of {total} not read", count=len(unread), total=total)
            names = join_names(short_name(flight.name) for flight in unread)
            self._say(Icon.WARNING, text, [tr("Read or remove: {names}", names=names)], Meaning.ATTENTION)
        elif proposal.defaults is not None:
            self._say_defaults(proposal.defaults)
        elif limits is None:
            lines = [labelled(short_name(conflict.name), conflict.why.translated()) for conflict in proposal.conflicts]
            self._say(Icon.WARNING, tr("No thresholds separate the lists"), lines, Meaning.ATTENTION)
        else:
            lines = [_margin_text(margin) for group in GROUPS if (margin := proposal.nearest.get(group)) is not None]
            doubtful = [flight.name for flight in must_not if flight.answer(limits) is Answer.NOT_JUDGED]
            if doubtful:
                lines.append(tr("Not judged: {names}", names=join_names(map(short_name, doubtful))))
            lines += bounds_lines()
            self._say(Icon.CHECK, tr("Proposal: {limits}", limits=limits_text(limits)), lines)
        self.take.setEnabled(limits is not None and limits != work.limits)
        self.use.setEnabled(self._exchange.can_use() and not is_mistyped)

    def _say_defaults(self, defaults: DefaultsResult) -> None:
        """With flights on one side only nothing is proposed: what the vendor's defaults do is all there is to say."""
        count, total = len(defaults.unexpected), defaults.total
        names = join_names(short_name(name) for name in defaults.unexpected)
        lines: list[str] = []
        if defaults.group is FlightGroup.MUST:
            if count:
                head = tr("The vendor's defaults miss {count} of {total}", count=count, total=total)
                lines.append(labelled(tr("Missed"), names))
            else:
                head = tr("The vendor's defaults fire in all {total}", total=total)
            lines.append(tr("No proposal: no flight is on the side “must not fire”."))
        else:
            if count:
                head = tr("The vendor's defaults fire in {count} of {total}", count=count, total=total)
                lines.append(tr("{names}: did it crash? Then it must fire.", names=names))
            elif defaults.not_judged:
                head = tr("The vendor's defaults fire in 0 of {total}, as far as judged", total=total)
            else:
                head = tr("The vendor's defaults hold: they fire in 0 of {total}", total=total)
            lines.append(tr("No proposal: no flight is on the side “must fire”."))
        if defaults.not_judged:
            unknown = join_names(short_name(name) for name in defaults.not_judged)
            lines.insert(0, tr("Not judged: {names}", names=unknown))
        picture = Icon.WARNING if count else Icon.CHECK
        self._say(picture, head, lines, Meaning.ATTENTION if count else None)

    def _say(self, picture: Icon, head: str, lines: Sequence[str] = (), meaning: Meaning | None = None) -> None:
        self.picture.show_icon(picture, meaning, is_muted=meaning is None)
        self.head.setText(head)
        shown, more = list(lines[:_LINES]), len(lines) - _LINES
        if more > 0:
            shown[-1] = tr("and {count} more", count=more + 1)
        for number, label in enumerate(self.lines):
            label.setText(shown[number] if number < len(shown) else "")
            label.setVisible(number < len(shown))
        self.setToolTip("\n".join(lines) if more > 0 else "")

    def _use_proposal(self) -> None:
        proposal = self._work.proposal
        if proposal is not None and proposal.limits is not None:
            self._work.choose(proposal.limits)

    def _use(self) -> None:
        self._exchange.used.emit(self._work.settings())
        self.settings_wanted.emit()

    def save_profile(self) -> None:
        """Saves a new profile with the three thresholds."""
        settings, suggested = self._work.settings(), self._remembered.profile_folder / f"profile{SUFFIX}"

        def write(path: Path) -> None:
            self._write(path, Profile(name=path.stem or tr("Profile"), settings=settings))

        self.ask_save(self, tr("Save as profile…"), suggested, "*.toml", write)

    def add_to_profile(self) -> None:
        """Changes the three thresholds of a profile, and asks where to save it."""
        self.ask_open(self, self._remembered.profile_folder, partial(self._add_to, self._work.settings()))

    def _add_to(self, thresholds: Mapping[str, Value], path: Path) -> None:
        profile = self._result.read_profile(path)
        if profile is None:
            return
        settings = {**profile.settings, **thresholds}
        loses_approval = profile.approved_fingerprint is not None and settings != dict(profile.settings)
        approved = None if loses_approval else profile.approved_fingerprint
        changed = profile._replace(settings=settings, approved_fingerprint=approved)
        write = partial(self._write, profile=changed, source=path, loses_approval=loses_approval)
        self.ask_save(self, tr("Add to a profile…"), path, "*.toml", write)

    def _write(self, path: Path, profile: Profile, *, source: Path | None = None, loses_approval: bool = False) -> None:
        fault = save_or_say_why_not(path, profile, source=source)
        if fault is not None:
            self._result.notify(Meaning.DANGER, fault.translated())
            return
        self._remembered.add_profile(path)

        note = tr("Its approved settings code was removed.") if loses_approval else ""
        self._result.notify(Meaning.GOOD, join_sentences([tr("Saved to {path}.", path=path), note]))


def _margin_text(margin: FlightMargin) -> str:
    """Smallest margin of a list."""
    parts: list[str] = []
    if margin.attitude_deg is not None and margin.attitude_deg >= 0:
        parts.append(f"{margin.attitude_deg}°")
    if margin.freefall_s is not None and margin.freefall_s >= 0:
        parts.append(f"{margin.freefall_s:.2f} s")
    return tr("{group}: {what} to spare ({name})", group=capitalised(tr(margin.group.value)), what=" · ".join(parts),
              name=short_name(margin.name))  # fmt: skip


def bounds_lines() -> tuple[str, str]:
    """Which limits of a proposal are this program's, and which the vendor's."""
    ours = tr(
        "Limits of this program: {least_tilt}° to {most_tilt}°, {least_force} g to {most_force} g, "
        "{least_fall:.2f} s to {most_fall:.2f} s.",
        least_tilt=LEAST_TILT_DEG,
        most_tilt=MOST_TILT_DEG,
        least_force=LEAST_ACCELERATION_G,
        most_force=MOST_ACCELERATION_G,
        least_fall=LEAST_FALL_S,
        most_fall=MOST_FALL_S,
    )
    return ours, tr("The vendor says: 55° or more, below 0.7 g; defaults 60°, 0.5 g, 1.60 s.")
