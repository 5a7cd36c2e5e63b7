""" "Would it have fired?": tries thresholds on measured data. A calculation; nothing is sent."""

from collections.abc import Mapping
from functools import partial
from math import inf
from time import perf_counter
from typing import Final, NamedTuple

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QFrame,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QToolButton,
    QWidget,
)

from app.firing import what_if_texts as fired_words
from app.firing.judge import TriggerLimits
from app.firing.what_if import WhatIfFinding, judge_excerpt
from app.firing.what_if_drafts import (
    ATTITUDE_THRESHOLD,
    FREEFALL_ACCELERATION,
    FREEFALL_TIME,
    TRIED,
    SettingSource,
    WhatIfDrafts,
)
from app.firing.what_if_texts import WhatIfKind, WhatIfRow, WhatIfVerdict
from app.recordings.measured import Measured
from app.recordings.recording import Recording
from app.samples.step_function import StepFunction
from app.system.wall_clock import clock_text
from app.text.i18n import tr
from protocol.catalogue import Command
from protocol.fields import Value
from ui.core.background_task import BackgroundTask, Running
from ui.pages.live.what_if_fields import DraftLines, WhatIfFields
from ui.services.context import Services
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import FlowRow, in_column, in_row, scroll_area
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_WIDTH_PX: Final = 376
_LEAST_PX: Final = 210
"""Of its width, in the usual size of text."""
_ROWS_IN_SIGHT: Final = 8
_STYLES: Final = {
    WhatIfKind.JUDGING: (Icon.CLOCK, Meaning.INFORMATION),
    WhatIfKind.UNJUDGED: (Icon.UNKNOWN, Meaning.UNKNOWN),
    WhatIfKind.UNANSWERED: (Icon.UNKNOWN, Meaning.ATTENTION),
    WhatIfKind.UNCERTAIN: (Icon.WARNING, Meaning.ATTENTION),
    WhatIfKind.FIRES: (Icon.PARACHUTE, Meaning.DANGER),
    WhatIfKind.HOLDS: (Icon.NOT_TRIGGERED, None),
    WhatIfKind.NEAR: (Icon.INFORMATION, None),
}
_ROW_ROLE: Final = Qt.ItemDataRole.UserRole
PACE: Final = 10
"""Live data that grew are judged again after this many times the time that the last judgement took."""


class _Asked(NamedTuple):
    """What a finding answers: it holds until one of these changes."""

    limits: TriggerLimits
    counts_locked: bool
    newest_s: float | None


