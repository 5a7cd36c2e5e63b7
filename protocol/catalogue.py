"""Every command of the vendor's table (2019-04-30), one entry each.

Codec, link, command line, simulated module, window, help and `docs/protocol.md` derive from these entries: a new
command needs an entry here and nothing else. E1 … E15 are the places where the table contradicts itself, explained in
`docs/protocol.md`.
"""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from protocol.fields import Choice, Done, Field, Flag, Quantity, Value
from protocol.translatable import marked

HOST_HEADER = b"Ba"  # 42 61, host to module
MODULE_HEADER = b"Au"  # 41 75, module to host
QUERY = 0x01  # D3: query, and also every reply
SET = 0x02  # D3: set
MAX_RECORDS = 9  # "记录最近的9次触发记录": the module keeps its last nine triggers


class Hazard(Enum):
    NONE = "none"  # a question. May be repeated.
    CHANGES = "changes"  # changes the module. Sent once; the result is proven by reading back.
    # Fires, arms, ends the session, moves the reference or can cut the link. Never without an explicit act.
    DANGEROUS = "dangerous"


class Layout(Enum):
    """Layout of a module frame; the value is its length in bytes, header and checksum included."""

    SHORT = 6  # 41 75 code 01 D4 sum
    STATUS = 8  # 41 75 32 tilt acc trig act sum: no control byte
    RECORD = 16  # 41 75 35 01 and eleven data bytes, sum


class Advice(NamedTuple):
    """The vendor's advice about a value (建议). Other values cause a warning, never a refusal."""

    text: str
    minimum: float | None = None
    maximum_below: float | None = None  # exclusive

    def is_followed_by(self, value: float) -> bool:
        if self.minimum is not None and value < self.minimum:
            return False
        return self.maximum_below is None or value < self.maximum_below


class Command(NamedTuple):
    """One row of the table. See the module's docstring."""

    code: int  # D2
    name: str  # the name in JSON, `--asked`, code and tests
    title: str  # English, translatable
    vendor_term: str  # the table's word
    explanation: str  # one or two sentences for a technician; translatable
    reply: Field | None = None  # meaning of D4 in a six-byte reply; None for another layout or where D4 is fixed
    reply_key: str | None = None  # name of the reply's value in `dps-s decode`; carries the unit
    layout: Layout = Layout.SHORT
    query_data: int | None = None  # D4 of the query; None where it cannot be asked
    query_hazard: Hazard = Hazard.NONE  # 25 has the form of a query and is an act
    write: Field | None = None  # meaning of D4 in a set; None where it cannot be set
    write_key: str | None = None
    write_hazards: Mapping[int, Hazard] = MappingProxyType({})  # hazard of a set by D4, where it is not CHANGES
    extra_reply_codes: frozenset[int] = frozenset()  # further codes of its reply (E3, E4)
    acknowledged_by_one: bool = False  # a set may be acknowledged by D4 = 01 instead of the value (E2)
    is_setting: bool = False  # in `read`'s "settings", in `set` and in profiles
    default: int | None = None  # D4 as delivered, where the table gives it. Never shown as the module's value.
    advice: Advice | None = None

    def __repr__(self) -> str:
        return f"<{self.name}>"

    def __hash__(self) -> int:
        # Requests are looked up in every turn, and hashing all fields would cost a twelfth of it.
        return self.code

    @property
    def key(self) -> str:
        """Name with its unit, as in JSON and profiles: "light_threshold_v"."""
        return self.name + (self.reply.suffix if isinstance(self.reply, Quantity) else "")

    @property
    def reply_codes(self) -> frozenset[int]:
        return self.extra_reply_codes | {self.code}

    @property
    def can_be_asked(self) -> bool:
        return self.query_data is not None and self.query_hazard is Hazard.NONE

    @property
    def reads_back(self) -> bool:
        """Whether a set can be verified by a query (E8: not 13, 16, 17; E2: not 24)."""
        return self.write is not None and self.can_be_asked

    def query(self) -> "Request":
        """The query (for 25 the act). Raises `LookupError` where there is none."""
        if self.query_data is None:
            raise LookupError(f"{self.name} has no query")
        if self.code == HEARTBEAT_CODE:
            return Request(self, 0xA5, self.query_data)
        return Request(self, QUERY, self.query_data)

    def set(self, value: Value) -> "Request":
        """The set of `value`, in the field's unit. Raises `LookupError` or `ValueRefused`."""
        if self.write is None:
            raise LookupError(f"{self.name} cannot be set")
        return Request(self, SET, self.write.encode(value))


