"""Connection target: a port with its baud rate and adapter, and what its address says."""

from typing import NamedTuple


class Target(NamedTuple):
    """A port to connect to. `baud_rate` is tried first; with `finds_rate` all others if necessary."""

    device: str
    baud_rate: int
    identity: str = ""  # of the adapter; empty where there is none (a URL, a pseudo-terminal)
    finds_rate: bool = False

    @property
    def key(self) -> str:
        """The adapter where it is known, else the port."""
        return self.identity or self.device

    @property
    def is_simulated(self) -> bool:
        return is_simulated(self.device)


def is_simulated(port: str) -> bool:
    """Whether the port is a simulated module's, by its address."""
    return port.lower().startswith("sim:")


def is_network_address(port: str) -> bool:
    return is_socket(port) or port.startswith("rfc2217://")


def is_socket(port: str) -> bool:
    """Whether the port is at the other end of a plain socket, where somebody else sets the baud rate."""
    return port.startswith(("socket://", "shared://"))


def is_shared(port: str) -> bool:
    """Whether the port is one that `dps-s serve` shares: it takes nothing but questions and LOCK."""
    return port.startswith("shared://")


def host_and_port(address: str) -> tuple[str, int]:
    """Split "HOST:PORT", where an IPv6 host stands in brackets. Raises ValueError."""
    host, _, port = address.strip().rpartition(":")
    host = host.strip("[]")
    if not host or not port.isdecimal() or int(port) > 0xFFFF:
        raise ValueError(address)
    return host, int(port)
