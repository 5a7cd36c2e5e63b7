"""The parts of the Settings page beside its table: a profile compared, the light's calibration, the baud rate."""

from typing import Final

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QCheckBox, QFrame, QGridLayout, QLabel, QPushButton, QWidget

from app.procedures.light import CalibrationFault, Proposal
from app.safety.journal import TITLES, Act
from app.safety.permit import Interlock
from app.settings.form import FORM_COMMANDS, Match, ProfileRow
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.catalogue import BAUD_RATE, Command
from protocol.translatable import marked
from ui.acts.act_row import open_conditions
from ui.acts.confirm import Confirm
from ui.forms.field_editors import HeldValue, make_editor
from ui.pages.settings.rows import LARGE_SHARES, MIDDLE, SHARES, SettingsTable
from ui.services.context import Services
from ui.session.settings_draft import Comparison, SettingsDraft, Side
from ui.style.icons import Icon
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, set_role, text_label

_HEADS: Final = (marked("Parameter"), marked("Profile"), marked("Module"), marked("State"))


def _lay_out(panel: QWidget, parts: tuple[QWidget, ...], buttons: tuple[QWidget, ...]) -> None:
    """Only the parts scroll."""
    content = QWidget()
    in_column(*parts, 1, of=content, spacing=Space.S, margins=(Space.M, Space.S))
    scroll = scroll_area(content, f"{panel.objectName()}_scroll", panel.accessibleName(), is_vertical=True)
    foot = in_row(1, *buttons, spacing=Space.S, margins=(Space.M, Space.S))
    in_column((scroll, 1), foot, of=panel, spacing=0, margins=0)


class ComparePanel(QWidget):
    """What is ticked can be written."""

    ticked = Signal(str, bool)
    """A person ticked or unticked the setting of this key."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("profile_compare")
        self.setAccessibleName(tr("Profile"))
        self.title = text_label("profile_title", "title")
        self.about = text_label("profile_about", "small")
        note = text_label("profile_note", "small")
        note.setText(tr("The baud rate is never applied with a profile."))
        self.apply = control(QPushButton(), "profile_apply", picture=Icon.CHECK, role="primary")
        self.back = control(QPushButton(tr("Back")), "profile_close", key="Esc")
        table = named(QFrame(), "profile_table", "card")
        grid = QGridLayout(table)
        grid.setHorizontalSpacing(Space.M)
        for column, english in enumerate(_HEADS):
            grid.addWidget(named(QLabel(tr(english)), f"profile_head_{column}", "caption"), 0, column)
            grid.setColumnStretch(column, 1)
        self.rows = {command.key: _CompareRow(grid, command) for command in (*FORM_COMMANDS, BAUD_RATE)}
        for key, row in self.rows.items():
            row.tick.clicked.connect(lambda is_ticked, key=key: self.ticked.emit(key, is_ticked))
        _lay_out(self, (self.title, self.about, table, note), (self.back, self.apply))

    def show_comparison(self, work: SettingsDraft, comparison: Comparison) -> None:
        profile = comparison.profile
        self.title.setText(profile.name)
        self.about.setText(" · ".join(filter(None, (profile.airframe, profile.notes, str(comparison.path)))))
        count = 0
        for row in work.compared():
            is_ticked = comparison.is_ticked(row)
            self.rows[row.command.key].show_row(row, is_ticked=is_ticked)
            if is_ticked:
                count += 1
        self.apply.setText(tr("Apply {count} ticked", count=count))
        self.apply.setEnabled(work.job.can_run and count > 0)


class _CompareRow:
    """The cells of one setting."""

    def __init__(self, grid: QGridLayout, command: Command) -> None:
        title, name = tr(command.title), command.name
        # A check box does not wrap its text.
        self.tick = named(QCheckBox(title.replace(" ", "\n") if is_text_large() else title), f"profile_tick_{name}")
        self.tick.setAccessibleName(title)
        self.wanted = named(QLabel(), f"profile_wanted_{name}", "strong")
        self.held = named(QLabel(), f"profile_stands_{name}")
        self.match = text_label(f"profile_match_{name}")
        place = grid.rowCount()
        for column, cell in enumerate((self.tick, self.wanted, self.held, self.match)):
            grid.addWidget(cell, place, column)

    def show_row(self, row: ProfileRow, *, is_ticked: bool) -> None:
        command, held = row.command, row.module_value
        self.tick.setEnabled(row.target is not None and command is not BAUD_RATE)
        self.tick.setChecked(is_ticked)
        self.wanted.setText("—" if row.target is None else value_text(command, row.target))
        self.held.setText(tr("unknown") if held is None else value_text(command, held.value))
        self.match.setText(tr(row.match.value))
        set_role(self.wanted, "muted" if row.target is None else "strong")
        set_role(self.held, "muted" if held is None or held.is_stale else "")
        set_role(self.match, "muted" if row.match in (Match.SAME, Match.NOT_IN_PROFILE) else "strong")
        for cell in (self.wanted, self.held, self.match):
            cell.setAccessibleName(labelled(tr(command.title), cell.text()))


_SIDES: Final = (
    (Side.CLOSED, marked("Bay closed"), Icon.BAY_CLOSED),
    (Side.OPEN, marked("Bay open"), Icon.BAY_OPEN),
)


class CalibrationPanel(QWidget):
    """Both positions of the bay, and below them the threshold in the middle."""

    wanted = Signal(object)
    """The `Side` that is to be measured."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("calibration")
        self.setAccessibleName(tr("Measure the light threshold"))
        title = text_label("calibration_title", "title")
        title.setText(self.accessibleName())
        intro = text_label("calibration_intro", "muted")
        intro.setText(tr("Measure in the light of the flight day, with no hand over the sensor."))
        self.texts: dict[Side, QLabel] = {}
        self.buttons: dict[Side, QPushButton] = {}
        card = named(QFrame(), "calibration_sides", "card")
        grid = QGridLayout(card)
        grid.setHorizontalSpacing(Space.M)
        grid.setColumnStretch(1, 1)
        for place, (side, english, picture) in enumerate(_SIDES):
            name, heading = f"calibration_{side.value}", f"{place + 1}. {tr(english)}"
            self.texts[side] = text_label(f"{name}_text")
            self.texts[side].setAccessibleDescription(heading)
            button = self.buttons[side] = control(QPushButton(tr("Measure")), f"{name}_measure", picture=picture)
            button.setAccessibleName(labelled(heading, tr("Measure")))
            button.clicked.connect(lambda _is_checked, side=side: self.wanted.emit(side))
            grid.addWidget(named(QLabel(heading), f"{name}_title", "strong"), place, 0)
            grid.addWidget(self.texts[side], place, 1)
            grid.addWidget(button, place, 2)
        self.result = text_label("calibration_result", "strong")
        self.detail = text_label("calibration_detail", "small")
        self.take = control(QPushButton(tr("Use this threshold")), "calibration_take", role="primary")
        self.back = control(QPushButton(tr("Back")), "calibration_back", key="Esc")
        _lay_out(self, (title, intro, card, self.result, self.detail), (self.back, self.take))

    def show_calibration(self, work: SettingsDraft) -> None:
        for side in Side:
            self.buttons[side].setEnabled(work.measure_job.can_run)
            self.texts[side].setText(_side_text(work, side))
        proposal = work.proposal
        self.take.setEnabled(isinstance(proposal, Proposal))
        if isinstance(proposal, Proposal):
            advice = tr("Vendor advises: {advice}.", advice=f"{proposal.vendors_v:.1f} V")
            steadiness = "" if proposal.is_steady else tr("The readings scatter: measure again in steady light.")
            self.result.setText(proposal.sentence)
            self.detail.setText(join_sentences((tr(proposal.direction.value), advice, steadiness)))
        else:
            self.result.setText(tr(proposal.value) if isinstance(proposal, CalibrationFault) else "")
            self.detail.setText("")


