"""Panel of the simulated module: tilt it, drop it, disturb its line; puts it at rest for a check that fails so."""

from collections.abc import Callable, Sequence
from typing import Final

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QCheckBox, QFormLayout, QFrame, QGridLayout, QPushButton, QSpinBox, QWidget

from app.engine.target import Target
from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.text.i18n import tr
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.sliders import NUMBER_PX, Dial, WheelGuard, label_for
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_MS = 200
USUAL_HEIGHT_M = 20
HIGHEST_M = 100
_FAULTS: Final = (
    ("mute", marked("Silent"), True),
    ("corrupt", marked("Bit errors"), 0.02),
    ("drop", marked("Lost replies"), 0.3),
    ("lag_ms", marked("Late replies"), 900.0),
)
"""Option of the simulated module, name, and value where the box is checked."""


class SimulatorPanel(QWidget):
    """Controls of a simulated module, which follow its state.

    Activating is not among them: it goes through the protocol, as for a real module.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("simulator_panel")
        self._bench: SimulatedBench | None = None
        self.summary = text_label("simulator_summary", "muted")
        self.tilt = Dial("simulator_tilt", minimum=0, maximum=180, step=1, unit="°")
        self.fall_height = control(QSpinBox(), "simulator_height", says=tr("Fall"))
        self.drop = named(QPushButton(), "simulator_drop")
        self.bay = named(QCheckBox(tr("Bay open")), "simulator_bay")
        self.cell = Dial("simulator_cell", minimum=3.0, maximum=4.3, step=0.02, unit=" V")
        self.charger = named(QCheckBox(tr("External power")), "simulator_charger")
        self.lifelike = named(QCheckBox(tr("Wobbles")), "simulator_lifelike")
        self.restart = named(QPushButton(tr("Restart")), "simulator_restart")
        self.press = named(QPushButton(tr("Press switch")), "simulator_press")
        self.trigger = named(QPushButton(tr("PWM trigger")), "simulator_trigger")
        self.faults = {name: named(QCheckBox(tr(text)), f"simulator_fault_{name}") for name, text, _ in _FAULTS}
        self.plug = QPushButton()
        self._connect()
        self._name()
        self._lay_out()
        VisibilityTimer(
            self,
            self._fit,
            tick=self.refresh,
            every_ms=REFRESH_MS,
            restyle=lambda: QTimer.singleShot(0, self, self._fit),  # after the controls have the new style
        )
        self.use_bench(None)

    def use_bench(self, bench: SimulatedBench | None) -> None:
        """The module to control; None disables the panel."""
        self._bench = bench
        self._body.setEnabled(bench is not None)
        self.refresh()

    def refresh(self) -> None:
        if self._bench is None:
            self.summary.setText(tr("No simulated module"))
            return
        with self._bench.at_present() as now_s:
            world = self._bench.world
            module = self._bench.module
            self.summary.setText(_summary(self._bench))
            self.tilt.show_value(abs(world.tilt_deg))
            self.cell.show_value(world.cell_v)
            self.bay.setChecked(world.bay_is_open)
            self.charger.setChecked(world.has_external_power)
            self.lifelike.setChecked(world.is_lifelike)
            for name, box in self.faults.items():
                box.setChecked(bool(getattr(module.setup, name)))
            self.drop.setEnabled(not world.is_falling(now_s))
            self.press.setEnabled(not module.is_on)
            self._name_plug(is_plugged_in=self._bench.is_plugged_in)

    def _fit(self) -> None:
        """As wide as the widest row: it never scrolls sideways."""
        bar_px = self._area.verticalScrollBar().sizeHint().width()
        self._area.setMinimumWidth(self._body.minimumSizeHint().width() + bar_px)
        self.refresh()

    # Making

    def _connect(self) -> None:
        self.fall_height.setRange(1, HIGHEST_M)
        self.fall_height.setValue(USUAL_HEIGHT_M)
        self.fall_height.setSuffix(" m")
        self.fall_height.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.fall_height.setFixedWidth(scaled(NUMBER_PX))
        WheelGuard(self.fall_height)
        self.fall_height.valueChanged.connect(self._name_drop)
        self.tilt.turned.connect(lambda tilt_deg: self._act(lambda bench: bench.set_world(tilt_deg=tilt_deg)))
        self.cell.turned.connect(lambda cell_v: self._act(lambda bench: bench.set_world(cell_v=cell_v)))
        self.drop.clicked.connect(lambda: self._act(lambda bench: bench.drop(self.fall_height.value())))
        self.bay.clicked.connect(lambda on: self._act(lambda bench: bench.set_world(bay_is_open=on)))
        self.charger.clicked.connect(lambda on: self._act(lambda bench: bench.set_charger(is_plugged_in=on)))
        self.lifelike.clicked.connect(lambda on: self._act(lambda bench: bench.set_world(is_lifelike=on)))
        self.restart.clicked.connect(lambda: self._act(SimulatedBench.restart))
        self.press.clicked.connect(lambda: self._act(SimulatedBench.press_switch))
        self.plug.clicked.connect(lambda: self._act(_toggle_plug))
        self.trigger.clicked.connect(lambda: self._act(SimulatedBench.pulse_pwm))
        for name, _, value in _FAULTS:
            self.faults[name].clicked.connect(lambda on, name=name, value=value: self._set_fault(name, value, on))

    def _name(self) -> None:
        self.tilt.describe(tr("Tilt"), "")
        self.cell.describe(tr("Cell voltage"), "")
        self._name_drop(self.fall_height.value())
        self._name_plug(is_plugged_in=True)

    def _name_drop(self, height_m: int) -> None:
        self.drop.setText(tr("Drop {height} m", height=height_m))

    def _name_plug(self, *, is_plugged_in: bool) -> None:
        if self.plug.property("is_plugged_in") is is_plugged_in:
            return
        self.plug.setProperty("is_plugged_in", is_plugged_in)
        text = marked("Unplug") if is_plugged_in else marked("Plug in")
        control(self.plug, "simulator_plug", text=tr(text))

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setHorizontalSpacing(Space.M)
        form.setVerticalSpacing(Space.S)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow(label_for(self.tilt, tr("Tilt")), self.tilt)
        form.addRow(label_for(self.cell, tr("Cell")), self.cell)
        fall = in_row((self.drop, 1), self.fall_height, spacing=Space.S)
        form.addRow(label_for(self.fall_height, tr("Fall")), fall)
        for box in (self.bay, self.charger, self.lifelike, *self.faults.values()):
            form.addRow(box)
        buttons = QGridLayout()
        buttons.setSpacing(Space.S)
        buttons.addWidget(self.restart, 0, 0)
        buttons.addWidget(self.plug, 0, 1)
        buttons.addWidget(self.press, 1, 0)
        buttons.addWidget(self.trigger, 1, 1)
        self._body = named(QWidget(), "simulator_body")
        in_column(self.summary, form, buttons, 1, of=self._body, spacing=Space.M, margins=Space.M)
        self._area = scroll_area(self._body, "simulator_scroll", tr("Simulated module"), is_vertical=True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        in_column(self._area, of=self, margins=0)

    # Acting

    def _set_fault(self, name: str, value: float, is_on: bool) -> None:
        self._act(lambda bench: bench.change(**{name: value if is_on else type(value)(0)}))

    def _act(self, act: Callable[[SimulatedBench], object]) -> None:
        if self._bench is not None:
            act(self._bench)
            self.refresh()


def _toggle_plug(bench: SimulatedBench) -> None:
    if bench.is_plugged_in:
        bench.unplug()
    else:
        bench.plug()


def _summary(bench: SimulatedBench) -> str:
    """State that the controls do not show, in one line."""
    module = bench.module
    if not bench.is_plugged_in:
        return tr("Unplugged")
    if not module.is_on:
        return tr("Power off")
    parts = [
        tr("active") if module.state.is_active else tr("locked"),
        tr("triggered") if module.is_triggered else tr("not triggered"),
        f"{tr('Boot count')} {module.memory.boot_count}",
        f"{tr('Trigger records')} {len(module.memory.records)}",
        tr("{rate} baud", rate=module.baud_rate),
    ]
    return " · ".join(parts)


_OF_REST: Final = frozenset(("tilt", "tilt_spread", "acceleration", "acceleration_spread"))


def rest_offer(target: Target | None, against: Sequence[str], check_again: Callable[[], object]) -> Notice | None:
    """None if the module is real or at rest, or if no check of rest failed."""
    if target is None or not target.is_simulated or not _OF_REST.intersection(against):
        return None
    try:
        bench = open_bench(target.device)
    except UserError:
        return None
    if not bench.world.is_lifelike and not bench.world.tilt_deg:
        return None

    def set_down() -> None:
        bench.set_world(is_lifelike=False, tilt_deg=0)
        check_again()

    text = tr("The simulated module is not at rest.")
    return Notice(Meaning.INFORMATION, text, (Choice("set_down", tr("Set down, check again"), set_down),))
