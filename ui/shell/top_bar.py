"""Top bar, visible on every page: port and link, state of the module, LOCK."""

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLayout, QPushButton, QSizePolicy, QToolButton

from app.diagnosis.link_state import LinkState, LinkText, Phase, link_text
from app.engine.conversation import ConversationView
from app.engine.target import Target, is_simulated
from app.limits.limits import LimitsInUse, value_outside
from app.safety.last_known import TriggerFlags, trigger_flags
from app.text.i18n import tr
from app.text.messages import duration, join_names, labelled
from ui.session.ports import Ports
from ui.style.icons import Icon, battery, set_icon_size
from ui.style.theme import Meaning, Space, is_text_large, scale_in_use, scaled
from ui.widgets.controls import ElidedLabel, IconLabel, control, in_column, in_row, named, set_role, without_key
from ui.widgets.readout import StateChip, age_of, show_activation, show_known_trigger, show_trigger_flags
from ui.widgets.visibility_timer import VisibilityTimer

# Usual range of a lithium cell, for the battery icon only.
EMPTY_CELL_V: Final = 3.3
FULL_CELL_V: Final = 4.2
_LEAST_NAME_PX: Final = 60
# Icon of the link, and the meaning that colours it.
_PHASES: Final = {
    Phase.CLOSED: (Icon.UNPLUGGED, Meaning.UNKNOWN),
    Phase.OPENING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.FINDING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.ASKING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.SILENT: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.ONLINE: (Icon.LINK, Meaning.GOOD),
    Phase.LATE: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.OFFLINE: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.LOST: (Icon.UNPLUGGED, Meaning.ATTENTION),
    Phase.SWITCHED_OFF: (Icon.UNPLUGGED, Meaning.INFORMATION),
    Phase.FAILED: (Icon.LINK_LOST, Meaning.ATTENTION),
}


def port_title(state: LinkState, target: Target | None) -> str:
    """Port and rate such as "ttyUSB0 · 115200", or a title for the simulated module."""
    if state.phase is Phase.CLOSED or (not state.port and target is None):
        return tr("Not connected")
    device = target.device if target is not None else state.port
    if is_simulated(device):
        return tr("Simulated module")
    name = port_name(device)
    return f"{name} · {state.baud_rate}" if state.baud_rate else name


def port_name(device: str) -> str:
    return device.removeprefix("/dev/")


