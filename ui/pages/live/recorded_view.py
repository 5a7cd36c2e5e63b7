"""Shows a recording on the Live page in place of the module."""

from collections.abc import Sequence

from PySide6.QtWidgets import QStackedWidget

from app.limits.out_of_limits import LimitsInUse
from app.recordings.recording import Recording
from ui.core.texts import Texts
from ui.files.save_bar import Origin
from ui.pages.live.cursor_values import show_moment
from ui.pages.live.data import mark_of
from ui.pages.live.panel import LivePanel
from ui.pages.live.recorded_banner import RecordedBanner
from ui.plots.lanes import Lane, Span
from ui.plots.time_plot import TimePlot


class RecordedView:
    """`plots` is the stack with the module's plots at the bottom; `panel` shows the numbers."""

    def __init__(self, texts: Texts, plots: QStackedWidget, panel: LivePanel, in_use: LimitsInUse) -> None:
        self._texts, self._plots, self._panel, self._in_use = texts, plots, panel, in_use
        self.banner = RecordedBanner(texts)
        self.recording: Recording | None = None
        self.plot: TimePlot | None = None
        self._read_s: float | None = None
        """The time that the numbers show."""

    def show(self, recording: Recording, lanes: Sequence[Lane]) -> None:
        """Shows all of `recording`, with the cursor at its last report."""
        self.close()
        self.recording = recording
        bounds = Span(recording.start_s, recording.end_s)
        plot = self.plot = TimePlot(lanes, self._texts, wall_offset_s=recording.wall_offset_s, bounds=bounds)
        plot.add_marks([mark_of(marker) for marker in recording.markers])
        last = recording.tilt.last
        if last is not None:
            plot.point_at(last.time_s)
        self._plots.addWidget(plot)
        self._plots.setCurrentWidget(plot)
        self.banner.show_recording(recording)
        self._panel.be_recorded(is_recorded=True)

    def close(self) -> None:
        """Closes the recording, after the widgets that read from it."""
        plot, recording = self.plot, self.recording
        self.plot = self.recording = self._read_s = None
        if plot is not None:
            self._plots.removeWidget(plot)
            plot.deleteLater()
        self.banner.show_recording(None)
        self._panel.be_recorded(is_recorded=False)
        if recording is not None:
            recording.close()

    def refresh(self) -> None:
        """Shows the numbers at the cursor, if it moved."""
        if self.recording is None or self.plot is None:
            return
        at_s = self.plot.cursor_s
        if at_s is None or at_s != self._read_s:
            self._read_s = at_s
            show_moment(self._panel, self.recording, at_s, self._in_use)

    def retranslate(self) -> None:
        """The next `refresh` writes the numbers again."""
        self._read_s = None


def origin_of(recording: Recording) -> Origin:
    """The origin of files saved from `recording`."""
    entry = recording.entry
    return Origin(entry.port, entry.baud_rate, recording.wall_offset_s, entry.started_at, entry.module)
