"""The verdict, readable at three metres in the sun: word, shape and colour; beside it what it rests on.

GO is a filled disc with a tick, READY a filled square with a padlock, NO-GO a filled octagon with a cross, void a
broken ring; what is no verdict is an outline.
"""

from pathlib import Path
from typing import ClassVar, Final, NamedTuple

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QAccessible, QFont, QFontMetrics, QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QLabel, QProgressBar, QWidget

from app.diagnosis.link_state import Phase
from app.preflight.checks import CheckResult
from app.preflight.verdict import VALID_FOR_S, Standing, Verdict, meaning_of
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.text.i18n import tr
from app.text.messages import capitalised, duration, join_names, join_sentences
from protocol.stale_replies import TRIGGER_FLAGS
from ui.session.check import VERDICT_STYLES, ModuleCheck
from ui.session.ports import Ports
from ui.style.icons import themed_svg
from ui.style.theme import Space, current, font
from ui.widgets.controls import in_column, in_row, named, set_role, text_label

# Capitals 12 mm high on a usual laptop are read at three metres, and leave room for the rows below.
WORD_PX, QUIET_PX = 68, 32
_LOUD: Final = {Standing(verdict.value): style.meaning for verdict, style in VERDICT_STYLES.items()}
# Announced as soon as they come.
SPOKEN: Final = (*_LOUD, Standing.VOID)
# Checks named beside the verdict; the rows name all.
MAX_NAMED: Final = 5
_SHAPES: Final = Path(__file__).parent / "verdict.svg"


def can_check(ports: Ports) -> bool:
    port, check = ports.current, ports.module.check
    is_free = ports.module.is_going and (check is None or not check.is_busy)
    return port.is_open and port.state.phase not in (Phase.OPENING, Phase.FINDING) and is_free


def can_enable(ports: Ports) -> bool:
    """Nothing is written to an active module, which a person locks first."""
    return can_check(ports) and not ports.current.is_active


def has_to_enable(ports: Ports) -> bool:
    """Say whether the triggers have to be enabled first: in a new connection a check without that can only end with
    NO-GO."""
    known = [ports.module.view.known(command.key, ports.clock()) for command in TRIGGER_FLAGS]
    return can_enable(ports) and any(trigger is None or trigger.is_stale for trigger in known)


class Announcement(NamedTuple):
    """Translated texts: `word` in large letters, beside it `head` and `lines`. `progress`: 0 to 1, during a check."""

    standing: Standing
    word: str
    head: str = ""
    lines: tuple[str, ...] = ()
    progress: float | None = None


def announcement(ports: Ports) -> Announcement:
    module, now = ports.module, ports.clock()
    check, (standing, assessment, void) = module.check, module.check_state
    if check is None:
        return _not_checked(ports)
    if assessment is None:
        report = check.progress
        doing, share = (tr("Link"), 0.0) if report is None else (tr(report.doing), report.done / report.total)
        return Announcement(standing, tr("CHECKING"), doing, (tr("Do not touch the aircraft."),), progress=share)
    if void is not None:
        lines = (tr("The results below are void. Check again."), _whose(check, now))
        return Announcement(standing, tr("VOID"), capitalised(void.message.translated()), lines)
    verdict = assessment.verdict
    head = capitalised(meaning_of(verdict, assessment.case.profile.activated_by).translated())
    if verdict is Verdict.NO_GO:
        names = [title.translated() for title in assessment.titles_against]
        listed = join_names(names[:MAX_NAMED])
        if len(names) > MAX_NAMED:
            listed = tr("{names} and {count} more", names=listed, count=len(names) - MAX_NAMED)
        # Checks are named by what must hold: "Parachute bay closed" alone would be read as the opposite of the fault.
        what = tr("Not met: {names}", names=listed)
    else:
        if verdict is Verdict.READY and module.view.fresh("active", now) is not False:
            head = tr("Reading again…")  # it may be active by now
        results = [judged.finding.result for judged in assessment.checks]
        passed, warnings = results.count(CheckResult.PASS), results.count(CheckResult.WARN)
        what = tr("Passed: {count}; warnings: {looks}.", count=passed, looks=warnings)
        skipped = sum(item.is_done is None for item in assessment.case.profile.manual)
        if skipped:
            what = join_sentences((what, tr("Skipped: {count}.", count=skipped)))
    caveats = () if check.filed is None else check.filed.record.caveats
    beside = join_sentences(caveat.translated() for caveat in caveats)
    return Announcement(standing, tr(verdict.value), head, (beside, what, _whose(check, now)))


