"""Writes settings to faulty modules with all quirks, and compares the report with what the module then holds."""

from dataclasses import dataclass
from typing import Any, Final

from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.adversary.faults import TROUBLES
from tests.faults.fault_table import truth
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig

SETTLED_S = 1.0
"""Time after the report within which these modules make their late changes."""
_TOO_LATE: Final = ("changes after three reads", "silent restart at 1.6 s", "mute")
"""What happens after the last reading, which ends the report; and where nothing is written."""
WRITE_LIES: Final = {
    name: one.options
    for name, one in TROUBLES.items()
    if one.accident is None and not one.forges and name not in _TOO_LATE
}
WANTED: tuple[dict[str, Value], ...] = (
    {"freefall_time": 1.2},
    {"attitude_threshold": 130},
    {"freefall_acceleration": 0.9, "light_threshold": 2.1},
    {"attitude_trigger": False, "freefall_time": 0.2, "attitude_threshold": 75},
)


@dataclass(frozen=True, slots=True)
class Write:
    """One write; `before` and `holds` are the module's values before it and `SETTLED_S` after it, by key."""

    report: WriteReport
    before: dict[str, Any]
    holds: dict[str, Any]
    has_restarted: bool

    @property
    def faults(self) -> list[str]:
        report, found = self.report, []
        for written in report.results:
            key = written.command.key
            if written.verified and self.holds[key] != written.target:
                found.append(f"{key} verified as {written.target}, and it holds {self.holds[key]}")
            if written.verified and self.has_restarted:
                found.append(f"{key} verified over a restart")
        written_keys = {written.command.key for written in report.results}
        named = {one.command.key for one in report.changed} | {command.key for command in report.unread}
        if report.is_fine:
            found += [
                f"{key} moved from {self.before[key]} to {self.holds[key]} unreported"
                for key in self.before
                if key not in written_keys | named and self.before[key] != self.holds[key]
            ]
        return found


KEYS = ("attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "light_threshold_v")


def write_to(options: dict[str, Any], wanted: dict[str, Value]) -> Write:
    rig = Rig({"uptime": 60, "noise": 0} | options)
    boots = rig.bench.module.memory.boot_count
    before = truth(rig.bench, rig.clock.now_s)
    changes = [SettingChange(BY_NAME[name], value) for name, value in wanted.items()]
    report = rig.run(
        write_all(changes, WriteContext(journal=FakeJournal(), accepted_risks=frozenset(changes))), limit_s=300.0
    )
    has_restarted = rig.bench.module.memory.boot_count != boots
    rig.step_for(SETTLED_S)
    holds = truth(rig.bench, rig.clock.now_s)
    return Write(report, {key: before[key] for key in KEYS}, holds, has_restarted)
