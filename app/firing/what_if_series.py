"""Runs the what-if analysis incrementally on live data, in a background thread on recordings."""

import math
import threading
from typing import Final, Protocol

import numpy as np

from app.firing.judge import TriggerLimits
from app.firing.would_fire import WhatIfAnalysis, WhatIfFinding
from app.recordings.excerpt import Excerpt
from app.samples.ring_buffers import Readable

MAX_AT_ONCE: Final = 100_000
"""Reports judged at once, in about 5 ms."""


class Measured(Protocol):
    """A live or a recorded session."""

    @property
    def tilt(self) -> Readable: ...
    def excerpt(self, start_s: float, end_s: float) -> Excerpt: ...


class IncrementalAnalysis:
    """Judges new reports as they come. Starts over when the judged ones are no longer available."""

    def __init__(self, measured: Measured, limits: TriggerLimits, *, counts_locked: bool = True) -> None:
        self._measured = measured
        self._analysis = WhatIfAnalysis(limits, counts_locked=counts_locked)
        self._taken_at_last = 0
        """Number of judged reports with the last time; more of that time may follow."""
        self._finding: WhatIfFinding | None = None

    @property
    def finding(self) -> WhatIfFinding:
        if self._finding is None:
            self._finding = self._analysis.finding
        return self._finding

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        times = self._measured.tilt
        last_s = self._analysis.last_s
        if times.last is None or last_s is None or times.last.time_s <= last_s:
            return 1.0 if times.last is None or last_s is not None else 0.0
        first_s = self.finding.first_s or 0.0
        return (last_s - first_s) / (times.last.time_s - first_s)

    def catch_up(self) -> bool:
        """Judge at most `MAX_AT_ONCE` new reports; returns whether none are left."""
        last_s = self._analysis.last_s
        times = self._measured.tilt.window(-math.inf if last_s is None else last_s, math.inf).time_s
        if last_s is not None and not (len(times) and times[0] == last_s):
            self._reset()
            return False
        if len(times) <= self._taken_at_last:
            return True
        stop = min(len(times) - 1, self._taken_at_last + MAX_AT_ONCE)
        excerpt = self._measured.excerpt(-math.inf if last_s is None else last_s, float(times[stop]))
        self._analysis.feed(excerpt, start=self._taken_at_last)
        newest = excerpt.time_s
        self._taken_at_last = len(newest) - int(np.searchsorted(newest, newest[-1], "left"))
        self._finding = None
        return stop == len(times) - 1

    def _reset(self) -> None:
        analysis = self._analysis
        self._analysis = WhatIfAnalysis(analysis.limits, counts_locked=analysis.counts_locked)
        self._taken_at_last = 0
        self._finding = None


class BackgroundAnalysis:
    """Judges a recording in a background thread."""

    def __init__(self, measured: Measured, limits: TriggerLimits, *, counts_locked: bool = True) -> None:
        self._incremental = IncrementalAnalysis(measured, limits, counts_locked=counts_locked)
        self._is_cancelled = threading.Event()
        self._finding: WhatIfFinding | None = None
        self._progress = 0.0
        self.error: Exception | None = None
        self._thread = threading.Thread(target=self._judge, name="dps-s judge", daemon=True)
        self._thread.start()

    @property
    def finding(self) -> WhatIfFinding | None:
        """None until everything is judged."""
        return self._finding

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return self._progress

    def wait(self, deadline_s: float) -> bool:
        """Whether it has ended within the time."""
        self._thread.join(deadline_s)
        return not self._thread.is_alive()

    def cancel(self, deadline_s: float = 1.0) -> bool:
        """Stop; returns whether it ended in time. The recording is not read any more then."""
        self._is_cancelled.set()
        return self.wait(deadline_s)

    def _judge(self) -> None:
        try:
            while not self._is_cancelled.is_set():
                is_done = self._incremental.catch_up()
                self._progress = self._incremental.progress
                if is_done:
                    self._finding = self._incremental.finding
                    return
        except Exception as error:  # noqa: BLE001  shown in the window
            self.error = error


class WhatIfJudgement:
    """The analysis of one session for the window: `ask` when the limits change, `step` from a timer."""

    def __init__(self) -> None:
        self._measured: Measured | None = None
        self._is_recorded = False
        self._asked: tuple[TriggerLimits, bool] | None = None
        self._incremental: IncrementalAnalysis | None = None
        self._background: BackgroundAnalysis | None = None
        self._is_caught_up = False

    @property
    def finding(self) -> WhatIfFinding | None:
        """None until everything is judged."""
        if self._background is not None:
            return self._background.finding
        return self._incremental.finding if self._incremental is not None and self._is_caught_up else None

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        if self._background is not None:
            return self._background.progress
        return 0.0 if self._incremental is None else self._incremental.progress

    @property
    def error(self) -> Exception | None:
        """Why the recording cannot be judged."""
        return None if self._background is None else self._background.error

    def bind(self, measured: Measured, *, is_recorded: bool) -> None:
        """Judge this session from now on."""
        self.release()
        self._measured, self._is_recorded = measured, is_recorded

    def ask(self, limits: TriggerLimits, *, counts_locked: bool) -> None:
        """Set the limits; the same ones again change nothing."""
        if self._measured is None or self._asked == (limits, counts_locked):
            return
        self._stop()
        self._asked = (limits, counts_locked)
        if self._is_recorded:
            self._background = BackgroundAnalysis(self._measured, limits, counts_locked=counts_locked)
        else:
            self._incremental = IncrementalAnalysis(self._measured, limits, counts_locked=counts_locked)

    def step(self) -> None:
        """Do a few milliseconds of work."""
        if self._incremental is not None:
            is_done = self._incremental.catch_up()
            self._is_caught_up = is_done or self._is_caught_up

    def release(self) -> None:
        """Stop judging and reading the session."""
        self._stop()
        self._measured = None

    def _stop(self) -> None:
        if self._background is not None:
            self._background.cancel()
        self._asked = self._incremental = self._background = None
        self._is_caught_up = False