class PortButton(QPushButton):
    """Shows the module's name, or the port of one without a name, above the state of the link, and opens the list of
    ports."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: object = None
        control(self, "port_button", tip=tr("Choose a port"), key="Ctrl+K", role="quiet")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._sign = IconLabel("port_sign", 20, keeps_place=True)
        self.title, self.word = named(ElidedLabel(), "port_title", "strong"), named(ElidedLabel(), "port_state")
        self.title.setMinimumWidth(scaled(_LEAST_NAME_PX))
        lines = in_column(self.title, self.word, spacing=0, margins=0)
        arrow = IconLabel("port_arrow", 12, keeps_place=True)
        arrow.show_icon(Icon.CHEVRON_DOWN, is_muted=True)
        row = in_row(self._sign, lines, arrow, 1, of=self, spacing=Space.S, margins=(Space.S, Space.XS))
        row.setSizeConstraint(QLayout.SizeConstraint.SetMinimumSize)

    def show_link(self, name: str, title: str, phase: Phase, words: LinkText) -> None:
        if (name, title, phase, words) == self._shown:
            return
        self._shown = name, title, phase, words
        picture, meaning = _PHASES[phase]
        self._sign.show_icon(picture, meaning)
        port = title.partition(" · ")[0] if is_text_large() else title
        self.title.setText(name or port)
        # Always two lines, or the bar would be lower without a module.
        state = words.word if words.word != title else words.next_step
        self.word.setText(f"{state} · {port}" if name else state)
        set_role(self.word, "attention" if meaning is Meaning.ATTENTION else "small")
        # Without the duration, which would be announced every second.
        word = tr("Offline") if phase is Phase.OFFLINE else words.word
        told = tr("Port {port}: {state}", port=title, state=word)
        self.setAccessibleName(join_names([labelled(tr("Module"), name), told] if name else [told]))
        self.setAccessibleDescription(f"{words.what} {words.next_step}".strip())


class TopBar(QFrame):
    """Port and link, module, states and LOCK, on every page. Text that is larger than usual has the states on a second
    line; what has no room then is elided, with a tooltip: the name and the port, never a state or LOCK."""

    panel_wanted = Signal()

    def __init__(self, ports: Ports, in_use: LimitsInUse) -> None:
        super().__init__()
        named(self, "top_bar", "bar")
        self._ports, self._in_use = ports, in_use
        self.menu = control(QToolButton(), "menu_button", says=tr("Menu"), key="F10", picture=Icon.MENU, role="quiet")
        set_icon_size(self.menu, 20)
        self.menu.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.port = PortButton()
        self.port.clicked.connect(self.panel_wanted)
        self.activation = named(StateChip(tr("Activation")), "activation_chip")
        self.trigger = named(StateChip(tr("Trigger")), "trigger_chip")
        self.triggers = named(StateChip(tr("triggers")), "triggers_chip")
        self.cell = named(StateChip(tr("Cell"), is_measured=True), "cell_chip")
        # Room for the widest words, so that nothing moves when a state changes.
        ages = [tr("{time} ago", time=duration(seconds)) for seconds in (59 * 60, 99, 1.9)]
        ages.append(tr("unknown"))
        self.activation.reserve((tr("LOCKED"), tr("ACTIVE"), tr("was ACTIVE"), tr("Activation")), below=ages)
        self.trigger.reserve((tr("NOT TRIGGERED"), tr("TRIGGERED")), below=ages)
        self.triggers.reserve(TriggerFlags.texts(), below=(tr("triggers"),))
        # In large text there is no room for both words, and the rare move is the lesser evil.
        both = tr("charging") if is_text_large() else join_names((tr("charging"), tr("low")))
        self.cell.reserve(("4.00 V",), below=(*ages, both))
        lock = ports.lock
        self.lock = control(QPushButton(tr("LOCK")), "lock_button", key="Ctrl+L", picture=Icon.LOCK, slot=lock.press)
        self.lock.setMinimumSize(scaled(108), scaled(40))  # for gloves, and bold while the module is active
        # Of modules that are not shown and not known to be LOCKED; where it comes and goes, no state and no LOCK moves.
        self.lock_others = control(QPushButton(), "lock_others_button", role="danger", slot=lock.press_others)
        lock.buttons.update({self.lock: lock.press, self.lock_others: lock.press_others})
        chips = (self.activation, self.trigger, self.triggers, self.cell)
        for part in (*chips, self.lock, self.lock_others):
            part.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        states = in_row(*chips, spacing=Space.XS)
        head = (self.menu, (self.port, 1), self.lock_others)
        margins = (Space.XS, Space.XS, Space.M, Space.XS)
        if scale_in_use() > 1:
            first = in_row(*head, self.lock, spacing=Space.S)
            in_column(first, in_row(1, states), of=self, spacing=Space.XS, margins=margins)
        else:
            in_row(*head, states, self.lock, of=self, spacing=Space.S, margins=margins)
        self._show_others()
        self.refresh()
        ports.any_changed.connect(self._show_others)
        for changed in (ports.changed, ports.ticked):
            changed.connect(self.refresh)
        VisibilityTimer(self, self.refresh)

    def _show_others(self) -> None:
        """One is named; of several the tooltip names all."""
        names = [port.module.name or port_name(port.connection.port) for port in self._ports.lock.others]
        self.lock_others.setVisible(bool(names))
        text = tr("LOCK ALL")
        if len(names) == 1:
            name = self.fontMetrics().elidedText(names[0], Qt.TextElideMode.ElideRight, scaled(90))
            text = tr("LOCK {module}", module=without_key(name))
        self.lock_others.setText(text)
        self.lock_others.setToolTip(tr("NOT reported, treat as ACTIVE: {names}", names=join_names(names)))

    def refresh(self) -> None:
        port, now = self._ports.current, self._ports.clock()
        module, state = port.module, port.state
        name = module.name if port.is_requested else ""
        self.port.show_link(name, port_title(state, port.target), state.phase, link_text(state, now))
        show_activation(self.activation, module.activation, now)
        triggered = module.view.known("triggered", now)
        if module.may_have_fired and (triggered is None or triggered.value is not True):
            self.trigger.show_state(tr("may have fired"), Icon.DANGER, Meaning.DANGER, detail=tr("before the restart"))
        else:
            show_known_trigger(self.trigger, triggered, now)
        show_trigger_flags(self.triggers, trigger_flags(module.view, now))
        self._show_cell(module.view, now)
        self.lock.setEnabled(port.is_requested)  # without a port it is owed
        set_role(self.lock, "primary" if port.is_active else "")

    def _show_cell(self, view: ConversationView, now: float) -> None:
        voltage, charging = view.known("cell_voltage_v", now), view.known("charging", now)
        if voltage is None:
            self.cell.show_unknown()
            return
        volts, said = float(voltage.value), []
        if charging is None:
            said.append(tr("charger unknown"))
            picture = battery(None)
        elif charging.value is True:
            # The voltage is then the charger's, so a level would be a guess.
            said.append(tr("charging"))
            picture = Icon.BOLT
        else:
            picture = battery((volts - EMPTY_CELL_V) / (FULL_CELL_V - EMPTY_CELL_V))
        meaning, detail = None, ""
        outside = value_outside("cell_voltage_v", view, now, self._in_use)
        if outside is not None:
            said.append(tr(outside.fault.value))
            picture, meaning, detail = Icon.WARNING, Meaning.ATTENTION, tr("limit {value}", value=outside.limit)
        age, below, word = age_of(voltage, now), join_names(said), f"{volts:.2f} V"
        self.cell.show_state(word, picture, meaning, below=below, stale_age=age, keeps_colour=True, detail=detail)