class WhatIfPanel(QFrame):
    """Beside the plots while `button`, which the page shows, is pressed. Call `refresh` a few times a second."""

    instant_chosen = Signal(float)
    """To show this monotonic time in the plots."""
    lines_changed = Signal()
    """`lines` changed: draw the plots."""
    settings_wanted = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "fired_panel", "card")
        self._connector, self._exchange = services.connector, services.exchange
        self.drafts = WhatIfDrafts()
        self.lines = DraftLines()
        self.finding: WhatIfFinding | None = None
        """None until everything is judged."""
        self._judging: BackgroundTask[WhatIfFinding] = BackgroundTask("dps-s judge", self)
        self._measured: Measured | None = None
        self._asked: _Asked | None = None
        self._asked_at_s = self._took_s = 0.0
        self._wall_offset_s = 0.0
        self._rows: tuple[WhatIfRow, ...] = ()
        self._verdict: WhatIfVerdict | None = None
        self._make(services)
        self._wire()

    # Data

    def bind(self, measured: Measured, *, wall_offset_s: float) -> None:
        """Judges `measured` from now on."""
        self.release()
        self._measured, self._wall_offset_s = measured, wall_offset_s

    def release(self) -> None:
        self._judging.cancel()
        self._measured = self._asked = self.finding = None

    def refresh(self) -> None:
        if self.isHidden():
            return
        self.drafts.standing = self._standing()
        self.fields.show_drafts()
        self._show_lines()
        question = self.drafts.question()
        self._judge(question.limits)
        self._show_verdict(fired_words.verdict(self.finding, question, clock=self._clock))
        self._list(fired_words.rows(self.finding, clock=self._clock))
        self.as_module.setEnabled(bool(self.drafts.values))
        self.from_settings.setEnabled(bool(self._exchange.find_drafts()))
        self.use.setEnabled(bool(self.drafts.values) and self._exchange.can_use())

    def _judge(self, limits: TriggerLimits) -> None:
        """Judges again where the limits or the data have changed."""
        if self._measured is None:
            return
        newest = self._measured.tilt.last
        asked = _Asked(limits, self.locked.isChecked(), None if newest is None else newest.time_s)
        if asked == self._asked:
            return
        now_s = perf_counter()
        is_question_same = self._asked is not None and asked[:2] == self._asked[:2]
        if is_question_same and (self._judging.is_running or now_s - self._asked_at_s < PACE * self._took_s):
            return
        if not is_question_same:
            self.finding = None
        self._asked, self._asked_at_s = asked, now_s
        excerpt = self._measured.excerpt(-inf, inf)  # in this thread, where live data change

        def judge(_running: Running) -> WhatIfFinding:
            return judge_excerpt(excerpt, asked.limits, counts_locked=asked.counts_locked)

        self._judging.run(judge, self._on_judged)

    def _on_judged(self, finding: WhatIfFinding) -> None:
        self.finding, self._took_s = finding, perf_counter() - self._asked_at_s

    def _standing(self) -> dict[str, SettingSource]:
        """The module's settings by key, now or when it was recorded."""
        measured = self._measured
        if isinstance(measured, Recording):
            steps = {ATTITUDE_THRESHOLD: measured.fires, FREEFALL_ACCELERATION: measured.falls,
                     FREEFALL_TIME: measured.fall_times}  # fmt: skip
            last = {command.key: _last_value(step) for command, step in steps.items()}
            return {key: SettingSource(value) for key, value in last.items() if value is not None}
        device, now_s = self._connector.current.device, self._connector.clock()
        known = {command.key: device.known(command.key, now_s) for command in TRIED}
        return {key: SettingSource(value.value, value.is_stale) for key, value in known.items() if value is not None}

    def open_with(self, values: Mapping[str, Value]) -> None:
        self.drafts.fill(values)
        self.fields.show_drafts()

    def _on_another_module(self) -> None:
        """Drafts were made for the module before, or for a recording."""
        if not isinstance(self._measured, Recording):
            self.open_with({})

    # Actions

    def _show(self, is_open: bool) -> None:
        self.setVisible(is_open)
        self.refresh()
        if is_open:
            self.fields.editors[ATTITUDE_THRESHOLD.key].setFocus()
        else:
            self.button.setFocus()
            if self.lines.show(None, None):
                self.lines_changed.emit()

    def _close(self) -> None:
        self.button.setChecked(False)

    def _try(self, values: object) -> None:
        """Takes drafts from Settings."""
        if isinstance(values, Mapping):
            self.open_with(values)
            self.button.setChecked(True)

    def _use(self) -> None:
        self._exchange.used.emit(self.drafts.values)
        self.settings_wanted.emit()

    def _load_from_settings(self) -> None:
        self.open_with(self._exchange.find_drafts())

    def _on_row_chosen(self, item: QListWidgetItem) -> None:
        row = item.data(_ROW_ROLE)
        if isinstance(row, float):
            self.instant_chosen.emit(row)

    # Showing

    def _clock(self, at_s: float) -> str:
        return clock_text(at_s + self._wall_offset_s, 1)

    def _show_lines(self) -> None:
        if self.lines.show(*(self._drafted(command) for command in (ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION))):
            self.lines_changed.emit()

    def _drafted(self, command: Command) -> float | None:
        """The tried value, if it differs from the module's."""
        standing, value = self.drafts.standing.get(command.key), self.drafts.values.get(command.key)
        return None if value is None or (standing is not None and standing.value == value) else float(value)

    def _show_verdict(self, verdict: WhatIfVerdict) -> None:
        if verdict == self._verdict:
            return
        self._verdict = verdict
        self.head.setText(verdict.head)
        self.details.setText("\n".join(verdict.lines))
        self.details.setVisible(bool(verdict.lines))
        self.head.setAccessibleName(verdict.head)
        self.details.setAccessibleName("\n".join(verdict.lines))
        self._icon.show_icon(*_STYLES[verdict.kind])

    def _list(self, rows: tuple[WhatIfRow, ...]) -> None:
        """Keeps unchanged rows, so that a selected one stays selected."""
        if rows == self._rows:
            self._fit_list()  # another size of text wraps them otherwise
            return
        common = 0
        while common < min(len(rows), len(self._rows)) and rows[common] == self._rows[common]:
            common += 1
        self._rows = rows
        with QSignalBlocker(self.list):
            while self.list.count() > common:
                self.list.takeItem(common)
            for row in rows[common:]:
                item = QListWidgetItem(icon(*_STYLES[row.kind]), row.text)
                item.setData(_ROW_ROLE, row.at_s)
                item.setToolTip(row.text)
                self.list.addItem(item)
        self.list.setVisible(bool(rows))
        self._fit_list()

    def _fit_list(self) -> None:
        shown = min(self.list.count(), _ROWS_IN_SIGHT)  # the panel scrolls, not a list within it
        height = sum(self.list.sizeHintForRow(row) for row in range(shown))
        self.list.setFixedHeight(height + 2 * self.list.frameWidth() + Space.XS)

    # Construction

    def _make(self, services: Services) -> None:
        texts = services.texts
        self._icon = IconLabel("fired_icon", 20, keeps_place=True)
        self.head = text_label("fired_head", "strong")
        self.details = text_label("fired_details", "small")
        self.list = control(QListWidget(), texts, "fired_list", says="Triggers and near misses")
        self.list.setWordWrap(True)
        set_icon_size(self.list, 16)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.hide()
        self.fields = WhatIfFields(self.drafts, texts, WheelGuard(self))
        self.locked = control(QCheckBox(), texts, "fired_locked", "Also while locked")
        self.locked.setChecked(True)
        self.as_module = control(QPushButton(), texts, "fired_as_module", "As on the module")
        self.from_settings = control(QPushButton(), texts, "fired_from_settings", "From Settings",
                                     slot=self._load_from_settings)  # fmt: skip
        self.use = control(QPushButton(), texts, "fired_use", "Use in Settings", slot=self._use)
        self.about = control(QToolButton(), texts, "fired_about", "How this is judged", picture=Icon.INFORMATION,
                             role="quiet", is_checkable=True)  # fmt: skip
        self.button = control(QToolButton(), texts, "live_would_fire", "Would it have fired?", key="Ctrl+T",
                              picture=Icon.PARACHUTE, is_checkable=True)  # fmt: skip
        self.rules = text_label("fired_rules", "small")
        self.rules.hide()
        self.hide()
        self._fit()
        self._lay_out(services)

    def _fit(self) -> None:
        self.setFixedWidth(max(_WIDTH_PX, scaled(_LEAST_PX)))

    def _wire(self) -> None:
        self.list.itemClicked.connect(self._on_row_chosen)
        self.list.itemActivated.connect(self._on_row_chosen)
        self.as_module.clicked.connect(partial(self.open_with, {}))
        self._connector.invalidated.connect(self._on_another_module)
        self.about.toggled.connect(self.rules.setVisible)
        self.button.toggled.connect(self._show)
        self._exchange.tried.connect(self._try)
        VisibilityTimer(self, retranslate=self._retranslate, restyle=self._fit)
        self._retranslate()

    def _lay_out(self, services: Services) -> None:
        texts = services.texts
        title = text_label("fired_title", "strong")
        texts.bind(title.setText, "Would it have fired?")
        close = control(QToolButton(), texts, "fired_close", says="Close", key="Esc",
                        picture=Icon.CROSS, role="quiet", slot=self._close)  # fmt: skip
        note = text_label("fired_note", "small")
        texts.bind(note.setText, "Nothing is sent.")
        head = in_row((title, 1), close)
        verdict = in_row((self._icon, Qt.AlignmentFlag.AlignTop), (self.head, 1), spacing=Space.S)
        starts = FlowRow()
        starts.add(self.as_module, self.from_settings, self.use)
        content = named(QWidget(), "fired_content")
        in_column(
            self.fields, self.details, self.list, self.locked, starts, (self.about, Qt.AlignmentFlag.AlignLeft),
            self.rules, 1, of=content, spacing=Space.S, margins=(0, Space.XS, 2, 0),
        )  # fmt: skip
        scroll = scroll_area(
            content, texts, "fired_scroll", "Would it have fired?", is_vertical=True, is_transparent=True
        )
        in_column(
            head, note, verdict, (scroll, 1), of=self, spacing=Space.XS, margins=(Space.M, Space.S, Space.XS, Space.S)
        )

    def _retranslate(self) -> None:
        self.rules.setText("\n".join(f"• {tr(rule)}" for rule in fired_words.ABOUT))
        self._verdict = None

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self._close()
        else:
            super().keyPressEvent(event)


def _last_value(steps: StepFunction) -> float | None:
    values = [change.value for change in steps.between(-inf, inf) if change.value is not None]
    return values[-1] if values else None