def _not_checked(ports: Ports) -> Announcement:
    """Say what to do first. A module that was just powered up always needs its triggers enabled."""
    head = tr("Connect or choose a module.")
    if can_check(ports):
        head = tr("Start the check.")
    elif ports.current.is_open:
        head = ports.current.state.what
    lines = [tr("Set the aircraft level and do not touch it.")]
    if can_check(ports) and ports.module.view.fresh("active", ports.clock()):
        lines = [tr("The module is ACTIVE: lock it first."), tr("Do not touch the aircraft.")]
    elif ports.current.is_active:
        lines = [tr(LAST_HEARD_ACTIVE), keep_away()]
    elif has_to_enable(ports):
        head = tr("Enable triggers and check")
        lines.insert(0, tr("Trigger state is unknown after power-up. Enable the triggers to set it."))
    return Announcement(Standing.NOT_CHECKED, tr("NOT CHECKED"), head, tuple(lines))


def _whose(check: ModuleCheck, now: float) -> str:
    """Whose record it is, when it was made, and how long a GO or READY holds."""
    if check.filed is None:
        return ""
    record, ended_at = check.filed.record, check.state.ended_at
    parts = [part for part in (record.module, record.aircraft, record.who) if part]
    parts.append(f"{record.at:%H:%M:%S}")
    if check.state.has_passed and ended_at is not None:
        left_s = max(0.0, VALID_FOR_S - (now - ended_at))
        unit_s = 1 if left_s < 120 else 60
        parts.append(tr("holds for {time}", time=duration(left_s // unit_s * unit_s)))  # never longer than it does
    return " · ".join(parts)


class _Shape(QWidget):
    """The shape of a standing, in the colours of the theme in use."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("verdict_shape")
        self.setFixedSize(WORD_PX, WORD_PX)
        self.standing = Standing.NOT_CHECKED

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, meaning = current(), _LOUD.get(self.standing)
        ink, ground = (theme.text, theme.surface) if meaning is None else theme.tint(meaning)[2:0:-1]
        painter = QPainter(self)
        shapes = themed_svg(_SHAPES, ink=ink, ground=ground)
        shapes.render(painter, self.standing.name, QRectF(self.rect()))
        painter.end()


class VerdictBanner(QFrame):
    """Shows one announcement; each verdict has the same height."""

    accessible_role: ClassVar = QAccessible.Role.StaticText

    def __init__(self) -> None:
        super().__init__()
        named(self, "verdict")
        self.announcement = Announcement(Standing.NOT_CHECKED, "")
        self._loud, self._quiet = QFont(font()), QFont(font())
        for letters, size_px in ((self._loud, WORD_PX), (self._quiet, QUIET_PX)):
            letters.setPixelSize(size_px)  # also where all other text is larger
            letters.setWeight(QFont.Weight.Bold)
        self._shape, self._word = _Shape(), named(QLabel(), "verdict_word")
        self._word.setMinimumHeight(QFontMetrics(self._loud).height())
        self._head, self._lines = text_label("verdict_head"), text_label("verdict_lines")
        self._bar = named(QProgressBar(), "verdict_progress")
        self._bar.setTextVisible(False)
        texts = in_column(1, self._head, self._lines, self._bar, 1, spacing=2)
        top = Qt.AlignmentFlag.AlignTop  # in sight also where long texts beside them make it higher
        parts = ((self._shape, top), (self._word, top), (texts, 1))
        in_row(*parts, of=self, spacing=Space.L, margins=(Space.L, Space.S, Space.L, Space.XS))

    def show_announcement(self, shown: Announcement) -> None:
        if shown == self.announcement and self.toolTip():
            return
        self.announcement = shown
        lines = [line for line in shown.lines if line]
        text = ". ".join(part.rstrip(".。") for part in (shown.word, shown.head, *lines) if part)
        self.setToolTip(text)
        self.setAccessibleName(text)
        self._word.setFont(self._loud if shown.standing in SPOKEN else self._quiet)
        self._word.setText(shown.word)
        self._head.setText(shown.head)
        self._lines.setText("\n".join(lines))
        self._bar.setVisible(shown.progress is not None)
        self._bar.setValue(round(100 * (shown.progress or 0.0)))
        self._shape.standing = shown.standing
        self._shape.update()
        meaning = _LOUD.get(shown.standing)
        for part in (self, self._word, self._head, self._lines):
            set_role(part, f"verdict-{'quiet' if meaning is None else meaning.value}")
