"""The simulated module fires exactly where the analysis says."""

import numpy as np
from hypothesis import settings

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import firing_curves
from app.flight_analysis.judged_flight import judge_flight
from app.flight_logs.flight_log import FlightLog
from app.flight_logs.module_view import RuleReading
from app.simulator.hardware import Hardware
from app.simulator.memory import Memory
from app.simulator.physics import SENSOR_PERIOD_S, Physics, SensedMotion
from protocol.messages import Source
from tests.support.flights.made_flights import made_flight

FLIGHTS = 4 * settings().max_examples
SAMPLES = 300


class FlownWorld(Physics):
    """Moves like the flight, sample by sample."""

    def fly(self, tilt_deg: list[float], force_g: list[float]) -> None:
        self.samples = iter(zip(tilt_deg, force_g, strict=True))
        self.sampled_s: list[float] = []

    def motion(self, at_s: float) -> SensedMotion:
        self.sampled_s.append(at_s)
        return SensedMotion(*next(self.samples))


class WitnessedHardware(Hardware):
    """Records the sample at which it fired."""

    def __init__(self, world: Physics, memory: Memory) -> None:
        super().__init__(world, memory=memory)
        self.fired: list[tuple[float, Source]] = []

    def fire(self, sources: Source, now_s: float) -> bool:
        self.fired.append((now_s, sources))
        return super().fire(sources, now_s)


def random_flight(random: np.random.Generator) -> tuple[list[float], list[float]]:
    """Swings and falls at the module's resolution."""
    tilt = np.abs(np.cumsum(random.normal(0, random.choice([2, 8]), SAMPLES))) % 180
    force = 1 + random.normal(0, 0.05, SAMPLES)
    for _ in range(random.integers(0, 4)):
        start, length = random.integers(0, SAMPLES), random.integers(1, 280)
        force[start : start + length] = random.choice([0.0, 0.2, 0.3, 0.4, 0.6])
    return np.rint(tilt).tolist(), (np.rint(np.abs(force) * 10) / 10).tolist()


def module_fires(memory: Memory, tilt: list[float], force: list[float]) -> tuple[list[tuple[float, Source]], FlightLog]:
    """Firings of the simulated module, and the flight it measured."""
    world = FlownWorld()
    world.fly(tilt, force)
    hardware = WitnessedHardware(world, memory)
    hardware.power_on(0.0)
    hardware.activate(is_active=True)
    hardware.advance((SAMPLES + 0.5) * SENSOR_PERIOD_S)
    assert len(world.sampled_s) == SAMPLES
    return hardware.fired, made_flight(tilt, force, time_s=world.sampled_s)


def test_the_simulated_module_and_the_analysis_agree() -> None:
    random = np.random.default_rng(1000)
    count = 0
    for _ in range(FLIGHTS):
        memory = Memory(
            attitude_threshold=int(random.integers(20, 120)),
            freefall_acceleration=int(random.integers(1, 10)),
            freefall_time=int(random.integers(0, 120)),
        )
        fired, log = module_fires(memory, *random_flight(random))
        limits = TriggerLimits(memory.attitude_threshold, memory.freefall_acceleration / 10, memory.freefall_time / 100)
        assert [(one.at_s, one.sources) for one in judge_flight(log, limits).firings] == fired
        first = firing_curves(log, RuleReading.DIRECT).first(limits)
        assert first == (fired[0] if fired else (np.inf, Source(0)))
        count += len(fired)
    assert count > FLIGHTS
