"""What the window gathered of one module on one connection."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from app.diagnosis.link_statistics import LinkStatistics
from app.engine.snapshots import Snapshot
from app.settings.settings_watch import SettingsWatch
from app.store.store_journal import new_run

if TYPE_CHECKING:
    from app.preflight.verdict import Void
    from app.records.filing import Filed


@dataclass(eq=False, slots=True)
class ModuleMemory:
    """Belongs to its `Port`, which begins another one with each connection and each other module."""

    run: str = field(default_factory=new_run)
    """Names the connection in the audit log."""
    watch: SettingsWatch = field(default_factory=SettingsWatch)
    statistics: LinkStatistics = field(default_factory=LinkStatistics)
    as_found: Snapshot | None = None
    """The settings before the first write."""
    check: "tuple[Filed, Void | None] | None" = None
    """The last one of the Pre-flight page, and what voids it."""
