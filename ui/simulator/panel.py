"""The panel of the simulated module in its dock: tilt it, drop it, disturb its line."""

import logging
from collections.abc import Callable, Sequence
from typing import Final

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QDockWidget,
    QFormLayout,
    QFrame,
    QGridLayout,
    QMainWindow,
    QPushButton,
    QSpinBox,
    QWidget,
)

from app.engine.target import Target
from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.text.i18n import tr
from app.text.messages import UserError
from protocol.translatable import marked
from ui.session.ports import Ports
from ui.style.theme import Meaning, Space, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, scroll_area, text_label
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.number_line import Dial, WheelGuard, label_for
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_MS = 200
USUAL_HEIGHT_M = 20
HIGHEST_M = 100
# Option of the simulated module, name, and value where the box is checked.
_FAULTS: Final = (
    ("mute", marked("Silent"), True),
    ("corrupt", marked("Bit errors"), 0.02),
    ("drop", marked("Lost replies"), 0.3),
    ("lag_ms", marked("Late replies"), 900.0),
)


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
        self.tilt.describe(tr("Tilt"), "")
        self.tilt.turned.connect(lambda tilt_deg: self._act(lambda bench: bench.set_world(tilt_deg=tilt_deg)))
        self.cell = Dial("simulator_cell", minimum=3.0, maximum=4.3, step=0.02, unit=" V")
        self.cell.describe(tr("Cell voltage"), "")
        self.cell.turned.connect(lambda cell_v: self._act(lambda bench: bench.set_world(cell_v=cell_v)))
        self.fall_height = control(QSpinBox(), "simulator_height", says=tr("Fall"))
        self.fall_height.setRange(1, HIGHEST_M)
        self.fall_height.setValue(USUAL_HEIGHT_M)
        self.fall_height.setSuffix(" m")
        WheelGuard(self.fall_height)
        self.drop = self._button("drop", tr("Fall"), lambda bench: bench.drop(self.fall_height.value()))
        self.bay = self._box("bay", tr("Bay open"), lambda bench, on: bench.set_world(bay_is_open=on))
        self.charger = self._box("charger", tr("External power"), lambda bench, on: bench.set_charger(is_plugged_in=on))
        self.lifelike = self._box("lifelike", tr("Wobbles"), lambda bench, on: bench.set_world(is_lifelike=on))
        self.unplugged = self._box(
            "unplugged", tr("Unplugged"), lambda bench, on: bench.unplug() if on else bench.plug()
        )
        self.faults = {name: self._fault(name, tr(text), value) for name, text, value in _FAULTS}
        self.restart = self._button("restart", tr("Restart"), SimulatedBench.restart)
        self.press = self._button("press", tr("Press switch"), SimulatedBench.press_switch)
        self.trigger = self._button("trigger", tr("PWM trigger"), SimulatedBench.pulse_pwm)
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
            self.unplugged.setChecked(not self._bench.is_plugged_in)
            for name, box in self.faults.items():
                box.setChecked(bool(getattr(module.setup, name)))
            self.drop.setEnabled(not world.is_falling(now_s))
            self.press.setEnabled(not module.is_on)

    def _fit(self) -> None:
        """As wide as the widest row: it never scrolls sideways."""
        bar_px = self._area.verticalScrollBar().sizeHint().width()
        self._area.setMinimumWidth(self._body.minimumSizeHint().width() + bar_px)
        self.refresh()

    # Making

    def _button(self, name: str, text: str, act: Callable[[SimulatedBench], object]) -> QPushButton:
        button = named(QPushButton(text), f"simulator_{name}")
        button.clicked.connect(lambda: self._act(act))
        return button

    def _box(self, name: str, text: str, switch: Callable[[SimulatedBench, bool], object]) -> QCheckBox:
        box = named(QCheckBox(text), f"simulator_{name}")
        box.clicked.connect(lambda on: self._act(lambda bench: switch(bench, on)))
        return box

    def _fault(self, name: str, text: str, value: float) -> QCheckBox:
        off = type(value)(0)
        return self._box(f"fault_{name}", text, lambda bench, on: bench.change(**{name: value if on else off}))

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setHorizontalSpacing(Space.M)
        form.setVerticalSpacing(Space.S)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow(label_for(self.tilt, tr("Tilt")), self.tilt)
        form.addRow(label_for(self.cell, tr("Cell")), self.cell)
        form.addRow(in_row((self.drop, 1), self.fall_height, spacing=Space.S))
        for box in (self.bay, self.charger, self.lifelike, self.unplugged, *self.faults.values()):
            form.addRow(box)
        buttons = QGridLayout()
        buttons.setSpacing(Space.S)
        buttons.addWidget(self.restart, 0, 0)
        buttons.addWidget(self.press, 0, 1)
        buttons.addWidget(self.trigger, 1, 0, 1, 2)
        self._body = named(QWidget(), "simulator_body")
        in_column(self.summary, form, buttons, 1, of=self._body, spacing=Space.M, margins=Space.M)
        self._area = scroll_area(self._body, "simulator_scroll", tr("Simulated module"), is_vertical=True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        in_column(self._area, of=self, margins=0)

    def _act(self, act: Callable[[SimulatedBench], object]) -> None:
        if self._bench is not None:
            act(self._bench)
            self.refresh()


def _summary(bench: SimulatedBench) -> str:
    """State that the controls do not show, in one line."""
    module = bench.module
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


_log = logging.getLogger(__name__)


class SimulatorDock(QDockWidget):
    """Controls the simulated module that is connected; disabled while there is none."""

    def __init__(self, ports: Ports, window: QMainWindow) -> None:
        super().__init__(window)
        self.setObjectName("simulator_dock")
        self._ports = ports
        self._device: str | None = None
        self._panel: SimulatorPanel | None = None
        self.setWindowTitle(tr("Simulated module"))
        self.setAccessibleName(tr("Simulated module"))
        ports.changed.connect(self._update_panel)
        areas = Qt.DockWidgetArea
        # Large text leaves no room beside the page.
        window.addDockWidget(areas.BottomDockWidgetArea if is_text_large() else areas.RightDockWidgetArea, self)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._panel is None:
            self._panel = SimulatorPanel()
            self.setWidget(self._panel)
        self._update_panel()

    def _update_panel(self) -> None:
        """Show the module of the chosen port, also while it is unplugged, so that it can be plugged in again."""
        panel = self._panel
        if panel is None:
            return
        from app.port_urls.protocol_sim import open_bench

        target = self._ports.current.target if self._ports.current.is_requested else None
        device = target.device if target is not None and target.is_simulated else None
        if device == self._device:
            return
        self._device = device
        try:
            panel.use_bench(None if device is None else open_bench(device))
        except UserError as error:  # opening the port reports the same reason
            _log.info("No simulated module at %s: %s", device, error)
            panel.use_bench(None)
