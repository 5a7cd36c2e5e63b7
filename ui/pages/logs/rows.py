"""Recordings and flight logs: read in the background, put on a side, shown as rows with their verdicts.

Nothing here sends anything to a module.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from enum import IntEnum
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QIcon

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightGroup, FlightOutcome, FlightSummary, ThresholdProposal, propose
from app.flights.read_log import distinct_names, find_logs, summarise_log
from app.flights.table import CsvColumns
from app.recordings.library import RecordingEntry, RecordingLibrary, entry_text
from app.text.i18n import tr
from app.text.messages import UserMessage, capitalised, clean, error_text, in_brackets, join_names, labelled, stopwatch
from protocol.messages import Source
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, Running
from ui.forms.tables import TableColumn
from ui.session.page_job import PageJob
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning

_UNSORTED: Final = FlightGroup.UNSORTED


class Stamp(NamedTuple):
    """Whether a file, or the archive that it is in, is still the one that was read."""

    changed_at: datetime
    size_bytes: int


class LogFile(NamedTuple):
    """A file that was opened, or is to be: then it has neither a flight nor a reason why not."""

    name: str  # Its path
    group: FlightGroup = _UNSORTED
    columns: CsvColumns | None = None  # With which a table was read; None: recognised by name
    flight: FlightSummary | None = None
    why_not: UserMessage | None = None  # It could not be read
    head: tuple[str, ...] = ()  # Column names of a table that could not be read
    stamp: "Stamp | None" = None  # Of the file, when it was read

    @property
    def is_waiting(self) -> bool:
        return self.flight is None and self.why_not is None


class LogsWork(QObject):
    """Reads files and folders as a `job` of the page, and keeps what was read."""

    changed = Signal()
    ended = Signal(object)  # The names of the logs that were read, also of those that were there before

    def __init__(self, library: RecordingLibrary, job: PageJob) -> None:
        super().__init__(job)
        self.library, self._job = library, job
        self.entries: tuple[RecordingEntry, ...] = ()
        self.listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)
        self.logs: dict[str, LogFile] = {}
        self.limits = TriggerLimits()
        self.proposal: ThresholdProposal | None = None
        self.proposing: BackgroundTask[ThresholdProposal] = BackgroundTask("dps-s thresholds", self)
        # What was read since, from the threads that read.
        self._done: deque[LogFile] = deque()
        job.changed.connect(self._take)

    def side(self, group: FlightGroup) -> list[FlightSummary]:
        """Without what could not be read."""
        return [log.flight for log in self.logs.values() if log.group is group and log.flight is not None]

    def unread(self) -> list[LogFile]:
        return [log for log in self.logs.values() if log.why_not is not None]

    def rows(self) -> list["LogRow"]:
        entries = {str(entry.path): entry for entry in self.entries}
        read = (log.name for log in self.logs.values() if not log.is_waiting)
        names = list(dict.fromkeys((*entries, *read)))
        rows = []
        for name, label in zip(names, distinct_names([Path(name) for name in names]), strict=True):
            log, entry = self.logs.get(name, LogFile(name)), entries.get(name)
            outcome = None if log.flight is None else log.flight.outcome(self.limits)
            of_module = "" if entry is None else entry.module or entry.port.removeprefix("/dev/")
            rows.append(LogRow(name, of_module or label, log, entry, outcome))
        return rows

    def list_again(self) -> None:
        """The recordings; of a list that is being made, which may miss what changed since, nothing comes."""

        def end(entries: tuple[RecordingEntry, ...]) -> None:
            if entries != self.entries:
                self.entries = entries
                self.changed.emit()
                # What went on after it was read is judged as a whole once it has ended.
                read = {log.name: log.stamp.size_bytes for log in self.logs.values() if log.stamp is not None}
                ended = [entry for entry in entries if not entry.is_running and str(entry.path) in read]
                grown = [entry.path for entry in ended if entry.size_bytes != read[str(entry.path)]]
                if grown:
                    self.open(grown)

        self.listing.run(lambda _running: self.library.entries(), end)

    # Reading

    def open(
        self,
        paths: Iterable[Path],
        columns: CsvColumns | None = None,
        then: Callable[[list[str]], object] = lambda _names: None,
    ) -> None:
        """Reads files and folders in the background, without logs that are already there, and have not changed since;
        `then` gets the names of all."""
        wanted_paths, done = tuple(paths), self._done
        known = {Path(log.name): log.stamp for log in self.logs.values() if log.flight is not None}

        def read(running: Running) -> list[str]:
            found = list(find_logs(wanted_paths))
            stamps = {path: stamp_of(path) for path in found}  # before it is read: it may grow meanwhile
            wanted = [path for path in found if path not in known or known[path] != stamps[path]]
            for number, path in enumerate(wanted, 1):
                _, flight, why_not, head = summarise_log(path, columns)
                if running.is_cancelled():
                    break  # what was being read meanwhile is left out, too
                done.append(LogFile(str(path), _UNSORTED, columns, flight, why_not, head, stamps[path]))
                running.share = number / len(wanted)
            return [str(path) for path in found]

        def end(names: list[str]) -> None:
            self._change()
            self.ended.emit(names)
            then(names)

        def refused(error: Exception) -> str:
            self._change()
            return tr("Failed: {why}.", why=error_text(error))

        doing = tr("Reading logs…")
        self._job.begin(doing, read, end, refused, cancelled=self._change, writes=False, cause="logs")

    def _take(self) -> None:
        """Takes over the logs that were read since."""
        is_new = bool(self._done)
        while self._done:
            log = self._done.popleft()
            self.logs[log.name] = log._replace(group=self.logs.get(log.name, log).group)
        if is_new:
            self.changed.emit()

    # What a person chooses

    def choose(self, limits: TriggerLimits) -> None:
        if limits != self.limits:
            self.limits = limits
            self.changed.emit()

    def move(self, names: Sequence[str], group: FlightGroup) -> None:
        """Puts logs on a side; a recording that was not read yet is read for it."""
        for name in names:
            self.logs[name] = self.logs.get(name, LogFile(name))._replace(group=group)
        self._change()
        waiting = [Path(name) for name in names if self.logs[name].is_waiting]
        if waiting:
            self.open(waiting)

    def remove(self, names: Iterable[str]) -> None:
        """Removes logs from the list; the files stay."""
        for name in names:
            self.logs.pop(name, None)
        self._change()

    def _change(self) -> None:
        self.proposal = None
        sides = self.side(FlightGroup.MUST_NOT), self.side(FlightGroup.MUST)

        def end(proposal: ThresholdProposal) -> None:
            self.proposal = proposal
            self.changed.emit()

        if any(sides):
            self.proposing.run(lambda _running: propose(*sides), end)
        else:
            self.proposing.cancel()
        self.changed.emit()


def stamp_of(path: Path) -> Stamp | None:
    """None where there is no such file."""
    for file in (path, *path.parents):
        with suppress(OSError, ValueError):
            if file.is_file():
                status = file.stat()
                return Stamp(datetime.fromtimestamp(status.st_mtime, UTC), status.st_size)
    return None


# Rows

# How a person puts logs on a side: tip, key and picture.
SIDES: Final = {
    FlightGroup.MUST_NOT: (marked("An ordinary flight: it must not fire."), "N", Icon.NOT_TRIGGERED),
    FlightGroup.MUST: (marked("It crashed: it must fire."), "M", Icon.PARACHUTE),
    _UNSORTED: (marked("On neither side"), "U", Icon.UNKNOWN),
}


class Verdict(NamedTuple):
    """The verdict on a log with the chosen thresholds; only what is not as expected has a meaning."""

    word: str  # Marked
    icon: Icon
    meaning: Meaning | None = None


_UNREAD: Final = Verdict(marked("not read"), Icon.WARNING, Meaning.ATTENTION)
_NOT_JUDGED: Final = Verdict(marked("not judged"), Icon.UNKNOWN, Meaning.ATTENTION)  # The log holds too little
_LATE: Final = Verdict(marked("too late"), Icon.CLOCK, Meaning.DANGER)  # Only after the impact
_FIRES: Final = Verdict(marked("fires"), Icon.PARACHUTE)
_HOLDS: Final = Verdict(marked("no"), Icon.NOT_TRIGGERED)


def verdict_of(outcome: FlightOutcome, group: FlightGroup) -> Verdict:
    must = group is FlightGroup.MUST
    match outcome.answer:
        case Answer.FIRES if must:
            return _FIRES if outcome.is_before_impact else _LATE
        case Answer.FIRES:
            return _FIRES._replace(meaning=Meaning.DANGER) if group is FlightGroup.MUST_NOT else _FIRES
        case Answer.DOES_NOT_FIRE:
            return _HOLDS._replace(icon=Icon.CROSS, meaning=Meaning.DANGER) if must else _HOLDS
        case _:
            return _NOT_JUDGED


class LogRow(NamedTuple):
    """A line of the list: a log, a recording in the library, or both."""

    name: str
    label: str  # By which it can be told from the others
    log: LogFile  # Waits as long as a recording was not read
    entry: RecordingEntry | None
    outcome: FlightOutcome | None  # Of its flight with the chosen thresholds

    @property
    def why_not(self) -> UserMessage | None:
        """Why it could not be read."""
        return self.log.why_not or (None if self.entry is None else self.entry.trouble)

    @property
    def verdict(self) -> Verdict | None:
        """Nothing is said of a recording that was not read yet."""
        if self.outcome is not None:
            return verdict_of(self.outcome, self.log.group)
        return None if self.why_not is None else _UNREAD

    @property
    def began_at(self) -> datetime | None:
        if self.entry is not None:
            return self.entry.started_at
        return None if self.log.stamp is None else self.log.stamp.changed_at

    @property
    def length_s(self) -> float:
        """-1 where it is unknown."""
        if self.log.flight is not None:
            return self.log.flight.duration_s
        return -1.0 if self.entry is None or self.entry.trouble is not None else self.entry.duration_s


def _time_text(row: LogRow) -> str:
    return "—" if row.began_at is None else f"{row.began_at.astimezone():%Y-%m-%d %H:%M}"


def _kind_icon(row: LogRow) -> QIcon:
    """A recording, or a flight log; what a recording is besides."""
    entry = row.entry
    if entry is None:
        return icon(Icon.MAP)
    if entry.trouble is not None or entry.was_cut_off:
        return icon(Icon.WARNING, Meaning.ATTENTION)
    if entry.is_running:
        return icon(Icon.RECORD)
    return icon(Icon.SIMULATOR if entry.is_simulated else Icon.RECORDINGS)


def _answer(row: LogRow) -> str:
    if row.verdict is None:
        return ""
    if row.outcome is not None and row.verdict.word == _FIRES.word:
        return moment_text(row.outcome.at_s)
    return tr(row.verdict.word)


def _answer_order(row: LogRow) -> float:
    """Sort what is not as expected first, then by time; what is not known last."""
    if row.verdict is None:
        return 1e10
    at_s = 1e8 if row.outcome is None else min(row.outcome.at_s, 1e8)
    return at_s if row.verdict.meaning is not None else 1e9 + at_s


class LogColumn(IntEnum):
    NAME = 0
    WHEN = 1
    LENGTH = 2
    ANSWER = 3
    SIDE = 4


COLUMNS: Final = (
    TableColumn[LogRow](
        marked("Log"),
        lambda row: clean(row.label, longest=80),
        picture=_kind_icon,
        widest=lambda: "survey-00.csv",
        stretches=True,
    ),
    TableColumn[LogRow](
        marked("Time"),
        _time_text,
        lambda row: 0.0 if row.began_at is None else row.began_at.timestamp(),
        widest=lambda: "0000-00-00 00:00",
        is_spare=True,
    ),
    TableColumn[LogRow](
        marked("Duration"),
        lambda row: "—" if row.length_s < 0 else stopwatch(row.length_s),
        lambda row: row.length_s,
        is_right=True,
        widest=lambda: "88:88",
        is_spare=True,
    ),
    TableColumn[LogRow](
        marked("Fires"),
        _answer,
        _answer_order,
        picture=lambda row: None if row.verdict is None else icon(row.verdict.icon, row.verdict.meaning),
        ink=lambda row: None if row.verdict is None else row.verdict.meaning,
        widest=lambda: max(tr(_UNREAD.word), tr(_NOT_JUDGED.word), tr(_LATE.word), "8:88:88.8", key=len),
    ),
    TableColumn[LogRow](
        marked("Side"),
        lambda row: "" if row.log.group is _UNSORTED else capitalised(tr(row.log.group.value)),
        picture=lambda row: None if row.log.group is _UNSORTED else icon(SIDES[row.log.group][2]),
        widest=lambda: capitalised(tr(FlightGroup.MUST_NOT.value)),
    ),
)


# Texts


def short_name(name: str) -> str:
    return clean(Path(name).stem or name, longest=80)


def moment_text(at_s: float) -> str:
    """Time since the beginning of the log: "12.3 s", "3:07.2"."""
    return f"{at_s:.1f} s" if at_s < 60 else f"{stopwatch(at_s)}.{int(at_s * 10) % 10}"


def limits_text(limits: TriggerLimits) -> str:
    angle, force_g, time_s = limits.attitude_threshold_deg, limits.freefall_acceleration_g, limits.freefall_time_s
    return f"{angle:.0f}° · {force_g:.1f} g · {time_s:.2f} s"


def outcome_text(flight: FlightSummary, outcome: FlightOutcome) -> str:
    """When and why it fires, and how late; or why that is not known."""
    if outcome.why_not is not None:
        return labelled(capitalised(tr("not judged")), outcome.why_not.translated())
    if not outcome.sources:
        return capitalised(tr("no trigger"))
    words = {Source.ATTITUDE: tr("attitude"), Source.FREEFALL: tr("free fall")}
    why = " · ".join(word for source, word in words.items() if source in outcome.sources)
    fires = tr("Fires at {time}: {why}", time=moment_text(outcome.at_s), why=why)
    if not outcome.is_before_impact:
        return join_names((fires, tr("after the impact")))
    if flight.loss_s is None or outcome.at_s < flight.loss_s:
        return fires
    return join_names((fires, tr("{delay:.2f} s after the loss of control", delay=outcome.at_s - flight.loss_s)))


def row_text(row: LogRow) -> str:
    """The row as text, for the tooltip, search and screen readers."""
    lines = [clean(row.name, longest=200) + in_brackets(tr(row.log.group.value))]
    if row.entry is not None:
        lines.append(entry_text(row.entry))
    elif row.log.stamp is not None:
        lines.append(tr("File of {time}", time=_time_text(row)))
    if row.why_not is not None:
        lines.append(row.why_not.translated())
    flight = row.log.flight
    if flight is not None and row.outcome is not None:
        lines.append(outcome_text(flight, row.outcome))
        if not math.isnan(flight.tilt_max_deg):
            lines.append(labelled(tr("Tilt"), f"{flight.tilt_max_deg:.0f}°"))
        lines += [problem.translated() for problem in flight.problems]
    return "\n".join(lines)


def sides_text(rows: list[LogRow]) -> tuple[str, bool]:
    """How many fire on each side, and whether that is not as it must be."""
    texts, is_bad = [], False
    for group in (FlightGroup.MUST_NOT, FlightGroup.MUST):
        outcomes = [row.outcome for row in rows if row.outcome is not None and row.log.group is group]
        total = len(outcomes)
        if group is FlightGroup.MUST:
            count = sum(outcome.is_before_impact for outcome in outcomes)
            text, is_wrong = tr("{count} of {total} fire in time", count=count, total=total), count < total
        else:
            count = sum(outcome.answer is Answer.FIRES for outcome in outcomes)
            text, is_wrong = tr("{count} of {total} fire", count=count, total=total), count > 0
        is_bad |= is_wrong
        texts += [labelled(capitalised(tr(group.value)), text)] if outcomes else []
    return " · ".join(texts), is_bad
