"""Form for what was done to a module: repacked, ejector, cell, firmware."""

from collections.abc import Callable
from datetime import date

from PySide6.QtCore import QDate, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDateEdit,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QWidget,
)

from app.modules.service import TITLES, ServiceKind, serviced
from app.store.kinds import Serviced
from app.text.i18n import tr
from ui.files.file_dialogs import open_dialog
from ui.widgets.controls import control, named

MAX_LENGTH = 200
REPACKED_FOR_MONTHS = 6
"""Proposed; a person decides."""


class ServiceForm(QDialog):
    """`then` gets the service once it was confirmed."""

    def __init__(self, parent: QWidget, module: str, who: str, then: Callable[[Serviced], object]) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Service of {module}", module=module))
        today = QDate.currentDate()
        self.kind = control(QComboBox(), "service_kind", says=tr("What was done"))
        for kind, title in TITLES.items():
            self.kind.addItem(tr(title), kind)
        self.on = control(QDateEdit(today), "service_on", says=tr("Done on"))
        self.is_due = named(QCheckBox(tr("Due again on")), "service_is_due")
        proposed = QDateEdit(today.addMonths(REPACKED_FOR_MONTHS))
        self.due = control(proposed, "service_due", says=tr("Due again on"))
        self.who = control(QLineEdit(who), "service_who", says=tr("Done by"))
        self.note = control(QLineEdit(), "service_note", says=tr("Note"))
        for edit in (self.who, self.note):
            edit.setMaxLength(MAX_LENGTH)
        for day in (self.on, self.due):
            day.setCalendarPopup(True)
            day.setDisplayFormat("yyyy-MM-dd")
        self.on.setMaximumDate(today)
        self.due.setMinimumDate(today.addDays(1))
        self.is_due.setChecked(True)
        self.is_due.toggled.connect(self.due.setEnabled)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.addRow(tr("What was done"), self.kind)
        form.addRow(tr("Done on"), self.on)
        form.addRow(self.is_due, self.due)
        form.addRow(tr("Done by"), self.who)
        form.addRow(tr("Note"), self.note)
        form.addRow(buttons)
        open_dialog(self, "service_form", lambda: then(self.service))

    @property
    def service(self) -> Serviced:
        due = _date_of(self.due) if self.is_due.isChecked() else None
        kind = ServiceKind(self.kind.currentData())
        return serviced(kind, on=_date_of(self.on), due=due, who=self.who.text(), note=self.note.text())


def _date_of(day: QDateEdit) -> date:
    return date.fromisoformat(day.date().toString(Qt.DateFormat.ISODate))