class Request(NamedTuple):
    """A host frame with its meaning: 42 61, code, control, data, sum. Always six bytes."""

    command: Command
    control: int
    data: int

    @property
    def is_set(self) -> bool:
        return self.control == SET

    @property
    def hazard(self) -> Hazard:
        if self.is_set:
            return self.command.write_hazards.get(self.data, Hazard.CHANGES)
        return self.command.query_hazard

    @property
    def is_repeatable(self) -> bool:
        """Whether the link may repeat it: only questions. For LOCK see `Link.lock_again`."""
        return self.hazard is Hazard.NONE

    def encode(self) -> bytes:
        body = bytes((self.command.code, self.control, self.data))
        return HOST_HEADER + body + bytes((sum(body) & 0xFF,))


HEARTBEAT_CODE = 0x01
STATUS_CODE = 0x32
RECORD_CODE = 0x35

TENTH_VOLT = Quantity(unit="V", suffix="_v", per_unit=10)
CELL_VOLT = Quantity(unit="V", suffix="_v", per_unit=50)
TENTH_G = Quantity(unit="g", suffix="_g", per_unit=10)
CENTISECOND = Quantity(unit="s", suffix="_s", per_unit=100)
DEGREE = Quantity(unit="°", suffix="_deg", per_unit=1)
COUNT = Quantity(unit="", suffix="", per_unit=1)
FLAG = Flag()
INVERTED = Flag(true=0x00)
BAUD = Choice({1: 4800, 2: 9600, 3: 19200, 4: 38400, 5: 57600, 6: 115200}, unit=marked("baud"))

