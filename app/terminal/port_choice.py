"""Port of a command that was given none: `DPS_S_PORT`, or the only USB adapter."""

import os

from app.terminal.console import NO_LINK, USED_WRONGLY, note
from app.text.i18n import tr
from app.text.sentences import listed

PORT = "DPS_S_PORT"
"""Environment variable: the port, where --port is left out."""


class NoPortChosen(Exception):
    """There is no port to take, or more than one. `sentence` is for people, in their language."""

    def __init__(self, sentence: str, exit_code: int) -> None:
        super().__init__(sentence)
        self.sentence, self.exit_code = sentence, exit_code


def choose_port() -> str:
    """The port to take, which is said. Raises `NoPortChosen`."""
    from app.engine.ports import PortsUnknown, list_ports

    named = os.environ.get(PORT, "").strip()
    if named:
        note(tr("Port {port}, from {variable}.", port=named, variable=PORT))
        return named
    try:
        adapters = [port for port in list_ports() if port.vid is not None]
    except PortsUnknown as error:
        raise NoPortChosen(error.sentence, NO_LINK) from error
    if not adapters:
        text = tr("There is no USB adapter. Plug it in, or name the port: --port P or {variable}.", variable=PORT)
        raise NoPortChosen(text, NO_LINK)
    if len(adapters) > 1:
        names = listed(port.device for port in adapters)
        text = tr("There are several adapters: {names}. Choose one: --port P or {variable}.", names=names,
                  variable=PORT)  # fmt: skip
        raise NoPortChosen(text, USED_WRONGLY)
    found = adapters[0]
    note(tr("Port {port}, the only adapter ({name}).", port=found.device, name=found.description or found.identity))
    return found.device
