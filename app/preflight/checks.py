"""Catalogue of pre-flight checks: title, judgement, reason and remedy of each.

The order is that of the page. `id` is the contract's. To add a check is to add an entry.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from app.preflight import judging_line as line
from app.preflight import judging_module as module
from app.preflight.findings import Case, Finding
from app.text.messages import said
from protocol.translatable import marked


@dataclass(frozen=True, slots=True)
class Check:
    """Texts are English, translatable."""

    id: str
    title: str
    judge: Callable[[Case], Finding]
    why: str
    do: str


_SETTING = marked("Open Settings, write the value wanted, and see it verified.")
_TRIGGER = marked("Choose “enable now” (--enable-triggers): only an acknowledged set says how it stands.")


def _setting(name: str, low: str, high: str) -> Callable[[Case], Finding]:
    return partial(module.setting, name=name, advice=said(marked("{low} to {high}"), low=low, high=high))


CHECKS: tuple[Check, ...] = (
    Check("undisturbed", marked("Check ran undisturbed"), line.undisturbed,
          marked("What was seen before a restart or a break says nothing about the module now."),
          marked("Check cable and power, and check again.")),
    Check("read_twice", marked("Read twice: the same"), line.read_twice,
          marked("What changes by itself, or when something else is set, cannot be relied on."),
          marked("Read the settings, write what is wrong, and check again. If it changes again, do not fly.")),
    Check("link_loss", marked("Link: loss"), line.link_loss,
          marked("Over a bad line a value may be missing or wrong."),
          marked("Check plugs, ground and cable length, and check again.")),
    Check("round_trip", marked("Link: answer time"), line.round_trip,
          marked("A slow answer points to a bad adapter or a busy computer."),
          marked("Use another adapter or USB socket; close other programs.")),
    Check("status", marked("Status is current"), line.status_fresh,
          marked("An old status says nothing about the module now."),
          marked("Check power and cable, and check again.")),
    Check("triggered", marked("Not triggered"), line.not_triggered,
          marked("A module that has fired has no parachute left."),
          marked("Find out why it fired (Triggers), repack the parachute, lock and restart the module.")),
    Check("activation", marked("Activation"), line.activation,
          marked("An active module fires by itself when it tips over or falls; a locked one must be activated."),
          marked("Send no commands meanwhile, and check again.")),
    Check("tilt", marked("Tilt: level"), line.tilt_level,
          marked("The attitude trigger counts from level; a wrong zero fires early on one side and late on the other."),
          marked("Set the aircraft level. If it is level, correct the mounting and zero the sensor.")),
    Check("tilt_spread", marked("Tilt: steady"), line.tilt_still,
          marked("A reading that wanders while the aircraft stands still comes from a loose or failing sensor."),
          marked("Do not touch the aircraft meanwhile; check how the module is fixed.")),
    Check("acceleration", marked("Acceleration: 1 g"), line.acceleration_one_g,
          marked("At rest the sensor must read 1 g, else free fall is judged wrongly."),
          marked("Set the aircraft down and check again; if it stays, the sensor is faulty: do not fly.")),
    Check("acceleration_spread", marked("Acceleration: steady"), line.acceleration_still,
          marked("Noise at rest can end or fake a free fall."),
          marked("Stop motors and fans, do not touch the aircraft, and check again.")),
    Check("cell_voltage", marked("Cell voltage"), line.cell_voltage,
          marked("A weak cell may not deploy the parachute, and falls further in the cold."),
          marked("Charge the module, unplug it, wait a minute and check again.")),
    Check("charging", marked("Not charging"), line.not_charging,
          marked("With external power the voltage that is read is not the cell's."),
          marked("Unplug the external power and check again.")),
    Check("light", marked("Parachute bay closed"), line.bay_closed,
          marked("Light in the bay means that it is open; without a calibration, that more light reads higher "
                 "is an assumption."),
          marked("Close the bay; if it is closed, calibrate the light threshold.")),
    Check("attitude_threshold", marked("Attitude threshold"), _setting("attitude_threshold", "55°", "90°"),
          marked("The angle at which it fires: too small fires in a turn, too large too late."), _SETTING),
    Check("freefall_acceleration", marked("Free-fall acceleration threshold"),
          _setting("freefall_acceleration", "0.1 g", "0.6 g"),
          marked("Too high fires in a descent, too low detects no fall."), _SETTING),
    Check("freefall_time", marked("Free-fall time"), _setting("freefall_time", "0.50 s", "2.55 s"),
          marked("Too short fires falsely, too long costs height."), _SETTING),
    Check("light_threshold", marked("Light threshold"), module.light_threshold,
          marked("It decides whether the parachute counts as having left the bay."),
          marked("Calibrate it with the bay closed and open, and keep it in a profile.")),
    Check("attitude_trigger", marked("Attitude trigger enabled"), partial(module.trigger, key="attitude_trigger"),
          marked("It fires when the aircraft tips over. The module cannot be asked whether it is enabled."), _TRIGGER),
    Check("freefall_trigger", marked("Free-fall trigger enabled"), partial(module.trigger, key="freefall_trigger"),
          marked("It fires in free fall. The module cannot be asked whether it is enabled."), _TRIGGER),
    Check("trigger_records", marked("No new trigger record"), module.trigger_records,
          marked("A trigger that nobody has explained can happen again in flight."),
          marked("Look at it (Triggers) and judge it: bench test, real or false.")),
    Check("boot_count", marked("Boot count fits the module"), module.boot_count,
          marked("The module has no serial number; its boot count only grows."),
          marked("Make sure which module this is, and name it.")),
    Check("fingerprint", marked("Settings as approved"), module.settings_fingerprint,
          marked("One code stands for all settings that can be read."),
          marked("Compare the settings with the profile and write what differs; or approve them.")),
    Check("guided_tests", marked("Guided tests"), module.guided_tests,
          marked("Only a test by hand shows that tilt, fall, bay and charger are noticed."),
          marked("Do them on the Tests page, with the module named.")),
)  # fmt: skip