COMMANDS: tuple[Command, ...] = (
    Command(
        code=HEARTBEAT_CODE, name="heartbeat", title=marked("Heartbeat"), vendor_term="心跳",
        explanation=marked("Proves that the module is there; two come after power-up."),
        query_data=0x5A,
    ),
    Command(
        code=0x10, name="activation", title=marked("Activate / lock"), vendor_term="激活/锁定",
        explanation=marked("An active module fires when it tips over or falls."),
        reply=FLAG, reply_key="active", write=FLAG, write_key="set",
        write_hazards={0x01: Hazard.DANGEROUS},
    ),
    Command(
        code=0x11, name="deploy", title=marked("Deploy over serial"), vendor_term="串口触发开伞",
        explanation=marked("Fires the parachute; 00 forbids it, for an unknown time."),
        reply=FLAG, reply_key="deployed", write=FLAG, write_key="set",
        write_hazards={0x00: Hazard.DANGEROUS, 0x01: Hazard.DANGEROUS},
    ),
    Command(
        code=0x12, name="shutdown", title=marked("Shut down"), vendor_term="关机",
        explanation=marked("Off until its switch (2 s) or external power."),
        reply=Done(), write=Done(),
        write_hazards={0x01: Hazard.DANGEROUS},
    ),
    Command(
        code=0x13, name="serial_output", title=marked("Serial output"), vendor_term="串口输出",
        explanation=marked("Streams the status unasked."),
        reply=FLAG, reply_key="on", write=FLAG, write_key="set", is_setting=True,
    ),
    Command(
        code=0x14, name="light", title=marked("Light"), vendor_term="当前光线值",
        explanation=marked("Light in the parachute bay: tells whether it is open."),
        reply=TENTH_VOLT, reply_key="light_v", query_data=0x01,
    ),
    Command(
        code=0x15, name="light_threshold", title=marked("Light threshold"), vendor_term="光线阈值",
        explanation=marked("Beyond it the parachute counts as ejected."),
        reply=TENTH_VOLT, reply_key="value_v", query_data=0x00, write=TENTH_VOLT, write_key="set_v",
        is_setting=True, advice=Advice(marked("Set it to the reading with the bay fully open.")),
    ),
    Command(
        code=0x16, name="attitude_trigger", title=marked("Attitude trigger"), vendor_term="姿态触发",
        explanation=marked("Fires by itself when it tips over."),
        reply=INVERTED, reply_key="enabled", write=INVERTED, write_key="set_enabled",
        is_setting=True, default=0x00,
    ),
    Command(
        code=0x17, name="freefall_trigger", title=marked("Free-fall trigger"), vendor_term="失重触发",
        explanation=marked("Fires by itself in free fall."),
        reply=INVERTED, reply_key="enabled", write=INVERTED, write_key="set_enabled",
        extra_reply_codes=frozenset((0x16,)), is_setting=True, default=0x00,
    ),
    Command(
        code=0x20, name="attitude_threshold", title=marked("Attitude threshold"), vendor_term="姿态开伞阈值",
        explanation=marked("Tilt at which it fires; rearms 10° below."),
        reply=DEGREE, reply_key="value_deg", query_data=0x00, write=DEGREE, write_key="set_deg",
        is_setting=True, default=60, advice=Advice(marked("55° or more."), minimum=55),
    ),
    Command(
        code=0x21, name="freefall_acceleration", title=marked("Free-fall acceleration threshold"),
        vendor_term="失重加速度阈值",
        explanation=marked("Below it the module counts as falling."),
        reply=TENTH_G, reply_key="value_g", query_data=0x00, write=TENTH_G, write_key="set_g",
        acknowledged_by_one=True, is_setting=True, default=5,
        advice=Advice(marked("Below 0.7 g."), maximum_below=0.7),
    ),
    Command(
        code=0x22, name="freefall_time", title=marked("Free-fall time"), vendor_term="失重时间",
        explanation=marked("How long it falls before it fires."),
        reply=CENTISECOND, reply_key="value_s", query_data=0x00, write=CENTISECOND, write_key="set_s",
        acknowledged_by_one=True, is_setting=True, default=160,
    ),
    Command(
        code=0x23, name="boot_count", title=marked("Boot count"), vendor_term="开机次数",
        explanation=marked("Power-ups so far; 0 follows 255."),
        reply=COUNT, reply_key="boot_count", query_data=0x00,
    ),
    Command(
        code=0x24, name="baud_rate", title=marked("Baud rate"), vendor_term="波特率",
        explanation=marked("Speed of the serial line."),
        reply=BAUD, reply_key="value_baud", write=BAUD, write_key="set_baud",
        write_hazards=dict.fromkeys(BAUD.values, Hazard.DANGEROUS), acknowledged_by_one=True,
        is_setting=True, default=6, advice=Advice(marked("Do not change it.")),
    ),
    Command(
        code=0x25, name="zero_sensor", title=marked("Zero the sensor"), vendor_term="传感器置零",
        explanation=marked("Takes this position as level; for small mounting errors only."),
        reply=Done(), query_data=0x00, query_hazard=Hazard.DANGEROUS,
    ),
    Command(
        code=0x30, name="active", title=marked("Active?"), vendor_term="是否激活",
        explanation=marked("An active module fires when it tips over or falls."),
        reply=Flag(lenient=True), reply_key="active", query_data=0x00,
    ),
    Command(
        code=0x31, name="triggered", title=marked("Triggered?"), vendor_term="开伞状态",
        explanation=marked("Whether the module has triggered."),
        reply=Flag(lenient=True), reply_key="triggered", query_data=0x00,
    ),
    Command(
        code=STATUS_CODE, name="status", title=marked("Status"), vendor_term="降落伞状态",
        explanation=marked("Tilt, acceleration, trigger and activation."),
        layout=Layout.STATUS, query_data=0x00,
    ),
    Command(
        code=0x33, name="charging", title=marked("Charging"), vendor_term="充电状态",
        explanation=marked("Whether external power charges it."),
        reply=FLAG, reply_key="charging", query_data=0x00,
    ),
    Command(
        code=0x34, name="cell_voltage", title=marked("Cell voltage"), vendor_term="电芯电压",
        explanation=marked("With external power it is the charging voltage."),
        reply=CELL_VOLT, reply_key="cell_voltage_v", query_data=0x00,
        extra_reply_codes=frozenset((RECORD_CODE,)),
    ),
    Command(
        code=RECORD_CODE, name="trigger_records", title=marked("Trigger records"), vendor_term="触发记录",
        explanation=marked("The last nine triggers with settings and readings."),
        layout=Layout.RECORD, query_data=0x00,
    ),
)  # fmt: skip