def _side_text(work: SettingsDraft, side: Side) -> str:
    if work.measuring is side:
        progress = work.measure_job.progress
        return tr("measuring… {done}", done=0 if progress is None else progress.done)
    band = None if work.bands is None else work.bands.get(side)
    if band is None or not band.raws:
        return tr("not measured yet")
    return tr("{median:.1f} V ({low:.1f} to {high:.1f} V)", median=band.median_v, low=band.low_v, high=band.high_v)


class BaudRow(QObject):
    """An act of its own, with a confirmation. What came of it is a notice of the port."""

    def __init__(self, table: SettingsTable, services: Services) -> None:
        super().__init__(table)
        self._services, self._ports = services, services.ports
        self._rate: int | None = None
        """Chosen, and not yet confirmed."""
        self.name = text_label("baud_title")
        self.name.setText(tr(BAUD_RATE.title))
        self.held = HeldValue(BAUD_RATE)
        self.editor = make_editor(BAUD_RATE)
        self.name.setBuddy(self.editor)
        self.message = text_label("baud_message", "small")
        self.confirm = Confirm("baud", ask=f"{TITLES[Act.CHANGE_BAUD]}…", go=marked("Change now"))
        place = table.add_cells(self.name, self.held, self.editor)
        if table.shares is LARGE_SHARES:
            table.grid.addWidget(self.message, place + 1, 0, 1, len(LARGE_SHARES))
        else:
            table.grid.addWidget(self.message, place, 3, 1, len(SHARES) - 3, MIDDLE)
        table.grid.addWidget(self.confirm, place + 2, 0, 1, len(table.shares))
        self.editor.chosen.connect(self._choose)
        self.confirm.confirmed.connect(self._change)

    def refresh(self) -> None:
        port = self._ports.current
        self.held.show_known(port.module.view.known(BAUD_RATE.key, port.now_s), port.now_s)
        refusals = open_conditions(self._services, Act.CHANGE_BAUD)
        if port.is_changing_rate:
            self._say(tr("Changing the baud rate…"), "small")
        elif refusals:
            self._say(join_sentences(refusal.sentence for refusal in refusals), "attention")
        else:
            self._say(tr("The vendor advises not to change it."), "small")
        # An old status does not disable the button: the procedure asks for a new one before it decides.
        is_refused = any(refusal.condition is not Interlock.FRESH_STATUS for refusal in refusals)
        is_free = port.module.is_going and not port.is_changing_rate
        self.editor.setEnabled(is_free)
        self.confirm.set_possible(is_free and not is_refused and self._rate not in (None, port.connection.baud_rate))

    def _say(self, text: str, role: str) -> None:
        self.message.setText(text)
        set_role(self.message, role)

    def _choose(self, rate: int) -> None:
        self._rate = rate
        self.confirm.withdraw()
        self.refresh()

    def forget_choice(self) -> None:
        """It was made for the module before."""
        self._rate = None
        self.editor.show_value(None, None)

    def _change(self) -> None:
        rate = self._rate
        self.forget_choice()
        if rate is not None:
            self._ports.current.change_rate(rate, self._services.armed)
