"""What the window gathered of one module on one connection, and what it shows of a connection on every page."""

from dataclasses import dataclass, field
from typing import Final, NamedTuple

from app.diagnosis.link_state import LinkState, Phase
from app.diagnosis.link_statistics import LinkStatistics
from app.engine.identity import Identity
from app.engine.snapshots import Snapshot
from app.safety.last_known import Activation
from app.settings.settings_watch import SettingsWatch
from app.store.store_journal import new_run
from protocol.fields import Value


@dataclass(eq=False, slots=True)
class ModuleMemory:
    """Belongs to its `Port`, which begins another one with each connection and each other module."""

    run: str = field(default_factory=new_run)
    """Names the connection in the audit log."""
    watch: SettingsWatch = field(default_factory=SettingsWatch)
    statistics: LinkStatistics = field(default_factory=LinkStatistics)
    as_found: Snapshot | None = None
    """The settings before the first write."""
    is_fired_by_test: bool = False
    """A guided test makes it fire now, and says what comes next."""


VIEWED: Final = ("triggered", "active", "cell_voltage_v", "charging", "boot_count")


class PortView(NamedTuple):
    """Without what ticks. `values`: those of `VIEWED`, each with whether it is stale; `recording`: its state."""

    link: LinkState
    identity: Identity
    activation: Activation
    is_requested: bool
    opening: int
    restarts: int
    values: tuple[tuple[Value, bool] | None, ...]
    recording: object = None

    @property
    def is_aging(self) -> bool:
        """It is shown with an age that ticks."""
        is_stale = any(value is not None and value[1] for value in self.values)
        is_past = self.activation in (Activation.WAS_ACTIVE, Activation.WAS_LOCKED)
        return is_stale or is_past or not (self.link.is_fine or self.link.phase is Phase.CLOSED)
