"""The panel of the simulated module in its dock: tilt it, drop it, disturb its line."""

import logging
from collections.abc import Callable
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QDockWidget, QFormLayout, QFrame, QMainWindow, QPushButton, QSpinBox, QWidget

from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.text.i18n import tr
from app.text.messages import UserError
from protocol.translatable import marked
from ui.session.ports import Ports
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import in_column, in_row, named, scroll_area, text_label
from ui.widgets.number_line import Dial, NumberKind, WheelGuard, label_for
from ui.widgets.visibility_timer import VisibilityTimer

_log = logging.getLogger(__name__)
REFRESH_MS: Final = 200
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
        self.tilt = Dial("simulator_tilt", NumberKind.of(0, 180, 1, "°", 0))
        self.tilt.describe(tr("Tilt"), "")
        self.tilt.turned.connect(lambda tilt_deg: self._act(lambda bench: bench.set_world(tilt_deg=tilt_deg)))
        self.cell = Dial("simulator_cell", NumberKind.of(3.0, 4.3, 0.02, "V", 2))
        self.cell.describe(tr("Cell voltage"), "")
        self.cell.turned.connect(lambda cell_v: self._act(lambda bench: bench.set_world(cell_v=cell_v)))
        self.fall_height = named(QSpinBox(), "simulator_height", says=tr("Fall"))
        self.fall_height.setRange(1, 100)
        self.fall_height.setValue(20)
        self.fall_height.setSuffix(" m")
        WheelGuard(self.fall_height)
        self.drop = self._button("drop", tr("Fall"), lambda bench: bench.drop(self.fall_height.value()))
        self._form = form = QFormLayout()
        form.setHorizontalSpacing(Space.M)
        form.setVerticalSpacing(Space.S)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        for dial, title in ((self.tilt, tr("Tilt")), (self.cell, tr("Cell"))):
            form.addRow(label_for(dial, title), dial)
            form.addRow(dial.range)
        form.addRow(in_row((self.drop, 1), self.fall_height, spacing=Space.S))
        self.bay = self._box("bay", tr("Bay open"), lambda bench, on: bench.set_world(bay_is_open=on))
        self.charger = self._box("charger", tr("External power"), lambda bench, on: bench.set_charger(is_plugged_in=on))
        self.lifelike = self._box("lifelike", tr("Wobbles"), lambda bench, on: bench.set_world(is_lifelike=on))
        self.unplugged = self._box(
            "unplugged", tr("Unplugged"), lambda bench, on: bench.unplug() if on else bench.plug()
        )
        self.faults: dict[str, QCheckBox] = {}
        for name, text, value in _FAULTS:

            def set_fault(bench: SimulatedBench, on: bool, name: str = name, value: float = value) -> None:
                bench.change(**{name: value if on else type(value)(0)})

            self.faults[name] = self._box(f"fault_{name}", tr(text), set_fault)
        self.restart = self._button("restart", tr("Restart"), lambda bench: bench.restart())
        self.trigger = self._button("trigger", tr("PWM trigger"), lambda bench: bench.pulse_pwm())
        self._body = named(QWidget(), "simulator_body")
        buttons = in_row(self.restart, self.trigger, spacing=Space.S)
        parts = (self.summary, form, buttons, 1)
        in_column(*parts, of=self._body, spacing=Space.M, margins=Space.M)
        self._area = scroll_area(self._body, "simulator_scroll", tr("Simulated module"), is_vertical=True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        in_column(self._area, of=self, margins=0)
        VisibilityTimer(self, self._fit, tick=self.refresh, every_ms=REFRESH_MS)
        self.use_bench(None)

    def _button(self, name: str, text: str, act: Callable[[SimulatedBench], object]) -> QPushButton:
        button = named(QPushButton(text), f"simulator_{name}")
        button.clicked.connect(lambda: self._act(act))
        return button

    def _box(self, name: str, text: str, switch: Callable[[SimulatedBench, bool], object]) -> QCheckBox:
        box = named(QCheckBox(text), f"simulator_{name}")
        box.clicked.connect(lambda on: self._act(lambda bench: switch(bench, on)))
        self._form.addRow(box)
        return box

    def _act(self, act: Callable[[SimulatedBench], object]) -> None:
        if self._bench is not None:
            act(self._bench)
            self.refresh()

    def use_bench(self, bench: SimulatedBench | None) -> None:
        """The module to control; None disables the panel."""
        self._bench = bench
        self._body.setEnabled(bench is not None)
        self.refresh()

    def _fit(self) -> None:
        """As wide as the widest row: it never scrolls sideways."""
        bar_px = self._area.verticalScrollBar().sizeHint().width()
        self._area.setMinimumWidth(self._body.minimumSizeHint().width() + bar_px)
        self.refresh()

    def refresh(self) -> None:
        bench = self._bench
        if bench is None:
            self.summary.setText(tr("No simulated module"))
            return
        with bench.at_present() as now_s:
            world, module = bench.world, bench.module
            # What the controls do not show.
            parts = (
                tr("active") if module.state.is_active else tr("locked"),
                tr("triggered") if module.is_triggered else tr("not triggered"),
                f"{tr('Boot count')} {module.memory.boot_count}",
                f"{tr('Trigger records')} {len(module.memory.records)}",
                tr("{rate} baud", rate=module.baud_rate),
            )
            self.summary.setText(" · ".join(parts) if module.is_on else tr("Power off"))
            self.tilt.show_value(abs(world.tilt_deg))
            self.cell.show_value(world.cell_v)
            self.bay.setChecked(world.bay_is_open)
            self.charger.setChecked(world.has_external_power)
            self.lifelike.setChecked(world.is_lifelike)
            self.unplugged.setChecked(not bench.is_plugged_in)
            for name, box in self.faults.items():
                box.setChecked(bool(getattr(module.setup, name)))
            self.drop.setEnabled(not world.is_falling(now_s))


class SimulatorDock(QDockWidget):
    """Controls the simulated module that is connected; disabled while there is none."""

    def __init__(self, ports: Ports, window: QMainWindow) -> None:
        super().__init__(tr("Simulated module"), window)
        self.setObjectName("simulator_dock")
        self.setAccessibleName(tr("Simulated module"))
        self._ports = ports
        self._device: str | None = None
        self._panel = SimulatorPanel()
        self.setWidget(self._panel)
        areas = Qt.DockWidgetArea
        # Large text leaves no room beside the page.
        window.addDockWidget(areas.BottomDockWidgetArea if is_text_large() else areas.RightDockWidgetArea, self)
        ports.changed.connect(self._update_panel)
        self._update_panel()

    def _update_panel(self) -> None:
        """Show the module of the chosen port, also while it is unplugged, so that it can be plugged in again."""
        target = self._ports.current.target if self._ports.current.is_requested else None
        device = target.device if target is not None and target.is_simulated else None
        if device == self._device:
            return
        self._device, bench = device, None
        try:
            bench = None if device is None else open_bench(device)
        except UserError as error:  # opening the port reports the same reason
            _log.info("No simulated module at %s: %s", device, error)
        self._panel.use_bench(bench)
