"""Guided tour through the real window on a simulated module."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, QTimer, Signal
from PySide6.QtWidgets import QWidget

from app.text.i18n import tr
from ui.help.tour_card import Spotlight, TourCard
from ui.help.tour_setup import TourSetup
from ui.help.tour_steps import STEPS, Scene, TourStep
from ui.services.context import Services
from ui.services.tour_port import is_tour

if TYPE_CHECKING:
    from ui.shell.main_window import MainWindow

LOOK_EVERY_MS: Final = 100


class Tour(QObject):
    """`begin` once, `end` whenever; `ended` is told once. Belongs to the window that it leads through."""

    ended = Signal()

    def __init__(self, window: "MainWindow", services: Services) -> None:
        super().__init__(window)
        self.desk = TourSetup(window, services.connector)
        self.scene: Scene | None = None
        self._window, self._services = window, services
        self._number = 0
        self._is_running = False
        self._has_left_recording = False
        self._was_ours = False
        self._page_before, self._name_before, self._had_sheet = "", "", False
        self._light = Spotlight(window)
        self.card = TourCard(services.texts, window)
        self._light.hide()
        self.card.hide()
        services.appearance.dress(self.card)  # it is measured before it is shown
        self.card.main_wanted.connect(self._act)
        self.card.next_wanted.connect(self.go_on)
        self.card.back_wanted.connect(self.go_back)
        self.card.end_wanted.connect(self.end)
        self._timer = QTimer(self)
        self._timer.setInterval(LOOK_EVERY_MS)
        self._timer.timeout.connect(self.poll)

    @property
    def is_running(self) -> bool:
        return self._is_running

    @property
    def number(self) -> int:
        """Of the step, from 0."""
        return self._number

    @property
    def step(self) -> TourStep:
        return STEPS[self._number]

    def begin(self) -> None:
        """At the first step. Nothing is connected before the person says so there."""
        if self._is_running:
            self.card.take_focus()
            return
        window = self._window
        self._page_before, self._name_before = window.navigation.chosen, self._services.naming.name
        self._had_sheet = window.panel.isVisible()
        window.panel.hide()
        self._is_running = True
        self._window.installEventFilter(self)
        self._timer.start()
        self._go(0)

    def go_on(self) -> None:
        """To the next step; at the last one it ends. A step that has to be done first stays."""
        if not self.step.may_skip and (self.scene is None or not self.scene.is_done):
            return
        if self._number + 1 == len(STEPS):
            self.end()
        else:
            self._go(self._number + 1)

    def go_back(self) -> None:
        if self._number > 0:
            self._go(self._number - 1)

    def end(self, why: str = "") -> None:
        """Take everything away again and put back what was there before."""
        if not self._is_running:
            return
        self._is_running = False
        self._timer.stop()
        self._window.removeEventFilter(self)
        for widget in (self._light, self.card):
            widget.hide()
            widget.deleteLater()
        self._put_back()
        self._window.say(why or self._farewell())
        self.ended.emit()

    def _farewell(self) -> str:
        if self._has_left_recording:
            return tr("The tour has ended. The recording that was open was closed; it stays in the list of recordings.")
        return tr("The tour has ended; everything is as it was. It stays in the Help menu.")

    def poll(self) -> None:
        """How things stand now."""
        if not self._is_running:
            return
        is_ours = self.desk.is_ours
        if self._was_ours and not is_ours:
            self.end(tr("The tour has ended, because its simulated module was disconnected."))
            return
        self._was_ours = is_ours
        self.scene = self._here() or self.step.look(self.desk)
        self._show(self.scene)

    # Going

    def _go(self, number: int) -> None:
        if self.scene is not None and self.desk.is_ours:
            self.step.leave(self.desk)
        self._number, self.scene = number, None
        self._has_left_recording |= self.desk.leave_recording()
        self._window.go_to(self.step.page)
        self.step.enter(self.desk)
        self.poll()
        self.card.take_focus()

    def _act(self) -> None:
        if self.scene is not None and self.scene.do is not None:
            self.scene.do()
            self.poll()

    def _here(self) -> Scene | None:
        """What to say where the person went to another page meanwhile."""
        if self._window.navigation.chosen == self.step.page:
            return None
        back: Callable[[], None] = lambda: self._window.go_to(self.step.page)  # noqa: E731  read as one value
        return Scene(
            tr("This step of the tour is on another page."), (self._window.navigation,), tr("Back to the tour"), back
        )

    def _put_back(self) -> None:
        window, desk = self._window, self.desk
        if desk.is_ours:
            desk.connector.disconnect_port()
        if is_tour(desk.connector.target):
            desk.connector.forget_module()
        desk.forget()
        self._services.naming.choose(self._name_before)
        window.go_to(self._page_before)
        if self._had_sheet and not desk.connector.is_wanted and not window.panel.isVisible():
            window.toggle_panel()

    # What is shown

    def _show(self, scene: Scene) -> None:
        card, window = self.card, self._window
        count = tr("Tour, step {number} of {count}", number=self._number + 1, count=len(STEPS))
        is_last = self._number + 1 == len(STEPS)
        self._services.texts.bind(card.next.setText, "Finish" if is_last else "Next")
        card.next.setEnabled(self.step.may_skip or scene.is_done)
        card.back.setEnabled(self._number > 0)
        card.show_words(count, tr(self.step.title), scene.text, main=scene.act)
        top, below = _within(window, window.top_bar), _within(window, window.centre)
        area = top.united(below)
        spots = [rect for widget in scene.spots if (rect := self._seen(widget)).isValid()]
        self._light.setGeometry(area)
        self._light.show_spots(
            [spot.translated(-area.topLeft()) for spot in spots], bright=top.translated(-area.topLeft())
        )
        card.place(below.intersected(area.adjusted(0, top.height(), 0, 0)), spots)
        for widget in (self._light, card):
            widget.show()
            widget.raise_()

    def _seen(self, widget: QWidget) -> QRect:
        """Where it is to be seen, in the window; nothing where it is not."""
        if not widget.isVisible():
            return QRect()
        seen, around = _within(self._window, widget), widget.parentWidget()
        while around is not None and around is not self._window:
            seen = seen.intersected(_within(self._window, around))
            around = around.parentWidget()
        return seen

    # Qt

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LanguageChange):
            QTimer.singleShot(0, self, self.poll)
        return False


def _within(window: QWidget, widget: QWidget) -> QRect:
    return QRect(widget.mapTo(window, QPoint()), widget.size())
