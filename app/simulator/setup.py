"""The options of a simulated module and its line: `dps-s simulate --tilt 5 --drop 0.1`, `sim://bench?tilt=5&drop=0.1`."""

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from msgspec import Meta, Struct, ValidationError, convert

from app.text.messages import UserError

Rate = Literal[115200, 57600, 38400, 19200, 9600, 4800]
Share = Annotated[float, Meta(ge=0, le=1)]
Later = Annotated[float, Meta(ge=0, le=86_400)]
_SWITCHED: Final = {"": "true", "yes": "true", "no": "false"}


class Setup(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the module and its line begin. Shares are 0 … 1; what happens after 0 s never happens."""

    baud: Annotated[Rate, Meta(description="baud rate, 4800 to 115200")] = 115200
    rate: Annotated[float, Meta(ge=1, le=1440, description="frames a second while it streams")] = 50.0
    active: Annotated[bool, Meta(description="active from the beginning")] = False
    boots: Annotated[int, Meta(ge=0, le=255, description="boot count")] = 37
    uptime: Annotated[float, Meta(ge=0, le=65535, description="seconds since power-on; 0: two heartbeats come")] = 60.0
    history: Annotated[int, Meta(ge=0, le=9, description="trigger records of earlier boots")] = 0
    seed: Annotated[int, Meta(ge=0, description="of what is random")] = 1
    mute: Annotated[bool, Meta(description="silent: says nothing")] = False
    drop: Annotated[Share, Meta(description="share of the replies that are lost")] = 0.0
    corrupt: Annotated[Share, Meta(description="share of the bytes of replies with a wrong bit")] = 0.0
    lag_ms: Annotated[float, Meta(ge=0, le=10_000, description="how late replies come, in ms")] = 0.0
    tilt: Annotated[float, Meta(ge=-180, le=180, description="tilt in degrees")] = 0.0
    bay_open: Annotated[bool, Meta(description="the bay is open")] = False
    cell: Annotated[float, Meta(ge=0, le=5, description="cell voltage in V")] = 3.9
    charger: Annotated[bool, Meta(description="external power")] = False
    lifelike: Annotated[bool, Meta(description="moves a little, as in a hand")] = False
    fall_after: Annotated[Later, Meta(description="falls after so many seconds")] = 0.0
    pwm_after: Annotated[Later, Meta(description="is triggered by PWM after so many seconds")] = 0.0
    restart_after: Annotated[Later, Meta(description="restarts after so many seconds")] = 0.0


def parse_options(texts: Mapping[str, str]) -> Setup:
    """Return the setup with these options, by name, which may have `-` for `_`; a switch needs no value. Raises
    `UserError`, which names the wrong option."""
    values = {name.replace("-", "_"): _SWITCHED.get(text.lower(), text) for name, text in texts.items()}
    try:
        return convert(values, Setup, strict=False)
    except ValidationError as error:
        raise UserError(str(error)) from error