BY_CODE: dict[int, Command] = {command.code: command for command in COMMANDS}
BY_NAME: dict[str, Command] = {command.name: command for command in COMMANDS}
SETTINGS: tuple[Command, ...] = tuple(command for command in COMMANDS if command.is_setting)
READABLE_SETTINGS: tuple[Command, ...] = tuple(command for command in SETTINGS if command.reads_back)

HEARTBEAT = BY_NAME["heartbeat"]
HEARTBEAT_REPLY = MODULE_HEADER + HEARTBEAT.query().encode()[2:]
STATUS = BY_NAME["status"]
TRIGGER_RECORDS = BY_NAME["trigger_records"]
BOOT_COUNT = BY_NAME["boot_count"]
ATTITUDE_TRIGGER = BY_NAME["attitude_trigger"]
FREEFALL_TRIGGER = BY_NAME["freefall_trigger"]
CELL_VOLTAGE = BY_NAME["cell_voltage"]
SERIAL_OUTPUT = BY_NAME["serial_output"]
ACTIVATION = BY_NAME["activation"]
LOCK = ACTIVATION.set(False)
BAUD_RATE = BY_NAME["baud_rate"]
BAUD_RATES: tuple[int, ...] = tuple(sorted(BAUD.values.values(), reverse=True))
DEFAULT_BAUD_RATE = 115200
BOOTS = 256  # the boot count wraps to 0 after 255
RESET_BELOW_THRESHOLD_DEG = 10  # "复位角度=姿态阈值角度减10°"


class FramePart(NamedTuple):
    name: str
    first: int  # index of its first byte in the frame (D0 is the header's first)
    field: Quantity | Flag
    meaning: str  # English, for the page of the protocol
    length: int = 1

    def raw(self, frame: bytes) -> int:
        return int.from_bytes(frame[self.first : self.first + self.length], "big")


STATUS_PARTS: tuple[FramePart, ...] = (
    FramePart("tilt_deg", 3, DEGREE, "tilt, 1°"),
    FramePart("acceleration_g", 4, TENTH_G, "acceleration, 0.1 g"),
    FramePart("triggered", 5, FLAG, "01 triggered, else not"),
    FramePart("active", 6, FLAG, "01 active, else not"),
)
RECORD_PARTS: tuple[FramePart, ...] = (
    FramePart("boot_count", 4, COUNT, "boot count"),
    FramePart("uptime_s", 5, COUNT, "seconds since power-on, high byte first", length=2),
    FramePart("sources", 7, COUNT, "01 serial, 02 attitude, 04 PWM, 08 free fall"),
    FramePart("attitude_threshold_deg", 8, DEGREE, "attitude threshold, 1°"),
    FramePart("freefall_acceleration_g", 9, TENTH_G, "free-fall acceleration threshold, 0.1 g"),
    FramePart("freefall_time_s", 10, CENTISECOND, "free-fall time, 0.01 s"),
    FramePart("serial_connected", 11, INVERTED, "00 link connected, 01 not"),
    FramePart("charging", 12, INVERTED, "00 external power, charging; 01 not"),
    FramePart("light_v", 13, TENTH_VOLT, "light, 0.1 V"),
    FramePart("cell_voltage_v", 14, CELL_VOLT, "cell voltage, 0.02 V"),
)
RECORD_PART: dict[str, FramePart] = {part.name: part for part in RECORD_PARTS}
