"""What is kept as the module's settings."""

from app.engine.device import DeviceView, How, Known
from app.engine.snapshots import snapshot_of
from app.settings.profiles import profile_of
from protocol.catalogue import SETTINGS

NOW_S = 100.0


def test_the_serial_output_which_the_program_switches_is_in_no_profile_and_no_snapshot() -> None:
    known = {command.key: Known(True, How.ACKNOWLEDGED, NOW_S) for command in SETTINGS}
    device = DeviceView(values=known)
    others = {command.key for command in SETTINGS} - {"serial_output"}
    assert profile_of(device, NOW_S, name="H6").settings.keys() == others
    assert snapshot_of(device, NOW_S).settings.keys() == others
