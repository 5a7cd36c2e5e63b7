"""Reads DataFlash logs that were saved as text (`.log`): the same records, one a line, with their names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from app.flights.dataflash import TABLES, DataflashTables
from app.flights.flight_log import Floats
from app.flights.records import read_bytes


@dataclass(slots=True)
class TextTable:
    """All records of one name, whose values are already in the units of their format."""

    labels: list[str]
    rows: list[list[str]] = field(default_factory=list)

    def has(self, *names: str) -> bool:
        return len(self.rows) > 0 and all(name in self.labels for name in names)

    def column(self, name: str) -> Floats:
        place = self.labels.index(name)
        return np.array([_number(row[place]) for row in self.rows], np.float64)


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:  # a text, or damage
        return np.nan


class DataflashText(DataflashTables):
    """`tables` has those of `TABLES` in the file, by name. A line that is no whole record is damage."""

    def __init__(self, data: bytes) -> None:
        self.size = len(data)
        self.skipped_bytes = 0
        self.lost_end_bytes = 0
        self._tables: dict[str, TextTable] = {}
        self._names: set[str] = {"FMT"}
        for line in data.decode("latin-1").splitlines(keepends=True):
            if self._read(line):
                self.lost_end_bytes = 0
            else:
                self.skipped_bytes += len(line)
                self.lost_end_bytes += len(line)

    @property
    def tables(self) -> Mapping[str, TextTable]:
        return self._tables

    def _read(self, line: str) -> bool:
        name, _, rest = line.partition(",")
        name = name.strip()
        if name not in TABLES and name != "FMT":
            # Lines before the first format are a heading; a name without a format is damage.
            return name in self._names or not self._tables
        cells = rest.split(",")
        if name == "FMT":
            cells = [cell.strip() for cell in cells]
            if len(cells) < 5:
                return False
            self._names.add(cells[2])
            if cells[2] in TABLES and cells[2] not in self._tables:
                self._tables[cells[2]] = TextTable(cells[4:])
            return True
        table = self._tables.get(name)
        if table is None or len(cells) != len(table.labels) or not line.endswith(("\n", "\r")):
            return False
        table.rows.append(cells)
        return True


def read_dataflash_text(path: Path) -> DataflashText:
    """Raises `UserError`, OSError."""
    return DataflashText(read_bytes(path))
