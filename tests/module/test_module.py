"""The independent module answers as the vendor's table says."""

from tests.module.log import NOT_A_FRAME
from tests.module.module import BY_ATTITUDE, Module
from tests.module.options import Options
from tests.vendor.frames import VECTORS


def frames_said(options: Options, *, cell: int, charging: int, boots: int) -> set[bytes]:
    """Return all that a module says when each frame is sent to it that the table prints for the host."""
    module = Module(options)
    module.readings.tilt_deg = 7
    module.readings.cell = cell
    module.readings.charging = charging
    module.hear(bytes.fromhex("42 61 10 02 01 13 42 61 32 01 00 33 42 61 30 01 00 31 42 61 31 01 00 32"), 1.0)
    for vector in VECTORS:
        if vector.is_from_host and vector.id != "shutdown":
            module.hear(vector.raw, 1.0)
            module.speak(1.0)
    module.restart(2.0, boots=boots - 1)
    module.speak(3.0)
    module.readings.cell = 0xEB if boots == 1 else 0xC8
    module.settings[0x10] = 1
    module.trigger(3.0 + 108, BY_ATTITUDE)
    module.hear(bytes.fromhex("42 61 31 01 00 32 42 61 35 01 00 36 42 61 12 02 01 15"), 200.0)
    module.speak(200.0)
    assert not [entry for entry in module.log if entry.kind == NOT_A_FRAME]
    return {entry.frame for entry in module.log.sent()}


def test_it_says_each_frame_that_the_table_prints_for_the_module() -> None:
    said = frames_said(Options(light_closed=0x0C), cell=0xBE, charging=0, boots=1)
    said |= frames_said(Options(voltage_code=0x34, light_closed=0x0C), cell=0xBE, charging=0, boots=202)
    said |= frames_said(Options(voltage_code=0x34, freefall_code=0x16), cell=0xC8, charging=1, boots=1)
    said |= frames_said(Options(voltage_code=0x34, misprinted_sum=True), cell=0xD2, charging=1, boots=1)
    said |= frames_said(Options(), cell=0xC8, charging=1, boots=1)
    said |= frames_said(Options(), cell=0xD2, charging=1, boots=1)
    missing = [vector.id for vector in VECTORS if not vector.is_from_host and vector.raw not in said]
    assert missing == []
