"""Rows of the check list: a check with its result, limit and reason; a manual item with its two buttons."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QFrame, QGridLayout

from app.limits.limits import SETTING_BOUNDS
from app.preflight.findings import RESULT_WORDS, Case, Check, CheckResult, Person
from app.preflight.module_checks import RecordsWord, records_word
from app.preflight.verdict import MANUAL_WORDS, Judged
from app.settings.profiles import ManualLine
from app.settings.values import DEFAULTS
from app.text.i18n import tr
from app.text.messages import clean
from protocol.fields import Value
from protocol.translatable import marked
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning, Size, Space, is_text_large
from ui.widgets.controls import ChoiceButton, control, named, set_role
from ui.widgets.labels import text_label
from ui.widgets.readout import StateChip
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

LOCK_AND_ENABLE: Final = marked("Lock, enable and check again")
CHIP_PX: Final = 112
TITLE_PX: Final = 180
MEASURED_PX: Final = 170


STYLES: Final = {
    CheckResult.PASS: StateStyle(Icon.CHECK, Meaning.GOOD),
    CheckResult.FAIL: StateStyle(Icon.CROSS, Meaning.DANGER),
    CheckResult.WARN: StateStyle(Icon.INFORMATION, Meaning.INFORMATION),
    CheckResult.UNKNOWN: StateStyle(Icon.UNKNOWN, Meaning.UNKNOWN),
}


class Mend(Enum):
    """How a row is mended: by checking again with what a person says, or on the page that is named."""

    CHECK = "preflight"
    ENABLE = "enable"
    NAME = "module"
    APPROVE = "profile"
    WRITE = "settings"
    MEASURE = "light"
    TRIGGERS = "triggers"
    REVIEW = "records"
    TESTS = "tests"
    SERVICE = "archive"


@dataclass(frozen=True, slots=True)
class Remedy:
    """`words`: of the button, English, marked. `values`: what `WRITE` puts into Settings, by key."""

    words: str
    mend: Mend
    stated: Person = field(default_factory=Person)
    values: Mapping[str, Value] = field(default_factory=dict)


_ENABLE: Final = Remedy(marked("Enable now"), Mend.ENABLE)
_LOCK_AND_ENABLE: Final = Remedy(LOCK_AND_ENABLE, Mend.ENABLE)
_SERVICE: Final = Remedy(marked("Archive of all stations…"), Mend.SERVICE)
_SAME_MODULE: Final = Remedy(marked("It is this module"), Mend.CHECK, Person(is_same_module=True))
_APPROVE_ONCE: Final = Remedy(marked("Approve these settings"), Mend.CHECK, Person(are_settings_approved=True))
_APPROVE: Final = Remedy(marked("Approve these settings"), Mend.APPROVE)
_NAME_IT: Final = Remedy(marked("Name it"), Mend.NAME)
_MEASURE: Final = Remedy(marked("Measure"), Mend.MEASURE)
_TESTS: Final = Remedy(marked("Guided tests"), Mend.TESTS)
_REVIEW: Final = Remedy(marked("Look at the records"), Mend.REVIEW)
_TRIGGERS: Final = Remedy(marked("Triggers"), Mend.TRIGGERS)
_SETTING_KEYS: Final = {bound.check: key for key, bound in SETTING_BOUNDS.items()}


def remedy(
    judged: Judged, case: Case, *, has_profile: bool, needs_lock: bool = False, looked_at: Counter[bytes] | None = None
) -> Remedy | None:
    """What mends a row with one click, here or on the page that has the control; None where only hands can.

    `looked_at`: the trigger records that a person had before them; only those can be called reviewed.
    """
    id_, is_known = judged.check.id, judged.finding.result is not CheckResult.UNKNOWN
    if judged.finding.result is CheckResult.PASS:
        return None
    match id_:
        case "attitude_trigger" | "freefall_trigger":
            return _LOCK_AND_ENABLE if needs_lock else _ENABLE
        case "service":
            return _SERVICE
        case "trigger_records" if (word := records_word(case)) is not None and judged.blocks_go:
            if word is RecordsWord.REVIEWED and unseen_records(case, looked_at or Counter()):
                return _REVIEW
            return Remedy(word.value, Mend.CHECK, Person(are_records_reviewed=True))
        case "trigger_records" | "triggered" if judged.blocks_go:
            return _TRIGGERS
        case "boot_count" | "guided_tests" if case.past.module is None:
            return _NAME_IT
        case "boot_count" if judged.blocks_go and is_known:
            return _SAME_MODULE
        case "guided_tests":
            return _TESTS
        case "fingerprint" if is_known:
            return _APPROVE if has_profile else _APPROVE_ONCE
        case "light" if is_known:
            return _MEASURE
        case _ if is_known and id_ in _SETTING_KEYS:
            return _write(_SETTING_KEYS[id_], judged, case)
    return None


def unseen_records(case: Case, looked_at: Counter[bytes]) -> int:
    """How many records nobody has reviewed or looked at."""
    history = case.evidence.history
    if history is None:
        return 0
    return (Counter(record.raw for record in history.all) - case.past.reviewed - looked_at).total()


def _write(key: str, judged: Judged, case: Case) -> Remedy | None:
    """The profile's value, else the vendor's default; it is written in Settings, which asks what it always asks."""
    value = case.profile.settings.get(key)
    if judged.blocks_go and value is not None:
        return Remedy(marked("Write the profile's value"), Mend.WRITE, values={key: value})
    if key == "light_threshold_v":
        return _MEASURE
    return Remedy(marked("Write the default"), Mend.WRITE, values={key: DEFAULTS[key]}) if judged.blocks_go else None


class CheckRow(QFrame):
    """Before a check it shows what is checked and why. `act_wanted`: the `Remedy` of its button."""

    act_wanted = Signal(object)

    def __init__(self, check: Check) -> None:
        super().__init__()
        named(self, f"check_{check.id}", "marked-row")
        self.check = check
        self.chip = _chip(f"check_{check.id}_result")
        self._title = text_label(f"check_{check.id}_title", "strong")
        self.measured = text_label(f"check_{check.id}_measured", "")
        self.limit = text_label(f"check_{check.id}_limit", "muted")
        self.reason = text_label(f"check_{check.id}_why", "small")
        # A step: the end of a check scrolls its rows, and what comes to lie under the pointer then was not chosen.
        self.act = control(StepButton(), f"check_{check.id}_act", slot=self._on_act)
        self._act: Remedy | None = None
        self._placed: tuple[bool, bool] | None = None
        policy = self.act.sizePolicy()
        policy.setRetainSizeWhenHidden(False)
        self.act.setSizePolicy(policy)
        self.act.hide()
        grid = _grid(self)
        grid.addWidget(self.chip, 0, 0, Qt.AlignmentFlag.AlignTop)
        grid.addWidget(self._title, 0, 1)
        grid.addWidget(self.measured, 0, 2)
        grid.addWidget(self.limit, 0, 3)
        grid.addWidget(self.reason, 1, 1, 1, 2)
        self._grid = grid
        VisibilityTimer(self, restyle=self._place)
        self._place()

    @property
    def is_enabling(self) -> bool:
        """Its button enables the triggers."""
        return self._act is not None and self._act.mend is Mend.ENABLE

    def _on_act(self) -> None:
        if self._act is not None:
            self.act_wanted.emit(self._act)

    def show_waiting(self, *, is_checking: bool) -> None:
        word = tr("checking…") if is_checking else tr("not checked")
        self.chip.show_state(word, Icon.CONNECTING if is_checking else Icon.UNKNOWN, None)
        self.measured.setText("")
        self.limit.setText("")
        self._show_act(None)
        self._show_texts(tr(self.check.why), is_explained=False)
        set_role(self, "marked-row")

    def show_judged(self, judged: Judged, act: Remedy | None, *, is_void: bool) -> None:
        finding = judged.finding
        style = STYLES[finding.result]
        word = tr(RESULT_WORDS[finding.result])
        # A void result can still be read, but is dimmed and marked as void.
        self.chip.show_state(word, style.icon, style.meaning, stale_age=tr("void") if is_void else "")
        after = f" · {tr('void')}" if is_void else ""
        self.chip.reserve([f"{tr(text)}{after}" for text in RESULT_WORDS.values()])  # the columns of all rows align
        self.measured.setText(finding.shown.translated())
        self.limit.setText(finding.limit.translated())
        is_fine = finding.result is CheckResult.PASS
        do = "" if is_fine else f" → {judged.do.translated()}"
        self._show_texts(f"{tr(self.check.why)}{do}", is_explained=not is_fine)
        self._show_act(act)
        set_role(self, "marked-row-failed" if judged.blocks_go and not is_void else "marked-row")
        set_role(self.measured, "muted" if is_void else ("strong" if not is_fine else ""))

    def _show_act(self, act: Remedy | None) -> None:
        """Without a button the reason takes its column too."""
        self._act, is_shown = act, act is not None
        words = tr(act.words) if act is not None else ""
        self.act.setText(words)
        self.act.setAccessibleName(f"{words}: {tr(self.check.title)}")
        self.act.setVisible(is_shown)
        self._place()

    def _place(self) -> None:
        """The button lies beside the reason, below it where the text is large."""
        self.chip.setMinimumWidth(max(CHIP_PX, self.chip.sizeHint().width()))
        has_act, is_below = placed = self._act is not None, is_text_large()
        if placed == self._placed:
            return  # placed again, all rows would be laid out anew
        self._placed = placed
        self._grid.addWidget(self.reason, 1, 1, 1, 2 if has_act and not is_below else 3)
        side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop
        self._grid.addWidget(self.act, *((2, 1, 1, 3) if is_below else (1, 3, 1, 1)), side)

    def _show_texts(self, reason: str, *, is_explained: bool) -> None:
        title = tr(self.check.title)
        self._title.setText(title)
        self.chip.set_caption(title)
        self.reason.setText(reason)
        self.reason.setVisible(is_explained)
        self.setToolTip(reason)
        self.setWhatsThis(reason)
        parts = (title, self.chip.word, self.measured.text(), self.limit.text())
        self.setAccessibleName(", ".join(part for part in parts if part))
        self.setAccessibleDescription(reason)


class ManualRow(QFrame):
    """Done, not OK, or skipped. `ticked`: the number and True, False or None."""

    ticked = Signal(int, object)

    def __init__(self, number: int, line: ManualLine) -> None:
        super().__init__()
        name = f"manual_{number}"
        named(self, name, "marked-row")
        self.number, self.line = number, line
        self.state: bool | None = None
        self.chip = _chip(f"{name}_state")
        self._text = text_label(f"{name}_text", "strong")
        self._text.setText(clean(line.text))
        self._need = text_label(f"{name}_need", "muted")
        self.done = control(ChoiceButton(), f"{name}_done", text=tr("OK"), is_checkable=True)
        self.bad = control(ChoiceButton(), f"{name}_bad", text=tr("Not OK"), is_checkable=True)
        grid = _grid(self)
        grid.setColumnMinimumWidth(2, 0)
        for column, stretch in ((1, 5), (2, 4), (3, 0)):
            grid.setColumnStretch(column, stretch)
        grid.addWidget(self.chip, 0, 0)
        grid.addWidget(self._text, 0, 1)
        grid.addWidget(self._need, 0, 2)
        buttons = QButtonGroup(self)
        buttons.setExclusive(False)
        for place, button in enumerate((self.done, self.bad)):
            buttons.addButton(button)
            grid.addWidget(button, 0, 3 + place)
        self.done.clicked.connect(lambda is_on: self._tick(True if is_on else None))
        self.bad.clicked.connect(lambda is_on: self._tick(False if is_on else None))
        self.show_state(None)

    def show_state(self, state: bool | None, *, can_tick: bool = True) -> None:
        self.state = state
        icon, meaning = {
            True: (Icon.CHECK, Meaning.GOOD),
            False: (Icon.CROSS, Meaning.DANGER),
            None: (Icon.UNKNOWN, Meaning.UNKNOWN if self.line.is_required else None),
        }[state]
        self.chip.set_caption(clean(self.line.text))
        self.chip.show_state(tr(MANUAL_WORDS[state]), icon, meaning)
        self._need.setText(tr("required") if self.line.is_required else tr("optional"))
        for button, is_on in ((self.done, state is True), (self.bad, state is False)):
            button.setChecked(is_on)
            button.setEnabled(can_tick)
        set_role(self, "marked-row-failed" if state is False else "marked-row")
        self.setAccessibleName(f"{clean(self.line.text)}, {self.chip.word}")

    def _tick(self, state: bool | None) -> None:
        self.show_state(state)
        self.ticked.emit(self.number, state)


def _grid(row: QFrame) -> QGridLayout:
    grid = QGridLayout(row)
    grid.setContentsMargins(Space.M, 5, Space.M, 5)
    grid.setHorizontalSpacing(Space.M)
    grid.setVerticalSpacing(2)
    for column, (width, stretch) in enumerate(((CHIP_PX, 0), (TITLE_PX, 3), (MEASURED_PX, 3), (0, 3))):
        grid.setColumnMinimumWidth(column, width)
        grid.setColumnStretch(column, stretch)
    return grid


def _chip(name: str) -> StateChip:
    chip = named(StateChip("", size=Size.SMALL), name)
    chip.setMinimumWidth(CHIP_PX)
    return chip
