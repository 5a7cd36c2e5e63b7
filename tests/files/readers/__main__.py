"""`make readers`: the readers of flight logs against pyulog and pymavlink, whose 105 MB the tests do not install.

Whole logs must give the same values. Of a damaged ULog ours must keep every sample that pyulog keeps.
"""

import importlib
import tempfile
from pathlib import Path

import numpy as np

from app.flights.autopilots import DataflashFile, UlogFile, read_telemetry
from tests.support.flights import log_bytes as made

LOGS = 300
TOPICS = {
    "vehicle_attitude": [f"q[{number}]" for number in range(4)],
    "sensor_combined": [f"accelerometer_m_s2[{axis}]" for axis in range(3)],
}
Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def made_flight(random: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Times, tilts and accelerations of a random flight of up to 20 s."""
    times = 100 + np.cumsum(random.uniform(0.005, 0.05, int(random.integers(50, 800))))
    tilt = np.abs(np.cumsum(random.normal(0, 3, len(times)))) % 180
    force = np.abs(1 + np.cumsum(random.normal(0, 0.05, len(times))))
    return times, tilt, force


def ulog_columns(data: bytes) -> dict[str, Floats]:
    """All values of each topic by our reader, a row for each sample."""
    found: dict[str, Floats] = {}
    for name, (topic, *_) in UlogFile(data).topics.items():
        if name in TOPICS and "time" in topic:
            found[name] = np.column_stack([topic[column] for column in ("time", *TOPICS[name])])
    return found


def pyulog_columns(path: Path) -> dict[str, Floats]:
    pyulog = importlib.import_module("pyulog")
    found: dict[str, Floats] = {}
    for topic in pyulog.ULog(str(path)).data_list:
        if topic.name in TOPICS:
            time_s = topic.data["timestamp"] * 1e-6
            columns = [topic.data[name].astype(np.float64) for name in TOPICS[topic.name]]
            found[topic.name] = np.column_stack([time_s, *columns])
    return found


def compare_ulog(random: np.random.Generator, folder: Path) -> None:
    times, tilt, force = made_flight(random)
    data = made.ulog_bytes(times, tilt, force)
    path = folder / "log.ulg"
    path.write_bytes(data)
    ours, theirs = ulog_columns(data), pyulog_columns(path)
    assert ours.keys() == theirs.keys() == TOPICS.keys()
    for name in TOPICS:
        assert np.array_equal(ours[name], theirs[name]), name
    damaged = bytearray(data)
    begin = int(random.integers(len(data) // 4, len(data) - 100))
    damaged[begin : begin + int(random.integers(1, 60))] = random.bytes(int(random.integers(1, 60)))
    path.write_bytes(damaged)
    kept = ulog_columns(bytes(damaged))
    for name, rows in pyulog_columns(path).items():
        whole = {row.tobytes() for row in ours[name]}
        lost = {row.tobytes() for row in rows} & whole - {row.tobytes() for row in kept[name]}
        assert not lost, f"{name}: {len(lost)} samples that pyulog keeps"


def dataflash_reader_columns(path: Path, table: str, names: tuple[str, ...]) -> Floats:
    readers = importlib.import_module("pymavlink.DFReader")
    reader = readers.DFReader_text(str(path)) if path.suffix == ".log" else readers.DFReader_binary(str(path))
    rows = []
    while (found := reader.recv_match(type=[table])) is not None:
        rows.append([float(getattr(found, name)) for name in names])
    return np.array(rows)


def compare_dataflash(random: np.random.Generator, folder: Path) -> None:
    times, tilt, force = made_flight(random)
    binary, text = made.dataflash_bytes(times, tilt, force), made.dataflash_text(times, tilt, force)
    for name, data in (("log.bin", binary), ("log.log", text)):
        path = folder / name
        path.write_bytes(data)
        for table, labels in (("ATT", ("TimeUS", "Roll", "Pitch")), ("IMU", ("TimeUS", "AccX", "AccY", "AccZ"))):
            ours = np.column_stack([DataflashFile(data).tables[table][0][label] for label in labels])
            theirs = dataflash_reader_columns(path, table, labels)
            assert ours.shape == theirs.shape, (name, table)
            assert np.allclose(ours, theirs, rtol=1e-6, atol=1e-6), (name, table)


def compare_telemetry(random: np.random.Generator, folder: Path) -> None:
    mavutil = importlib.import_module("pymavlink.mavutil")
    times, tilt, force = made_flight(random)
    version = int(random.integers(1, 3))
    path = folder / "log.tlog"
    path.write_bytes(made.telemetry_bytes(times, tilt, force, version=version))
    raw = read_telemetry(path.read_bytes())
    link = mavutil.mavlink_connection(str(path))
    attitudes, forces = [], []
    while (found := link.recv_match(type=["ATTITUDE", "RAW_IMU"])) is not None:
        if found.get_type() == "ATTITUDE":
            attitudes.append((found.time_boot_ms * 1e-3, np.degrees(abs(found.roll))))
        else:
            length_g = np.sqrt(found.xacc**2 + found.yacc**2 + found.zacc**2) * 1e-3
            forces.append((found.time_usec * 1e-6, length_g))
    for channel, theirs in ((raw.tilts_deg[0], attitudes), (raw.forces_g[0], forces)):
        ours = np.column_stack(channel)
        expected = np.array(theirs)
        assert ours.shape == expected.shape
        assert np.allclose(ours[:, 0], expected[:, 0], atol=1e-6)
        # A tilt above 180° does not exist: a roll of 181° is a tilt of 179°.
        assert np.allclose(np.cos(np.radians(ours[:, 1])), np.cos(np.radians(expected[:, 1])), atol=1e-4)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for number in range(LOGS):
            random = np.random.default_rng(number)
            for compare in (compare_ulog, compare_dataflash, compare_telemetry):
                compare(random, Path(folder))
    print(f"{LOGS} logs of each kind: the same values as pyulog and pymavlink.")


if __name__ == "__main__":
    main()
