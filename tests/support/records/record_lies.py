"""Reading trigger records from a module that loses or never sends them, compared with what it holds."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

from app.procedures.history import History, read_history
from tests.faults.fault_table import records_held
from tests.support.line.sim_line import Rig

RECORD_LIES: tuple[dict[str, Any], ...] = (
    {"drop_records": "1/2,1/3,1/4,1/5"},
    {"drop_records": "2/1"},
    {"drop_records": "1/2,2/3,3/4"},
    {"drop_records": "1/1,2/1,3/1,4/1,5/1,6/1,7/1,8/1,9/1"},
    {"mute_codes": "35"},
    {"mute_codes": "35/2"},
    {"double_codes": "35"},
    {"double_codes": "35", "double_ms": "30"},
    {"double_codes": "01,35", "double_ms": "5"},
    {"foreign_replies": "35:22"},
    {"drop": "0.1"},
    {"drop": "0.3"},
    {"corrupt": "0.004"},
    {"corrupt": "0.02"},
    {"lose": "0.01"},
    {"double": "0.5"},
    {"min_gap_ms": "2"},
    {"half_duplex": "yes"},
    {"lag_ms": "700"},
)
RECORD_DIALECTS: tuple[dict[str, Any], ...] = tuple(
    {"records": records, "empty_slots": empty} for records in ("together", "spaced", "pieces")
    for empty in ("none", "zeros", "ones")
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class RecordsRead:
    """One reading of the history, and the records that the module holds."""

    history: History
    held: Counter[bytes]

    @property
    def faults(self) -> list[str]:
        history, held = self.history, self.held
        certain = Counter(one.raw for one in history.records)
        shown = Counter(one.raw for one in history.all)
        found = []
        if certain - held:
            found.append("certain, and the module never had it")
        if history.is_confirmed and shown != held:
            found.append("complete, and it is not")
        if history.is_confirmed and not history.is_answered:
            found.append("complete without an answer")
        if not history.is_answered and shown:
            found.append("records without an answer")
        return found


def read_records(options: dict[str, Any]) -> RecordsRead:
    rig = Rig({"uptime": 60, "noise": 0} | options)
    history = rig.run(read_history())
    return RecordsRead(history, Counter(records_held(rig.bench)))
