"""Writes one recording, in the recorder's thread."""

import json
import math
import os
import secrets
import zlib
from collections.abc import Iterable
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import IO

import numpy as np

from app.captures.writer import entries_of, lines_of
from app.engine.device import DeviceView, StatusSample
from app.engine.worker import Batch, PortState
from app.recordings.commits import Extents, encoded_commit, nothing
from app.recordings.file_layout import (
    ACTIVE,
    COLUMNS,
    COMMITS,
    DATA_FILES,
    JOURNAL,
    LINE,
    SESSION,
    TRIGGERED,
    Opening,
    hold,
)
from app.recordings.markers import NO_LIMITS, Marker, ModuleLimits
from app.system.files import private_opener, write_whole

_STATUS, _CELL, _LIGHT = (tuple(COLUMNS[table]) for table in ("status", "cell", "light"))


def new_folder(library: Path, started_at: datetime) -> Path:
    """Makes a folder whose name sorts by time. Raises OSError."""
    folder = library / f"{started_at.astimezone(UTC):%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}"
    folder.mkdir(mode=0o700)
    return folder


class SessionWriter:
    """Methods raise OSError where the disk fails; what was committed before stays readable."""

    def __init__(self, folder: Path, opening: Opening) -> None:
        self.folder = folder
        self.opening = opening
        self.extents = nothing(opening)
        """The last commit."""
        self.size_bytes = 0
        self._limits = NO_LIMITS
        self._baud_rate = opening.baud_rate
        self._samples: list[StatusSample] = []
        self._slow: dict[str, list[tuple[float, float]]] = {"cell": [], "light": []}
        self._batches: list[Batch] = []
        self._journal: list[dict[str, object]] = []
        # Values polled before the beginning are in the previous part.
        self._newest_s = dict.fromkeys(COLUMNS, math.nextafter(opening.start_s, -math.inf)) | {"status": -math.inf}
        self._lock = hold(folder)
        self._files: dict[str, IO[bytes]] = {}
        try:
            for name in (*DATA_FILES, COMMITS):
                self._files[name] = open(folder / name, "xb", buffering=0, opener=private_opener)  # noqa: SIM115
            write_whole(folder / SESSION, opening.encoded(), is_private=True)
            self._head = "".join(f"{line}\n" for line in opening.capture_header.lines()).encode("utf-8", "replace")
        except BaseException:
            self.close()
            raise

    def put(self, batch: Batch, markers: Iterable[Marker], limits: ModuleLimits) -> None:
        """Takes in what the next `flush` writes."""
        self._samples += batch.samples
        if batch.events:
            self._batches.append(batch)
        if batch.connection.state is PortState.OPEN:
            # While a port opens, the view is still that of the previous module.
            self._put_slow(batch.device)
            if batch.connection.baud_rate != self._baud_rate:
                self._baud_rate = batch.connection.baud_rate
                self.note(batch.at, "baud_rate", baud_rate=self._baud_rate)
        for one in markers:
            self.note(one.time_s, "happening", kind=one.kind.value, port=one.port)
        if limits != self._limits:
            self._limits = limits
            self.note(batch.at, "limits", **asdict(limits))

    def note(self, at: float, what: str, **values: object) -> None:
        """Adds an object to the journal."""
        self._journal.append({"at": at, "what": what, **values})

    def name_module(self, module: str) -> None:
        self.opening = replace(self.opening, module=module)
        write_whole(self.folder / SESSION, self.opening.encoded(), is_private=True)

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes and commits everything pending."""
        data = self._encoded()
        crc = 0
        for name in DATA_FILES:
            raw = data.get(name, b"")
            self._write(name, raw)
            crc = zlib.crc32(raw, crc)
        size = sum(map(len, data.values()))
        if not (size or is_last) and now_s < self.extents.at_s + 1.0:
            return
        rows = {table: len(data.get(next(iter(columns)), b"")) // 8 for table, columns in COLUMNS.items()}
        before = self.extents
        extents = Extents(
            max(now_s, before.at_s, *self._newest_s.values()),
            before.status_rows + rows["status"],
            before.cell_rows + rows["cell"],
            before.light_rows + rows["light"],
            before.line_bytes + len(data.get(LINE, b"")),
            before.journal_bytes + len(data.get(JOURNAL, b"")),
            is_last=is_last,
        )
        record = encoded_commit(extents, crc)
        self._write(COMMITS, record)
        self.extents = extents
        self.size_bytes += size + len(record)

    def sync(self) -> None:
        """Waits until the data is safe from a power failure."""
        for name in (*DATA_FILES, COMMITS):
            os.fsync(self._files[name].fileno())

    def close(self) -> None:
        """Closes the files; never raises. Idempotent."""
        files, self._files = self._files, {}
        for file in (*files.values(), self._lock):
            if file is not None:
                try:
                    file.close()
                except OSError:
                    continue  # unbuffered: nothing can be lost
        self._lock = None

    def _put_slow(self, device: DeviceView) -> None:
        for table, key in (("cell", "cell_voltage_v"), ("light", "light_v")):
            known = device.values.get(key)
            if known is not None and not known.is_stale and known.at > self._newest_s[table]:
                self._newest_s[table] = known.at
                self._slow[table].append((known.at, float(known.value)))

    def _encoded(self) -> dict[str, bytes]:
        """Removes the pending data and returns it as bytes by file."""
        data: dict[str, bytes] = {}
        if self._samples:
            columns = np.array(self._samples, np.float64).T
            # Readers rely on ascending times.
            times = np.maximum.accumulate(np.maximum(columns[0], self._newest_s["status"]))
            self._newest_s["status"] = float(times[-1])
            flags = columns[3] * TRIGGERED + columns[4] * ACTIVE
            for name, column in zip(_STATUS, (times, columns[1], columns[2], flags), strict=True):
                data[name] = column.astype(COLUMNS["status"][name]).tobytes()
        for table, names in (("cell", _CELL), ("light", _LIGHT)):
            if self._slow[table]:
                pairs = np.array(self._slow[table], np.float64).T
                for name, column in zip(names, pairs, strict=True):
                    data[name] = column.astype(COLUMNS[table][name]).tobytes()
        if self._batches:
            events = (event for batch in self._batches for event in batch.events)
            entries = entries_of(events, self.opening.start_s)
            data[LINE] = "".join(f"{line}\n" for entry in entries for line in lines_of(entry)).encode()
        if self._head:
            data[LINE], self._head = self._head + data.get(LINE, b""), b""
        if self._journal:
            data[JOURNAL] = "".join(f"{json.dumps(one)}\n" for one in self._journal).encode()
        self._samples, self._batches, self._journal = [], [], []
        self._slow = {"cell": [], "light": []}
        return data

    def _write(self, name: str, raw: bytes) -> None:
        view = memoryview(raw)
        while view:
            view = view[self._files[name].write(view) :]
