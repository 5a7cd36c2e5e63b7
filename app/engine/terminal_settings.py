"""The settings of a serial line that pyserial leaves as they were, and proof that the driver took all. POSIX only."""

import fcntl
import os
import termios

TerminalError = termios.error

_INPUT, _CONTROL, _LOCAL, _OUTPUT_SPEED = 0, 2, 3, 5
"""Where `tcgetattr` has them."""
_NOT_INPUT = {
    name: getattr(termios, name)
    for name in ("BRKINT", "PARMRK", "ISTRIP", "INPCK", "INLCR", "IGNCR", "ICRNL", "IXON", "IXOFF", "IXANY")
}
_NOT_CONTROL = {name: getattr(termios, name, 0) for name in ("PARENB", "CSTOPB", "CRTSCTS")}
_NOT_LOCAL = {name: getattr(termios, name) for name in ("ICANON", "ECHO", "ISIG", "IEXTEN")}


def complete(number: int) -> None:
    """Leave nothing of what was set before. With BRKINT a break on the line throws away what was received."""
    attributes = termios.tcgetattr(number)
    for index, unwanted in ((_INPUT, _NOT_INPUT), (_CONTROL, _NOT_CONTROL), (_LOCAL, _NOT_LOCAL)):
        for flag in unwanted.values():
            attributes[index] &= ~flag
    termios.tcsetattr(number, termios.TCSANOW, attributes)


def refused(number: int, baud_rate: int) -> str:
    """Return what the driver did not take of 8N1, no flow control and the rate; empty if it took all."""
    attributes = termios.tcgetattr(number)
    wrong = []
    for index, unwanted in ((_INPUT, _NOT_INPUT), (_CONTROL, _NOT_CONTROL), (_LOCAL, _NOT_LOCAL)):
        wrong += [f"-{name.lower()}" for name, flag in unwanted.items() if attributes[index] & flag]
    if attributes[_CONTROL] & termios.CSIZE != termios.CS8:
        wrong.append("cs8")
    if attributes[_OUTPUT_SPEED] != getattr(termios, f"B{baud_rate}", attributes[_OUTPUT_SPEED]):
        wrong.append(str(baud_rate))
    return " ".join(wrong)


def is_pseudo_terminal(port: str) -> bool:
    return os.path.realpath(port).startswith(("/dev/pts/", "/dev/ttys"))


def keep_others_off(number: int) -> None:
    """Let no other program open the port until it is closed; the system lets the administrator in all the same.

    Not for a pseudo-terminal: of one whose other end stays open, this survives a program that was killed.
    """
    fcntl.ioctl(number, termios.TIOCEXCL)
