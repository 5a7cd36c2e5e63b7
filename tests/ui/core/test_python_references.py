"""PySide6 6.12 takes a reference from ``None`` at each void call on Python 3.11, until the process dies.

Counted in a process of its own, because a loss would end the process of the tests too.  From Python 3.12 on
both objects are immortal: their counts may fall, as extensions built for older Pythons do not know of it, and
nothing comes of that; there the process has to live on, and no more is asked.
"""

import os
import subprocess
import sys

REPEATS = 4000
LOSS_ALLOWED = REPEATS // 10
ARE_MORTAL = sys.version_info < (3, 12)

_PROGRAM = f"""
import sys
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication, QLabel

class Source(QObject):
    changed = Signal(bool)

application = QApplication(["references"])
label, source, heard = QLabel(), Source(), []
source.changed.connect(lambda is_on: heard.append(1))

def churn():
    for number in range({REPEATS}):
        label.setText(str(number))
        label.setEnabled(True)
        label.isEnabled()
        source.changed.emit(True)
        if number % 100 == 0:
            label.grab()
            application.processEvents()

keep = [None] * {REPEATS * 40}, [True] * {REPEATS * 40}  # a loss shall be counted, not end the process
before = sys.getrefcount(None), sys.getrefcount(True)
churn()
after = sys.getrefcount(None), sys.getrefcount(True)
print(len(heard), before[0] - after[0], before[1] - after[1])
"""


def test_none_and_true_keep_their_references() -> None:
    run = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", _PROGRAM],
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    heard, lost_none, lost_true = map(int, run.stdout.split())
    assert heard == REPEATS
    if ARE_MORTAL:
        assert lost_none < LOSS_ALLOWED, f"{lost_none} references to None were lost"
        assert lost_true < LOSS_ALLOWED, f"{lost_true} references to True were lost"
