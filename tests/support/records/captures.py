"""Explains captures and reads the traffic of sessions, for tests."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from app.captures.entries import CaptureEntry
from app.captures.explained import Explained, Explainer
from app.recordings.library import entry_of
from app.recordings.recording import traffic_of


def read_session(path: Path) -> Sequence[CaptureEntry]:
    """What went over the line in a session."""
    return tuple(traffic_of(entry_of(path)))


def explained(entries: Iterable[CaptureEntry]) -> Iterator[Explained]:
    explainer = Explainer()
    for entry in entries:
        yield from explainer.feed(entry)
    yield from explainer.end()
