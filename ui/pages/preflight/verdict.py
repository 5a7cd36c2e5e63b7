"""Verdict banner, readable at three metres in the sun: word, shape and colour; and what it says.

Letters 15 mm high are read at three metres without effort; that is 96 px on a usual laptop. The shapes: GO is a filled
disc with a tick, READY a filled square with a padlock, NO-GO a filled octagon with a cross, void a broken ring,
everything else an outline.
"""

from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QEvent, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPaintEvent, QPalette, QResizeEvent
from PySide6.QtWidgets import QLabel, QProgressBar

from app.preflight.findings import CheckResult
from app.preflight.verdict import Assessment, Verdict, meaning_of
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences
from ui.pages.preflight.controller import PreflightController
from ui.session.check import LOUD, ModuleCheck, Standing
from ui.style.icons import themed_svg
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Size, Space, current, font, scaled
from ui.widgets.controls import named
from ui.widgets.labels import ElidedLabel, FittedLabel
from ui.widgets.layouts import in_column, in_row

HEIGHT_PX: Final = 128
LOW_PX: Final = 92
"""On a low page."""
WORD_PX: Final = 96
QUIET_PX: Final = 44
"""For a word that is no verdict."""
_MIN_TEXT_PX: Final = 300
_SHAPES: Final = Path(__file__).parent / "verdict.svg"
SPOKEN: Final = (*LOUD, Standing.VOID)
"""Announced as soon as they come."""

MAX_NAMED = 5
"""Checks named in the banner; the rows name all."""


class Announcement(NamedTuple):
    """Translated texts: `word` in large letters, beside it `head` and `lines`."""

    standing: Standing
    word: str
    head: str = ""
    lines: tuple[str, ...] = ()
    progress: float | None = None
    """0 to 1, during a check."""


def announcement(work: PreflightController) -> Announcement:
    last = work.last
    if last is None:
        return _not_checked(work)
    assessment = last.assessment
    if assessment is None:
        return _checking(last)
    if last.void is not None:
        lines = (tr("The results below are void. Check again."), _footer(last)[1])
        return Announcement(last.standing, tr("VOID"), capitalised(last.void.message.translated()), lines)
    if assessment.verdict is Verdict.NO_GO:
        return _failed(last, assessment)
    return _passed(last, assessment, is_active=work.reported_active)


def _not_checked(work: PreflightController) -> Announcement:
    """What to do first. A module that was just powered up always needs its triggers enabled."""
    head = tr("Connect or choose a module.")
    if work.can_check:
        head = tr("Start the check.")
    elif work.is_open:
        head = work.link_sentence
    lines = [tr("Set the aircraft level and do not touch it.")]
    if work.can_check and work.reported_active:
        lines = [tr("The module is ACTIVE: lock it first."), tr("Do not touch the aircraft.")]
    elif work.may_fire:
        lines = [tr(LAST_HEARD_ACTIVE), keep_away()]
    elif work.can_enable and not work.are_triggers_known:
        head = tr("Enable triggers and check")
        lines.insert(0, tr("Trigger state is unknown after power-up. Enable the triggers to set it."))
    return Announcement(Standing.NOT_CHECKED, tr("NOT CHECKED"), head, tuple(lines))


def _checking(check: ModuleCheck) -> Announcement:
    report = check.progress
    doing = tr("Link") if report is None else tr(report.doing)
    share = 0.0 if report is None or not report.total else report.done / report.total
    return Announcement(Standing.CHECKING, tr("CHECKING"), doing, (tr("Do not touch the aircraft."),), progress=share)


def _passed(check: ModuleCheck, assessment: Assessment, *, is_active: bool | None) -> Announcement:
    verdict = assessment.verdict
    head = capitalised(meaning_of(verdict, assessment.case.profile.activated_by).translated())
    if verdict is Verdict.READY and is_active is not False:
        head = tr("Reading again…")  # it may be active by now
    results = [judged.finding.result for judged in assessment.checks]
    passed, warnings = results.count(CheckResult.PASS), results.count(CheckResult.WARN)
    what = tr("Passed: {count}; warnings: {looks}.", count=passed, looks=warnings)
    skipped = sum(item.is_done is None for item in assessment.manual)
    if skipped:
        what = join_sentences((what, tr("Skipped: {count}.", count=skipped)))
    caveat, signature = _footer(check)
    return Announcement(check.standing, tr(verdict.value), head, (*filter(None, (caveat,)), what, signature))


def _failed(check: ModuleCheck, assessment: Assessment) -> Announcement:
    names = [title.translated() for title in assessment.titles_against]
    listed = join_names(names[:MAX_NAMED])
    if len(names) > MAX_NAMED:
        listed = tr("{names} and {count} more", names=listed, count=len(names) - MAX_NAMED)
    head = capitalised(meaning_of(Verdict.NO_GO, assessment.case.profile.activated_by).translated())
    # Checks are named by what must hold: "Parachute bay closed" alone would be read as the opposite of the fault.
    caveat, signature = _footer(check)
    lines = (*filter(None, (caveat,)), tr("Not met: {names}", names=listed), signature)
    return Announcement(Standing.NO_GO, tr(Verdict.NO_GO.value), head, lines)


