"""Cost of recording, and of opening and drawing ten million reports, without a window."""

import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np

from app.recordings.recorder import FLUSH_EVERY_S
from app.recordings.recording import Recording
from tests.benchmarks.figures import Figure, quantile
from tests.support.records.recordings_made import HEADING, LINE_HZ, opened, recorder_in, stream, written_at_once

ROWS: Final = 10_000_000
OPENING_AIM_S: Final = 2.0
CPU_AIM: Final = 0.03
"""Of one core, at line rate."""
PAN_AIM_MS: Final = 4.0
"""A quarter of a frame at 60 Hz, for all lanes; the rest is for drawing."""
WINDOWS: Final = 200
_BUCKETS: Final = 1000


def figures(rows: int = ROWS, seconds: float = 60.0, windows: int = WINDOWS) -> list[Figure]:
    with tempfile.TemporaryDirectory() as name:
        found = _cost_of_recording(Path(name) / "recorded", seconds)
        folder = written_at_once(Path(name) / "written", rows)
        began = time.perf_counter()
        recording = opened(folder)
        opening_s = time.perf_counter() - began
        waits_ms = _pan(recording, windows)
        recording.close()
    slowest_ms = quantile(waits_ms, 0.99)
    return [
        *found,
        Figure(
            f"opening a recording of {rows:,} reports",
            f"{opening_s:.2f} s",
            f"<= {OPENING_AIM_S:g} s",
            opening_s <= OPENING_AIM_S,
        ),
        Figure(
            f"points of a random window of it, {windows} of 0.1 s to all, two lanes",
            f"{quantile(waits_ms, 0.5):.2f} ms median, {slowest_ms:.2f} ms p99",
            f"p99 <= {PAN_AIM_MS:g} ms",
            slowest_ms <= PAN_AIM_MS,
        ),
    ]


def _cost_of_recording(folder: Path, seconds: float) -> list[Figure]:
    """CPU time of receiving, encoding and writing as a share of real time; and size on disk."""
    batches = list(stream(1000.0, seconds))
    at_once = round(len(batches) / seconds * FLUSH_EVERY_S)
    with recorder_in(folder) as bench:
        bench.recorder.begin(HEADING)
        bench.feed(batches[0])
        began = time.process_time()
        for first in range(1, len(batches), at_once):
            bench.feed(*batches[first : first + at_once])
        share = (time.process_time() - began) / seconds
        entry = bench.recorder.entry
        size = 0.0 if entry is None else entry.size_bytes
    return [
        Figure(
            f"CPU of recording at {LINE_HZ:,} Hz ({seconds:g} s)",
            f"{share:.2%} of one core",
            f"<= {CPU_AIM:.0%}",
            share <= CPU_AIM,
        ),
        Figure(f"disk of recording at {LINE_HZ:,} Hz", f"{size / seconds * 3600 / 1e6:.0f} MB an hour"),
    ]


def _pan(recording: Recording, windows: int) -> list[float]:
    """Milliseconds for the points of both lanes, per time window."""
    random = np.random.default_rng(1)
    whole_s = recording.end_s - recording.start_s
    waits = []
    for _ in range(windows):
        length_s = min(whole_s, float(np.exp(random.uniform(np.log(0.1), np.log(whole_s)))))
        start_s = recording.start_s + random.uniform(0.0, whole_s - length_s)
        began = time.perf_counter()
        for series in (recording.tilt, recording.acceleration):
            series.decimated(start_s, start_s + length_s, _BUCKETS)
        waits.append((time.perf_counter() - began) * 1000)
    return waits
