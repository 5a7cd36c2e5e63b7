"""Makes recordings of given status reports."""

from collections.abc import Iterable
from pathlib import Path

from app.engine.device import StatusSample
from tests.support.records.recordings_made import HEADING, asked, batch, recorder_in

STARTS_S = 1000.0


def recorded_reports(folder: Path, rows: Iterable[tuple[float, float, float]]) -> Path:
    """Record rows of time, tilt and acceleration; return the folder of the recording."""
    samples = [StatusSample(STARTS_S + at_s, int(tilt), force, False, True) for at_s, tilt, force in rows]
    with recorder_in(folder) as bench:
        bench.recorder.begin(*HEADING)
        bench.recorder.on_batch(batch(STARTS_S, events=(asked(STARTS_S),)))
        bench.feed(batch(samples[-1].at, *samples))
        bench.recorder.end()
        bench.settle()
        return bench.path
