"""Which tests execute which line."""

import hashlib
import json
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from coverage import Coverage

from tests.mutants import FOLDERS, ROOT
from tests.mutants.changes import Mutant
from tests.mutants.processes import run_pytest, side_by_side

ROOMS = tuple(f"tests/{folder}" for folder in FOLDERS)
OTHERS = ("tests/app/*", "tests/faults", "tests/scenarios", "tests/ui/*")
"""Tests that run only on what those of the rooms do not catch: to record which lines they execute takes long."""
ROOM_BUDGET_S = 20
OTHERS_BUDGET_S = 20
"""The tests of a mutant's room and all other tests: fast ones of as many files as together take no longer."""
Batches = list[list[str]]
IMPORT = ""
"""Stands for a test that executes what importing a file executes."""


class TestMap:
    """Which tests execute which line, and how long each takes."""

    __test__ = False  # pytest

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))

    def add(self, test: str, seconds: float, lines: dict[str, list[int]]) -> None:
        """The lines are those of each file by its path."""
        self.seconds[test] = seconds
        for path, numbers in lines.items():
            for number in numbers:
                self._tests[path][number].add(test)

    def is_executed_by_import(self, mutant: Mutant) -> bool:
        """Also a function that runs while its file is imported, or for a test's parameters."""
        lines = self._tests[mutant.path]
        return not mutant.lines or any(IMPORT in lines.get(number, ()) for number in mutant.lines)

    def batches(self, mutant: Mutant) -> Batches:
        """The tests that execute a mutant, fastest first: those of its room, then the others."""
        room = f"tests/{Path(mutant.path).parent.as_posix()}/"
        found = {test for number in mutant.lines for test in self._tests[mutant.path].get(number, ())}
        if self.is_executed_by_import(mutant):
            found |= {test for test in self.seconds if test.startswith(room)}
            for path in _importing(mutant.path):
                found.update(*self._tests[path].values())
        found.discard(IMPORT)
        inside = {test for test in found if test.startswith(room)}
        batches = self._fastest(inside, ROOM_BUDGET_S), self._fastest(found - inside, OTHERS_BUDGET_S)
        return [batch for batch in batches if batch]

    def _fastest(self, tests: set[str], budget_s: float) -> list[str]:
        """The fastest case of each test, the fastest tests of each file first, then a second case of each, and so on
        within the budget; run file by file, as each file takes time to import."""
        cases, in_file = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
        for test in sorted(tests, key=lambda test: (self.seconds[test], test)):
            name = test.partition("[")[0]
            if name not in cases:
                in_file[test.partition("::")[0]].append(name)
            cases[name].append(test)
        places = {name: place for names in in_file.values() for place, name in enumerate(names)}
        rank = {test: (number, places[name]) for name, some in cases.items() for number, test in enumerate(some)}
        left_s, files = budget_s, defaultdict[str, list[str]](list)
        for test in sorted(tests, key=lambda test: (rank[test], self.seconds[test], test)):
            left_s -= self.seconds[test]
            if left_s >= 0:
                files[test.split("::")[0]].append(test)
        fastest_first = sorted(files.values(), key=lambda tests: sum(self.seconds[test] for test in tests))
        return [test for file in fastest_first for test in file]


def _importing(path: str) -> list[str]:
    """The file itself and the mutated ones that import it: where its constants are used."""
    module = path.removesuffix(".py").replace("/", ".")
    files = [file for folder in FOLDERS for file in sorted((ROOT / folder).rglob("*.py"))]
    importing = [file for file in files if f"from {module} import" in file.read_text(encoding="utf-8")]
    return [path, *(file.relative_to(ROOT).as_posix() for file in importing)]


def recorded_map(jobs: int, names: Sequence[str]) -> TestMap:
    """The map of the source as it is now and the tests in these folders; recorded where not yet in `build/mutants`."""
    place = ROOT / "build/mutants"
    place.mkdir(parents=True, exist_ok=True)
    files = {name: place / f"{name.replace('/', '-')}-{_digest(name)}.json" for name in names}
    missing = [(name, file) for name, file in files.items() if not file.exists()]
    for number, name in enumerate(side_by_side(jobs, _record, missing), 1):
        print(f"recorded {name} ({number} of {len(missing)})", flush=True)
    tests = TestMap()
    for file in files.values():
        for test, (seconds, lines) in json.loads(file.read_text(encoding="utf-8")).items():
            tests.add(test, seconds, lines)
    return tests


def other_folders() -> list[str]:
    folders = [folder for pattern in OTHERS for folder in sorted(ROOT.glob(pattern)) if folder.is_dir()]
    names = [folder.relative_to(ROOT).as_posix() for folder in folders if folder.name != "__pycache__"]
    return [name for name in names if name not in ROOMS]


def _digest(folder: str) -> str:
    """Changes with the program, what all tests share, and the tests of this folder."""
    paths = [
        path for name in ("protocol", "app", "ui", "tests/support", folder) for path in (ROOT / name).rglob("*.py")
    ]
    paths += (ROOT / "tests").glob("*.py")
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(paths))).hexdigest()[:16]


def _record(folder: str, target: Path) -> str:
    coverage = Coverage(data_file=None, config_file=False, include=[f"{ROOT}/{one}/*" for one in FOLDERS])
    recorder = _Recorder(coverage)
    coverage.start()
    ended = run_pytest([folder], recorder)
    coverage.stop()
    if ended not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"the tests of {folder} ended with {ended}")  # the map would lack tests
    data = coverage.get_data()
    recorder.seconds[IMPORT] = 0.0
    lines: dict[str, dict[str, list[int]]] = {test: {} for test in recorder.seconds.keys() - recorder.failed}
    for file in data.measured_files():
        path = Path(file).relative_to(ROOT).as_posix()
        for line, tests in data.contexts_by_lineno(file).items():
            for test in lines.keys() & set(tests):
                lines[test].setdefault(path, []).append(line)
    found = {test: (round(recorder.seconds[test], 4), executed) for test, executed in lines.items()}
    target.write_text(json.dumps(found), encoding="utf-8")
    return folder


class _Recorder:
    """Tells coverage which test runs, and measures the processor's time that it takes."""

    def __init__(self, coverage: Coverage) -> None:
        self._coverage = coverage
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._coverage.switch_context(item.nodeid)
        began = time.process_time()
        result = yield
        self.seconds[item.nodeid] = time.process_time() - began
        self._coverage.switch_context(IMPORT)
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.outcome != "passed":
            self.failed.add(report.nodeid)
