"""Button row of the Pre-flight page: the main button at the right."""

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QPushButton, QWidget

from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.preflight.controller import PreflightController, Standing
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.flow_row import FlowRow
from ui.widgets.step_button import StepButton


class PreflightButtons(QWidget):
    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("preflight_buttons")
        self._texts = texts
        self.run = self._button("preflight_run", None, marked("Run the check"),
                                marked("Run all checks: questions only (Ctrl+Return)"))  # fmt: skip
        self._main: QPushButton | None = None
        # Cancel goes when the check ends: a press that comes too late must not enable anything.
        self.enable = StepButton()
        self._prepare(self.enable, "preflight_enable", None, marked("Enable triggers and check"),
                      marked("Enable both automatic triggers on the module, and check again"))  # fmt: skip
        self.cancel = StepButton(is_safe=True)
        self._prepare(self.cancel, "preflight_cancel", Icon.CROSS, marked("Cancel"),
                      marked("Break the check off; it is void then (Esc)"))  # fmt: skip
        self.print = self._button("preflight_print", Icon.SAVE, marked("Print report …"),
                                  marked("Print the check as PDF, HTML and JSON (Ctrl+P)"))  # fmt: skip
        self.history = self._button("preflight_history", Icon.HISTORY, marked("Past checks"),
                                    marked("All checks that are kept, and what they measured (Ctrl+H)"))  # fmt: skip
        self.verify = self._button("preflight_verify", Icon.DIAGNOSIS, marked("Verify a file …"),
                                   marked("Was a record or a report altered? Or drop the file here"))  # fmt: skip
        row = FlowRow(self)
        row.setContentsMargins(Space.M, Space.XS, Space.M, Space.S)
        row.add(self.history, self.verify, self.print)
        row.add_right(self.cancel, self.enable, self.run)

    def show_work(self, work: PreflightController) -> None:
        is_checking = work.standing is Standing.CHECKING
        self.run.setEnabled(work.can_check)
        self._texts.bind(self.run.setText, "Run the check" if work.filed is None else "Check again")
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

    def _button(self, name: str, picture: Icon | None, english: str, tip: str) -> QPushButton:
        button = QPushButton()
        self._prepare(button, name, picture, english, tip)
        return button

    def _prepare(self, button: QPushButton, name: str, picture: Icon | None, english: str, tip: str) -> None:
        button.setObjectName(name)
        if picture is not None:
            button.setIcon(icon(picture))
            button.setIconSize(QSize(16, 16))
        self._texts.bind(button.setText, english)
        self._texts.bind(button.setAccessibleName, english)
        self._texts.bind(button.setToolTip, tip)