def _footer(check: ModuleCheck) -> tuple[str, str]:
    """Caveats of the record, may be empty; then whose record it is, and how long a GO or READY holds."""
    if check.filed is None:
        return "", ""
    record = check.filed.record
    left_s = check.expires_in_s
    parts = [part for part in (record.module, record.aircraft, record.who) if part]
    parts.append(f"{record.at:%H:%M:%S}")
    if left_s is not None:
        unit_s = 1 if left_s < 120 else 60
        parts.append(tr("holds for {time}", time=duration(left_s // unit_s * unit_s)))  # never longer than it does
    return join_sentences(caveat.translated() for caveat in record.caveats), " · ".join(parts)


def low_px() -> int:
    """The height on a low page: of the head and two rows in the size of text in use."""
    rows = QFontMetricsF(font(Size.TITLE, is_bold=True)).height() + 2 * QFontMetricsF(font(Size.SMALL)).height()
    return max(LOW_PX, round(rows) + 2 * Space.S)


class VerdictBanner(PaintedWidget):
    """Shows one announcement, at a height that does not depend on it. What has no room is elided at its end."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "verdict")
        self.announcement = Announcement(Standing.NOT_CHECKED, "")
        self._word, self._head = named(QLabel(), "verdict_word"), named(ElidedLabel(), "verdict_head", "title")
        self._word.setMinimumWidth(1)  # it becomes smaller with the banner
        self._lines, self._bar = named(FittedLabel(), "verdict_lines"), QProgressBar()
        self._bar.setTextVisible(False)
        self._lines.setAlignment(Qt.AlignmentFlag.AlignTop)  # close to their head
        texts = in_column(self._head, (self._lines, 1), self._bar, spacing=0)
        self._row = in_row(self._word, (texts, 1), of=self, spacing=Space.L)
        self.use_height(HEIGHT_PX)

    def use_height(self, height_px: int) -> None:
        if height_px != self.maximumHeight():
            self.setFixedHeight(height_px)
            self._row.setContentsMargins(height_px, Space.S, Space.L, Space.S)  # the shape is painted before the word
            self._fit()

    def show_announcement(self, shown: Announcement) -> None:
        if shown == self.announcement and self.accessibleName():
            return
        self.announcement = shown
        text = ". ".join(part.rstrip(".。") for part in (shown.word, shown.head, *shown.lines) if part)
        self.setToolTip(text)
        self.announce(text, name=shown.word)
        self._word.setText(shown.word)
        self._head.setText(shown.head)
        self._lines.show_text("".join(shown.lines[:1]), "\n".join(shown.lines[1:]))
        self._bar.setVisible(shown.progress is not None)
        self._bar.setValue(round(100 * (shown.progress or 0.0)))
        self._fit()

    def _fit(self) -> None:
        """The word is as large as the height and the texts beside it allow."""
        standing = self.announcement.standing
        word_font = font(Size.HERO)
        size = WORD_PX * self.maximumHeight() // HEIGHT_PX if standing in SPOKEN else QUIET_PX
        room_px = self.width() - self.maximumHeight() - scaled(_MIN_TEXT_PX)
        word_font.setWeight(QFont.Weight.Bold)
        word_font.setPixelSize(size)
        while size > Size.NUMBER and QFontMetricsF(word_font).horizontalAdvance(self._word.text()) > room_px:
            size -= 4
            word_font.setPixelSize(size)
        self._word.setFont(word_font)
        inks = QPalette()
        inks.setColor(QPalette.ColorRole.WindowText, QColor(self._colours()[0]))
        for label in (self._word, self._head, self._lines):
            label.setPalette(inks)

    def _colours(self) -> tuple[str, str]:
        """Of what is written, and of the ground."""
        standing, theme = self.announcement.standing, current()
        if (meaning := LOUD.get(standing)) is not None:
            return theme.tint(meaning).on_fill, theme.tint(meaning).fill
        return theme.information.ink if standing is Standing.CHECKING else theme.text, theme.surface

    # Qt

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() is QEvent.Type.PaletteChange:
            self._fit()

    def paintEvent(self, _event: QPaintEvent) -> None:
        standing, theme, (ink, ground) = self.announcement.standing, current(), self._colours()
        painter = self.begin_paint()
        edges = {Standing.VOID: pen(ink, 3.0, is_dashed=True), Standing.CHECKING: pen(ink, 2.0)}
        quiet = pen(theme.border, theme.border_px, is_dashed=True)
        painter.setPen(pen(ground, 1.0) if standing in LOUD else edges.get(standing, quiet))
        painter.setBrush(QColor(ground))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(1.5, 1.5, -1.5, -1.5), 8, 8)
        side = self.height() - 2.0 * Space.L
        shape = QRectF(Space.L, Space.L, side, side)
        shapes = themed_svg(_SHAPES, ink=ink, ground=ground)
        shapes.render(painter, standing.value.replace(" ", "_"), shape)
        painter.end()
