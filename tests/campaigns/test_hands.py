"""No careless gesture completes an act, whatever happens meanwhile; `make hands` tries many more."""

import datetime
import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication

from tests.campaigns.hands import WHOLE, Hands, Report, at_the_window, run
from tests.campaigns.ledger import ENABLED
from tests.support.thorough import IS_THOROUGH

SEQUENCES = 2000 if IS_THOROUGH else 30


@pytest.fixture
def hands(qapp: QApplication, tmp_path: Path) -> Iterator[Hands]:
    with at_the_window(qapp, tmp_path, Report(), random.Random(1)) as hands:
        yield hands


@pytest.mark.parametrize("name", WHOLE)
@pytest.mark.promise("d")
def test_a_whole_gesture_completes_each_once(name: str, hands: Hands) -> None:
    """Without that the others would prove nothing."""
    act, leaves = WHOLE[name]
    act(hands)
    hands.wait(9.0 if leaves is ENABLED else 3.0)
    left = {kind: count for kind, count in hands.report.frames.items() if kind not in ("LOCK", "write")}
    assert left == dict.fromkeys(leaves, 1)
    assert hands.report.faults == []


@pytest.mark.promise("d", "i")
def test_nothing_leaves_a_window_but_what_hands_completed(qapp: QApplication) -> None:
    """Other hands each day."""
    seed = datetime.datetime.now(datetime.UTC).date().toordinal()
    assert run(qapp, SEQUENCES, seed).faults == [], f"seed {seed}"
