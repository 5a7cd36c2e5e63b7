"""Button row of the Pre-flight page: the main button at the right."""

from PySide6.QtWidgets import QPushButton, QWidget

from ui.core.texts import Texts
from ui.pages.preflight.controller import PreflightController, Standing
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.layouts import FlowRow
from ui.widgets.step_button import StepButton


class PreflightButtons(QWidget):
    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("preflight_buttons")
        self._texts = texts
        self.run = control(QPushButton(), texts, "preflight_run", "Run the check", tip="Run all checks: questions only",
                           key="Ctrl+Return")  # fmt: skip
        self._main: QPushButton | None = None
        # Cancel goes when the check ends: a press that comes too late must not enable anything.
        self.enable = control(StepButton(), texts, "preflight_enable", "Enable triggers and check",
                              tip="Enable both automatic triggers on the module, and check again")  # fmt: skip
        self.cancel = control(StepButton(is_safe=True), texts, "preflight_cancel", "Cancel",
                              tip="Break the check off; it is void then", key="Esc", picture=Icon.CROSS)  # fmt: skip
        self.print = control(QPushButton(), texts, "preflight_print", "Export report…",
                             tip="Print the check as PDF, HTML and JSON", key="Ctrl+P", picture=Icon.SAVE)  # fmt: skip
        self.history = control(QPushButton(), texts, "preflight_history", "Past checks",
                               tip="All checks that are kept, and what they measured", key="Ctrl+H",
                               picture=Icon.HISTORY)  # fmt: skip
        self.verify = control(QPushButton(), texts, "preflight_verify", "Verify a file…",
                              tip="Was a record or a report altered? Or drop the file here",
                              picture=Icon.DIAGNOSIS)  # fmt: skip
        row = FlowRow(self)
        row.setContentsMargins(Space.M, Space.XS, Space.M, Space.S)
        row.add(self.history, self.verify, self.print)
        row.add_right(self.cancel, self.enable, self.run)

    def show_work(self, work: PreflightController) -> None:
        is_checking = work.standing is Standing.CHECKING
        self.run.setEnabled(work.can_check)
        words = "Run the check" if work.filed is None else "Check again"
        self._texts.bind(self.run.setText, words)
        self._texts.bind(self.run.setAccessibleName, words)
        self.enable.setEnabled(work.can_enable)
        self._emphasise(self.enable if work.can_enable and not work.are_triggers_known else self.run)
        self.enable.setVisible(not is_checking)
        self.cancel.setVisible(is_checking)
        self.print.setEnabled(work.record is not None)

    def _emphasise(self, main: QPushButton) -> None:
        """The one that leads on: after a start of the module a plain check can only say NO-GO."""
        if main is self._main:
            return
        self._main = main
        self.run.setIcon(icon(Icon.CHECKLIST, is_on_primary=main is self.run))
        for button in (self.run, self.enable):
            button.setProperty("role", "primary" if button is main else "")
            button.style().unpolish(button)
            button.style().polish(button)
