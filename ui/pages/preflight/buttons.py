"""Button row of the Pre-flight page: the main button at the right."""

from PySide6.QtWidgets import QPushButton, QWidget

from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.preflight.controller import PreflightController, Standing
from ui.services.page import PageHeader
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control, rename, set_role
from ui.widgets.layouts import FlowRow
from ui.widgets.step_button import StepButton


class PreflightButtons(QWidget):
    """Makes the next step the primary button: enable and check, start, check again, or export."""

    def __init__(self, texts: Texts, header: PageHeader) -> None:
        super().__init__()
        self.setObjectName("preflight_buttons")
        self._texts = texts
        self.run = control(QPushButton(), texts, "preflight_run", "Start",
                           key="Ctrl+Return")  # fmt: skip
        self._main: QPushButton | None = None
        # Cancel disappears when the check ends: a press that comes too late must not enable anything.
        self.enable = control(StepButton(), texts, "preflight_enable", "Enable triggers and check")
        self.cancel = control(
            StepButton(is_safe=True), texts, "preflight_cancel", "Cancel", key="Esc", picture=Icon.CROSS
        )
        self.print = control(QPushButton(), texts, "preflight_print", "Export report…", key="Ctrl+P", picture=Icon.SAVE)
        self.history = control(QPushButton(), texts, "preflight_history", "Past checks",
                               key="Ctrl+H", picture=Icon.HISTORY)  # fmt: skip
        header.add(self.history)
        self.verify = header.add_rare("preflight_verify", marked("Verify a file…"), lambda: None)
        row = FlowRow(self)
        row.setContentsMargins(Space.M, Space.XS, Space.M, Space.S)
        row.add_right(self.cancel, self.run, self.enable, self.print)

    def press_main(self) -> None:
        """Ctrl+Return is the main button, whichever that is."""
        if self._main is not None and self._main.isVisible():
            self._main.click()

    def show_work(self, work: PreflightController) -> None:
        is_checking = work.standing is Standing.CHECKING
        self.run.setEnabled(work.can_check)
        needs_lock = work.needs_lock
        self.enable.setEnabled(work.can_enable or needs_lock)
        words = marked("Lock, enable and check again") if needs_lock else marked("Enable triggers and check")
        rename(self.enable, self._texts, words)
        self.print.setEnabled(work.record is not None)
        is_enabling = needs_lock or (work.can_enable and not work.are_triggers_known)
        has_passed = work.standing in (Standing.GO, Standing.READY)
        self._emphasise(self.print if has_passed else self.enable if is_enabling else self.run)
        words = marked("Start") if self._main is self.run else marked("Check only")
        words = words if work.filed is None else marked("Check again")
        rename(self.run, self._texts, words)
        self.enable.setVisible(not is_checking)
        self.cancel.setVisible(is_checking)

    def _emphasise(self, main: QPushButton) -> None:
        """In a new connection a check without enabling the triggers can only end with NO-GO."""
        if main is self._main:
            return
        self._main = main
        for button in (self.run, self.enable, self.print):
            set_role(button, "primary" if button is main else "")
