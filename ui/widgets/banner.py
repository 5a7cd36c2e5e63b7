"""A strip across the window or a page, coloured by its meaning."""

from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QWidget

from ui.style.icons import Icon
from ui.style.painted_widget import paint_banner
from ui.style.theme import Meaning, Space
from ui.widgets.labels import IconLabel


class Banner(QWidget):
    """An icon, followed in `row` by the widgets of the subclass. Hidden at first."""

    is_foot = False
    """At the foot of the window."""

    def __init__(self, name: str, icon_name: str, *, icon_px: int = 16) -> None:
        super().__init__()
        self.setObjectName(name)
        self.meaning = Meaning.INFORMATION
        self.picture = IconLabel(icon_name, icon_px, keeps_place=True)
        self.row = QHBoxLayout(self)
        self.row.setContentsMargins(Space.M, Space.XS, Space.S, Space.XS)
        self.row.setSpacing(Space.S)
        self.row.addWidget(self.picture)
        self.hide()

    def show_meaning(self, meaning: Meaning, picture: Icon) -> None:
        self.meaning = meaning
        self.picture.show_icon(picture, meaning)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        paint_banner(self, self.meaning, is_foot=self.is_foot)
