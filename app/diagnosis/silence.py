"""What came from a port instead of an answer."""

import re
from enum import Enum

from protocol.catalogue import HOST_HEADER, Layout
from protocol.events import Counters, Role

# A heartbeat of MAVLink 1 or 2 (message 0, nine bytes, of which the last is its version, 3), or a message of MSP.
_FLIGHT_CONTROLLER = re.compile(
    rb"\xfe\x09.{3}\x00.{8}\x03|\xfd\x09[\x00\x01]\x00.{3}\x00{3}.{8}\x03|\$M[<>!]|\$X[<>!]\x00", re.DOTALL
)
# By the first byte of a message of MAVLink: the bytes besides its payload, and the place of its number, behind which
# the system's stands.
_MAVLINK = {0xFE: (8, 2), 0xFD: (12, 4)}


class Silence(Enum):
    """The kind of what was received instead of an answer."""

    NOTHING = "nothing"
    GARBAGE = "garbage"  # more invalid bytes than frames: most likely another baud rate
    ECHO = "echo"  # only our own frames
    OTHER_FRAMES = "other frames"  # the module sends but does not answer: its receive line may be open
    FLIGHT_CONTROLLER = "flight controller"  # MAVLink or MSP: a flight controller that passes nothing on


def what_came(counters: Counters, noise: bytes = b"") -> Silence:
    """Return what came instead of an answer. `noise` are the last invalid bytes, in which an echo may be damaged."""
    echoes = counters.by_role[Role.ECHO]
    frames = counters.frames - echoes
    # A glimpse of a frame amid more invalid bytes is accidental.
    if frames * Layout.STATUS.value > counters.rejected:
        return Silence.OTHER_FRAMES
    if counters.rejected and _is_of_flight_controller(noise):
        return Silence.FLIGHT_CONTROLLER
    if counters.rejected and (frames or HOST_HEADER not in noise):
        return Silence.GARBAGE
    return Silence.ECHO if echoes or counters.rejected else Silence.NOTHING


def _is_of_flight_controller(noise: bytes) -> bool:
    """Whether these bytes are MAVLink or MSP: a message that is known, or two of MAVLink in a row from one system."""
    if _FLIGHT_CONTROLLER.search(noise) is not None:
        return True
    for start, magic in enumerate(noise[:-1]):
        if magic in _MAVLINK:
            around, number = _MAVLINK[magic]
            following = noise[start + around + noise[start + 1] :][: number + 2]
            if len(following) == number + 2 and following[0] == magic:
                is_next = following[number] == (noise[start + number] + 1) % 256
                if is_next and following[number + 1] == noise[start + number + 1]:
                    return True
    return False
