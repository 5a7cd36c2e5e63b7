"""Connection target: a port with its baud rate and adapter."""

from dataclasses import dataclass

from app.engine.playback import is_playback


@dataclass(frozen=True, slots=True)
class Target:
    """A port to connect to. `baud_rate` is where to begin; `finds_rate` goes through all rates if need be."""

    device: str
    baud_rate: int
    identity: str = ""
    """Tells the adapter from every other; empty where there is none to tell (a URL, a pseudo-terminal)."""
    title: str = ""
    finds_rate: bool = False

    @property
    def key(self) -> str:
        """The adapter where it is known, else the port: the same for as long as it may be the same module."""
        return self.identity or self.device

    @property
    def is_simulated(self) -> bool:
        return self.device.startswith("sim:")

    @property
    def is_recording(self) -> bool:
        """A capture that is played."""
        return is_playback(self.device)
