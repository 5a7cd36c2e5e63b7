"""Bar at the foot of the window while a capture is played back: position, speed, stop."""

from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QComboBox, QLabel, QProgressBar, QPushButton, QSizePolicy

from app.captures.player import UrlRefused, parse_url, playing, url_of
from app.engine.target import Target
from app.text.durations import stopwatch
from app.text.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from protocol.translatable import marked
from ui.core.connector import Connector
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.banner import Banner
from ui.widgets.controls import control
from ui.widgets.labels import ElidedLabel
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_TITLE, _RECORDING_TITLE = marked("DPS-S Configurator"), marked("RECORDING – DPS-S Configurator")
SPEEDS = (0.25, 1.0, 2.0, 5.0, 20.0)


def recording_target(path: Path, speed: float = 1.0) -> Target:
    """The target that plays this file."""
    return Target(url_of(path.absolute().as_posix(), speed=speed), DEFAULT_BAUD_RATE, title=path.name)


def recording_name(device: str) -> str:
    """The name of the file that a `capture://` port plays."""
    try:
        return Path(parse_url(device).path).name
    except UrlRefused:
        return device


def recording_word(connector: Connector) -> str:
    """The position in the recording, for the top bar; "" while none is played."""
    player = playing(connector.target.device) if connector.is_playback and connector.target is not None else None
    if player is None:
        return ""
    now = connector.clock()
    if player.is_over(now):
        return tr("ended")
    position, length = stopwatch(player.position_s(now)), stopwatch(player.duration_s)
    return tr("{position} of {length}", position=position, length=length)


class RecordingBar(Banner):
    """Hidden while a real or a simulated module is connected."""

    changed = Signal()
    """A capture is played, or none any more."""
    is_foot = True

    def __init__(self, connector: Connector, texts: Texts) -> None:
        super().__init__("recording_bar", "recording_icon")
        self.show_meaning(Meaning.INFORMATION, Icon.PLAY)
        self._connector, self._texts = connector, texts
        self._message = ""
        self.label = named(ElidedLabel(Qt.TextElideMode.ElideMiddle), "recording_label", "strong")
        self._note = control(QLabel(), texts, "recording_note", "Nothing is sent.")
        self.place = control(QProgressBar(), texts, "recording_place", says="Position")
        self.place.setTextVisible(False)
        self.place.setFixedWidth(88)
        self.place.setRange(0, 1000)
        self.speed = self._make_speed()
        self.again = control(
            QPushButton(), texts, "recording_again", says="Play from the start", picture=Icon.AGAIN, slot=self._play
        )
        self.stop = control(QPushButton(), texts, "recording_stop", "Stop playing", picture=Icon.CROSS,
                            slot=connector.disconnect_port)  # fmt: skip
        self.row.setContentsMargins(Space.M, 0, Space.M, 0)
        self.row.addWidget(self.label, 1)
        for widget in (self._note, self.place, self.speed, self.again, self.stop):
            self.row.addWidget(widget)
        VisibilityTimer(self, self.refresh)

    def refresh(self) -> None:
        connector, target = self._connector, self._connector.target
        is_played = connector.is_playback
        if is_played == self.isHidden():
            self.setVisible(is_played)
            self._show_target()
            self.changed.emit()
        if not is_played or target is None:
            return
        player, now = playing(target.device), connector.clock()
        name = recording_name(target.device)
        text = tr("RECORDING: {name}", name=name)
        if player is not None:
            self.place.setValue(round(1000 * player.position_s(now) / max(0.001, player.duration_s)))
            if player.is_over(now):
                text = tr("RECORDING: {name}", name=name) + " · " + tr("ended")
        shown = self._message or text
        if shown != self.label.text():
            self.label.setText(shown)
            self.label.set_tip(self._message or parse_url(target.device).path)
            self.setAccessibleName(text)

    def show_message(self, message: str) -> None:
        """Shows a passing message in place of the name; "" shows the name again."""
        if message != self._message:
            self._message = message
            self.refresh()

    def make_room(self, *, is_wanted: bool) -> None:
        """Shows only the controls, which stay where they are, beside a notice."""
        for widget in (self.label, self._note):
            widget.setHidden(is_wanted)
        policy = QSizePolicy.Policy
        self.setSizePolicy(policy.Fixed if is_wanted else policy.Preferred, policy.Preferred)

    def choose_speed(self, target: Target) -> None:
        """Shows the speed at which `target` is played."""
        with QSignalBlocker(self.speed):
            self.speed.setCurrentIndex(self.speed.findData(parse_url(target.device).speed))

    def _make_speed(self) -> QComboBox:
        box = control(QComboBox(), self._texts, "recording_speed", says="Speed")
        for speed in SPEEDS:
            box.addItem(f"×{speed:g}", speed)
        box.setCurrentIndex(SPEEDS.index(1.0))
        WheelGuard(self).guard(box)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        box.currentIndexChanged.connect(self._play)
        return box

    def _play(self) -> None:
        """Plays from the start at the chosen speed."""
        target = self._connector.target
        if not self._connector.is_playback or target is None:
            return
        speed = self.speed.currentData()
        url = parse_url(target.device)
        self._connector.connect_to(recording_target(Path(url.path), url.speed if speed is None else speed))

    def _show_target(self) -> None:
        self._texts.bind(self.window().setWindowTitle, _TITLE if self.isHidden() else _RECORDING_TITLE)
        if self._connector.target is not None and self._connector.is_playback:
            self.choose_speed(self._connector.target)
