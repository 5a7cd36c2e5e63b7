"""Verdict banner, readable at three metres in the sun: word, shape and colour; and what it says.

Letters 15 mm high are read at three metres without effort; that is 96 px on a usual laptop. The shapes: GO is a filled
disc with a tick, READY a filled square with a padlock, NO-GO a filled octagon with a cross, void a broken ring,
everything else an outline.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QSizePolicy

from app.preflight.findings import CheckResult
from app.preflight.verdict import CHECKS, VERDICT_WORDS, Assessment, Verdict, meaning_of
from app.records.record import caveats
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences
from ui.pages.preflight.controller import PreflightController, Standing
from ui.style.icons import themed_svg
from ui.style.painted_widget import PaintedWidget, hatch, pen
from ui.style.theme import Meaning, Size, Space, Theme, current, font, scaled

HEIGHT_PX: Final = 128
LOW_PX: Final = 92
"""On a low page."""
WORD_PX: Final = 96
QUIET_PX: Final = 44
"""For a word that is no verdict."""
_MIN_TEXT_PX: Final = 300
_SHAPES: Final = Path(__file__).parent / "verdict.svg"
_LOUD: Final = {
    Standing.GO: Meaning.GOOD,
    Standing.READY: Meaning.INFORMATION,
    Standing.NO_GO: Meaning.DANGER,
}
SPOKEN: Final = (*_LOUD, Standing.VOID)
"""Announced as soon as they come."""

MAX_NAMED = 5
"""Checks named in the banner; the rows name all."""


@dataclass(frozen=True, slots=True)
class Announcement:
    """Translated texts: `word` in large letters, beside it `head` and `lines`."""

    standing: Standing
    word: str
    head: str = ""
    lines: tuple[str, ...] = ()
    progress: float | None = None
    """0 to 1, during a check."""


def announcement(work: PreflightController) -> Announcement:
    standing, assessment = work.standing, work.assessment
    match standing:
        case Standing.CHECKING:
            return _checking(work)
        case Standing.VOID if work.void is not None:
            lines = (tr("The results below are void. Check again."), _footer(work)[1])
            return Announcement(standing, tr("VOID"), capitalised(work.void.message.translated()), lines)
        case Standing.GO | Standing.READY if assessment is not None:
            return _passed(work, assessment)
        case Standing.NO_GO if assessment is not None:
            return _failed(work, assessment)
        case _:
            return _not_checked(work)


def _not_checked(work: PreflightController) -> Announcement:
    """What to do first. A module that was just powered up always needs its triggers enabled."""
    head = tr("Start the check.") if work.can_check else tr("Connect a module.")
    lines = [tr("Set the aircraft level and do not touch it.")]
    if work.can_check and work.reported_active:
        lines = [tr("The module is ACTIVE: lock it first."), tr("Do not touch the aircraft.")]
    elif work.can_check and work.may_fire:
        lines = [tr(LAST_HEARD_ACTIVE), keep_away()]
    elif work.can_check and not work.are_triggers_known:
        head = tr("Enable triggers and check")
        lines.insert(0, tr("Trigger state is unknown after power-up. Enable the triggers to set it."))
    return Announcement(Standing.NOT_CHECKED, tr("NOT CHECKED"), head, tuple(lines))


def _checking(work: PreflightController) -> Announcement:
    report = work.progress
    doing = tr("Link") if report is None else tr(report.doing)
    share = 0.0 if report is None or not report.total else report.done / report.total
    return Announcement(Standing.CHECKING, tr("CHECKING"), doing, (tr("Do not touch the aircraft."),), progress=share)


def _passed(work: PreflightController, assessment: Assessment) -> Announcement:
    verdict = assessment.verdict
    head = capitalised(meaning_of(verdict, assessment.case.profile.activated_by).translated())
    if verdict is Verdict.READY and work.reported_active is not False:
        head = tr("Reading again…")  # it may be active by now
    warnings = sum(check.finding.result is CheckResult.WARN for check in assessment.checks)
    what = tr("All {count} checks passed; warnings: {looks}.", count=len(CHECKS), looks=warnings)
    skipped = sum(item.is_done is None for item in assessment.manual)
    if skipped:
        what = join_sentences((what, tr("Skipped: {count}.", count=skipped)))
    caveat, signature = _footer(work)
    return Announcement(work.standing, tr(VERDICT_WORDS[verdict]), head, (*filter(None, (caveat,)), what, signature))


def _failed(work: PreflightController, assessment: Assessment) -> Announcement:
    names = [one.translated() for one in assessment.titles_against]
    named = join_names(names[:MAX_NAMED])
    if len(names) > MAX_NAMED:
        named = tr("{names} and {count} more", names=named, count=len(names) - MAX_NAMED)
    head = capitalised(meaning_of(Verdict.NO_GO, assessment.case.profile.activated_by).translated())
    # Checks are named by what must hold: "Parachute bay closed" alone would be read as the opposite of the fault.
    lines = (tr("Not met: {names}", names=named), *filter(None, _footer(work)))
    return Announcement(Standing.NO_GO, tr(VERDICT_WORDS[Verdict.NO_GO]), head, lines)


def _footer(work: PreflightController) -> tuple[str, str]:
    """Caveats of the record, may be empty; then whose record it is, and how long a GO or READY holds."""
    if work.filed is None:
        return "", ""
    record, left_s = work.filed.record, work.expires_in_s
    parts = [str(record[key]) for key in ("module", "aircraft", "who") if record.get(key)]
    parts.append(str(record.get("at", ""))[11:19])
    if left_s is not None:
        unit_s = 1 if left_s < 120 else 60
        parts.append(tr("holds for {time}", time=duration(left_s // unit_s * unit_s)))  # never longer than it does
    return join_sentences(caveat.translated() for caveat in caveats(record)), " · ".join(parts)


def low_px() -> int:
    """The height on a low page: of the head and two rows in the size of text in use."""
    rows = QFontMetricsF(font(Size.TITLE, is_bold=True)).height() + 2 * QFontMetricsF(font(Size.SMALL)).height()
    return max(LOW_PX, round(rows) + 2 * Space.S)


class VerdictBanner(PaintedWidget):
    """Shows one announcement, at a height that does not depend on it."""

    def __init__(self, announcement: Announcement) -> None:
        super().__init__()
        self.setObjectName("verdict")
        self.announcement = announcement
        self._height_px = HEIGHT_PX
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def use_height(self, height_px: int) -> None:
        if height_px != self._height_px:
            self._height_px = height_px
            self.updateGeometry()

    def show_announcement(self, announcement: Announcement) -> None:
        if announcement != self.announcement or not self.accessibleName():
            self.announcement = announcement
            parts = (announcement.word, announcement.head, *announcement.lines)
            text = ". ".join(part.rstrip(".。") for part in parts if part)
            self.setToolTip(text)
            self.announce(text, name=announcement.word)

    def sizeHint(self) -> QSize:
        return QSize(640, self._height_px)

    def minimumSizeHint(self) -> QSize:
        return QSize(320, self._height_px)

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, one = current(), self.announcement
        painter = self.begin_paint()
        edge = float(theme.border_px)
        outline = QPainterPath()
        outline.addRoundedRect(QRectF(self.rect()).adjusted(edge / 2, edge / 2, -edge / 2, -edge / 2), 8, 8)
        ink = self._paint_ground(painter, theme, outline)
        side = self.height() - 2.0 * Space.M - 4
        shape = QRectF(Space.L, (self.height() - side) / 2, side, side)
        shapes = themed_svg(_SHAPES, ink=ink.name(), ground=self._ground(theme))
        shapes.render(painter, one.standing.value.replace(" ", "_"), shape)
        left = shape.right() + Space.L
        word_font = self._word_font(self.width() - left - scaled(_MIN_TEXT_PX))
        metrics = QFontMetricsF(word_font)
        width = metrics.horizontalAdvance(one.word)
        room = QRectF(left, 0, width + 2, self.height())
        if one.standing is Standing.VOID:
            _clear(painter, QColor(theme.surface), room, metrics.height())
        painter.setFont(word_font)
        painter.setPen(ink)
        painter.drawText(room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, one.word)
        self._paint_text(painter, room.right() + Space.XL, ink)
        painter.end()

    def _ground(self, theme: Theme) -> str:
        loud = _LOUD.get(self.announcement.standing)
        return theme.surface if loud is None else theme.tint(loud).fill

    def _paint_ground(self, painter: QPainter, theme: Theme, outline: QPainterPath) -> QColor:
        """Paint the background; return the colour of the text on it."""
        standing = self.announcement.standing
        loud = _LOUD.get(standing)
        painter.fillPath(outline, QColor(self._ground(theme)))
        if loud is not None:
            return QColor(theme.tint(loud).on_fill)
        if standing is Standing.VOID:
            hatch(painter, outline, theme.muted if theme.line_px > 1 else theme.border)
            painter.setPen(pen(theme.text, 3.0, is_dashed=True))
        elif standing is Standing.CHECKING:
            painter.setPen(pen(theme.information.ink, 2.0))
        else:
            painter.setPen(pen(theme.border, theme.border_px, is_dashed=True))
        painter.drawPath(outline)
        return QColor(theme.information.ink if standing is Standing.CHECKING else theme.text)

    def _word_font(self, room_px: float) -> QFont:
        is_big = self.announcement.standing in SPOKEN
        one = font(Size.HERO)
        one.setWeight(QFont.Weight.Bold)
        size = WORD_PX * self._height_px // HEIGHT_PX if is_big else QUIET_PX
        one.setPixelSize(size)
        while size > Size.NUMBER and QFontMetricsF(one).horizontalAdvance(self.announcement.word) > room_px:
            size -= 4
            one.setPixelSize(size)
        return one

    def _paint_text(self, painter: QPainter, left: float, ink: QColor) -> None:
        theme, one = current(), self.announcement
        width = self.width() - left - Space.L
        if width < 60:
            return
        head_font = font(Size.TITLE, is_bold=True)
        head_font.setWeight(QFont.Weight.DemiBold)
        flags = int(Qt.AlignmentFlag.AlignLeft) | int(Qt.TextFlag.TextWordWrap)
        head_px = text_px(head_font, width, one.head)
        bar_px = 14.0 if one.progress is not None else 0.0
        body_font, body = fitted(one.lines, width, self.height() - 2 * Space.S - head_px - bar_px)
        body_px = text_px(body_font, width, body)
        top = max(float(Space.XS), (self.height() - head_px - body_px - bar_px) / 2)
        if one.standing is Standing.VOID:
            _clear(painter, QColor(theme.surface), QRectF(left, 0, width, self.height()), head_px + body_px)
        painter.setPen(ink)
        painter.setFont(head_font)
        painter.drawText(QRectF(left, top, width, head_px), flags, one.head)
        painter.setFont(body_font)
        painter.drawText(QRectF(left, top + head_px, width, body_px), flags, body)
        if one.progress is not None:
            bar = QRectF(left, top + head_px + body_px + 8, width, 6)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(theme.sunken if theme.border_px == 1 else theme.selection))
            painter.drawRoundedRect(bar, 3, 3)
            painter.setBrush(ink)
            painter.drawRoundedRect(QRectF(bar.left(), bar.top(), bar.width() * one.progress, bar.height()), 3, 3)


def text_px(one: QFont, width: float, text: str) -> float:
    """The height of a wrapped text."""
    flags = int(Qt.AlignmentFlag.AlignLeft) | int(Qt.TextFlag.TextWordWrap)
    return QFontMetricsF(one).boundingRect(QRectF(0, 0, width, 1000), flags, text).height() if text else 0.0


def fitted(lines: Sequence[str], width: float, room_px: float) -> tuple[QFont, str]:
    """The lines wrapped in the largest font that fits; else one row for each line, or for the rest of them, elided."""
    for size in (Size.BODY, Size.SMALL):
        one, text = font(size), "\n".join(lines)
        if text_px(one, width, text) <= room_px:
            return one, text
    metrics = QFontMetricsF(one)
    last = max(0, int(room_px // metrics.height()) - 1)
    lines = (*lines[:last], join_sentences(lines[last:]))
    return one, "\n".join(metrics.elidedText(line, Qt.TextElideMode.ElideRight, width - 2) for line in lines)


def _clear(painter: QPainter, colour: QColor, room: QRectF, height_px: float) -> None:
    """Plain background for words on hatching."""
    ground = QRectF(0, 0, room.width() + 2 * Space.S, min(height_px, room.height() - 8) + 4)
    ground.moveCenter(room.center())
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawRoundedRect(ground, 6, 6)
