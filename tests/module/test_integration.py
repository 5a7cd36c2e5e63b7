"""The door for other programs, against the independent module; the examples of its page are tried with the page."""

import sys

import pytest

from app.integration import opened
from tests.module.line import Line, now
from tests.module.module import ATTITUDE, FREEFALL_OFF, Module
from tests.module.options import Options

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


@pytest.mark.promise("g")
def test_what_takes_protection_away_is_sent_only_where_that_was_accepted() -> None:
    module = Module(Options(), now=now())
    with Line(module) as line, opened(line.port) as opened_module:
        refused = opened_module.write(attitude_threshold_deg=30, freefall_trigger=False)
        assert not refused.is_fine
        assert module.log.sets(ATTITUDE) == module.log.sets(FREEFALL_OFF) == []
        written = opened_module.write(accepts_risk=True, attitude_threshold_deg=30)
        assert written.is_fine
        assert module.settings[ATTITUDE] == 30
        with pytest.raises(KeyError):
            opened_module.write(baud=9600)
    assert module.log.acts() == []
