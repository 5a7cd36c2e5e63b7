"""Reads flights measured by a module: sessions recorded by this program."""

from pathlib import Path

import numpy as np

from app.flight_logs.assembly import Reports, flight_of_reports
from app.flight_logs.flight_log import FlightLog, LogFormat, unreadable
from app.recordings.library import entry_of
from app.recordings.markers import STATE_LOST
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked


def read_session(path: Path) -> FlightLog:
    """Raises `UserError`."""
    from app.recordings.recording import open_recording

    entry = entry_of(path)
    try:
        with open_recording(entry) as recording:
            excerpt = recording.excerpt(recording.start_s, recording.end_s)
            reports = Reports(
                np.array(excerpt.time_s, np.float64),
                np.array(excerpt.tilt_deg, np.float64),
                np.array(excerpt.acceleration_g, np.float64),
                tuple(marker.time_s for marker in excerpt.markers if marker.kind in STATE_LOST),
            )
            problems = [] if recording.damage is None else [recording.damage]
    except UserError as error:
        cause = error.__cause__
        raise unreadable(str(cause) if isinstance(cause, UserError) else marked("cannot be read")) from error
    if entry.was_cut_off:
        problems.append(message(marked("cut off")))
    return flight_of_reports(str(path), LogFormat.RECORDING, reports, problems)
