"""Says what is proposed; puts thresholds into Settings as edits. Nothing is sent."""

from collections.abc import Iterable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QScrollArea, QStackedWidget, QWidget

from app.flights.judging import (
    LEAST_ACCELERATION_G,
    LEAST_FALL_S,
    LEAST_TILT_DEG,
    MOST_ACCELERATION_G,
    MOST_FALL_S,
    MOST_TILT_DEG,
    Answer,
    DefaultsResult,
    FlightGroup,
    FlightMargin,
)
from app.text.i18n import tr
from app.text.messages import capitalised, join_names, labelled
from ui.pages.logs.rows import button, limits_text, short_name
from ui.pages.logs.work import LogsWork
from ui.services.context import DraftExchange
from ui.style.icons import Icon
from ui.style.theme import IconSize, Meaning, Space
from ui.widgets.controls import IconLabel, in_column, in_row, named, text_label
from ui.widgets.notice_bar import NoticeBar

_LINES = 5


class ProposalBar(QFrame):
    """A notice of the page stands in place of the proposal's text; what is longer scrolls, so that nothing moves."""

    settings_wanted = Signal()

    def __init__(self, exchange: DraftExchange, work: LogsWork) -> None:
        super().__init__()
        named(self, "logs_proposal", "card")
        self._work, self._exchange = work, exchange
        self.picture = IconLabel("logs_proposal_icon", IconSize.NOTICE)
        self.head = text_label("logs_proposal_head", "strong", is_selectable=True)
        self.lines = text_label("logs_proposal_lines", "small", is_selectable=True)
        self.strip = named(NoticeBar(), "logs_notice")
        self.take = button("logs_take", tr("Try proposal"), Icon.CHECK, self._use_proposal)
        self.use = button("logs_use", tr("Use in Settings"), Icon.SETTINGS, self._use)
        self.use.setToolTip(tr("Nothing is sent."))
        summary = QWidget()
        texts = in_column(self.head, self.lines, 1, spacing=0)
        in_row((self.picture, Qt.AlignmentFlag.AlignTop), (texts, 1), of=summary, margins=(Space.S, 0))
        stack = QStackedWidget()
        for content in (summary, self.strip):
            area = QScrollArea()
            area.setFrameShape(QFrame.Shape.NoFrame)
            area.setWidgetResizable(True)
            area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
            area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            area.setWidget(content)
            for ground in (content, area.viewport()):
                ground.setAutoFillBackground(False)
            stack.addWidget(area)
        stack.setFixedHeight(_LINES * self.fontMetrics().lineSpacing() + Space.S)
        self.strip.changed.connect(lambda: stack.setCurrentIndex(int(self.strip.notice is not None)))
        in_row((stack, 1), in_column(self.take, self.use), of=self, margins=(Space.S, Space.XS))

    def refresh(self, *, is_mistyped: bool = False) -> None:
        """`is_mistyped`: a threshold is typed that cannot be used, so none is handed over."""
        work, proposal, unread = self._work, self._work.proposal, self._work.unread()
        limits = None if proposal is None or unread else proposal.limits
        if work.proposing.is_running:
            self._say(Icon.CLOCK, tr("Looking for thresholds…"))
        elif unread and (proposal is not None or any(log.group is not FlightGroup.UNSORTED for log in unread)):
            head = tr("No proposal: {count} of {total} not read", count=len(unread), total=len(work.logs))
            lines = [tr("Read or remove: {names}", names=_names(log.name for log in unread))]
            self._say(Icon.WARNING, head, lines, Meaning.ATTENTION)
        elif proposal is None:
            self._say(Icon.INFORMATION, tr("No proposal yet"), [tr("Choose logs, then press N or M.")])
        elif proposal.defaults is not None:
            self._say_defaults(proposal.defaults)
        elif limits is None:
            words = {FlightGroup.MUST_NOT: tr("false trigger"), FlightGroup.MUST: tr("no trigger")}
            conflicts = proposal.conflicts.items()
            lines = [labelled(capitalised(words[group]), _names(names)) for group, names in conflicts if names]
            self._say(Icon.WARNING, tr("No thresholds separate the sides"), lines, Meaning.ATTENTION)
        else:
            lines = [_margin_text(group, margin) for group, margin in proposal.nearest.items()]
            must_not = work.side(FlightGroup.MUST_NOT)
            doubtful = [one.name for one in must_not if one.outcome(limits).answer is Answer.NOT_JUDGED]
            if doubtful:
                lines.append(tr("Not judged: {names}", names=_names(doubtful)))
            self._say(Icon.CHECK, tr("Proposal: {limits}", limits=limits_text(limits)), [*lines, *bounds_lines()])
        self.take.setEnabled(limits is not None and limits != work.limits)
        self.use.setEnabled(self._exchange.can_use() and not is_mistyped)

    def _say_defaults(self, defaults: DefaultsResult) -> None:
        """With logs on one side only nothing is proposed: what the vendor's defaults do is all there is to say."""
        count, total, names = len(defaults.unexpected), defaults.total, _names(defaults.unexpected)
        lines: list[str] = []
        if defaults.not_judged:
            lines.append(tr("Not judged: {names}", names=_names(defaults.not_judged)))
        if defaults.group is FlightGroup.MUST:
            head = tr("The vendor's defaults fire in all {total}", total=total)
            if count:
                head = tr("The vendor's defaults miss {count} of {total}", count=count, total=total)
                lines.append(labelled(tr("Missed"), names))
            lines.append(tr("No proposal: no log is on the side “must not fire”."))
        else:
            head = tr("The vendor's defaults hold: they fire in 0 of {total}", total=total)
            if count:
                head = tr("The vendor's defaults fire in {count} of {total}", count=count, total=total)
                lines.append(tr("{names}: did it crash? Then it must fire.", names=names))
            elif defaults.not_judged:
                head = tr("The vendor's defaults fire in 0 of {total}, as far as judged", total=total)
            lines.append(tr("No proposal: no log is on the side “must fire”."))
        self._say(Icon.WARNING if count else Icon.CHECK, head, lines, Meaning.ATTENTION if count else None)

    def _say(self, picture: Icon, head: str, lines: Sequence[str] = (), meaning: Meaning | None = None) -> None:
        self.picture.show_icon(picture, meaning, is_muted=meaning is None)
        self.head.setText(head)
        self.lines.setText("\n".join(lines))

    def _use_proposal(self) -> None:
        proposal = self._work.proposal
        if proposal is not None and proposal.limits is not None:
            self._work.choose(proposal.limits)

    def _use(self) -> None:
        limits = self._work.limits
        values = {
            "attitude_threshold_deg": round(limits.attitude_threshold_deg),
            "freefall_acceleration_g": round(limits.freefall_acceleration_g, 1),
            "freefall_time_s": round(limits.freefall_time_s, 2),
        }
        self._exchange.used.emit(values)
        self.settings_wanted.emit()


def _names(names: Iterable[str]) -> str:
    return join_names(map(short_name, names))


def _margin_text(group: FlightGroup, margin: FlightMargin) -> str:
    """Smallest margin of a side."""
    parts: list[str] = []
    if margin.attitude_deg is not None and margin.attitude_deg >= 0:
        parts.append(f"{margin.attitude_deg}°")
    if margin.freefall_s is not None and margin.freefall_s >= 0:
        parts.append(f"{margin.freefall_s:.2f} s")
    side, what = capitalised(tr(group.value)), " · ".join(parts)
    return tr("{group}: {what} to spare ({name})", group=side, what=what, name=short_name(margin.name))


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
