"""Explains a port error or a silent module with the table of `app.diagnosis.causes`."""

import sys

from app.diagnosis.causes import Explanation, diagnose
from app.diagnosis.symptoms import PortEvidence
from app.engine.procedure import Slept
from app.engine.transport import PortError
from app.procedures.handshake import NoAnswer
from app.text.i18n import tr


def explain(error: Exception) -> Explanation:
    """Explains a `PortError`, `NoAnswer` or `Slept`; any other error is reported as unexpected."""
    evidence = None
    if isinstance(error, PortError):
        evidence = PortEvidence(port=error.port, trouble=error, platform=sys.platform)
    elif isinstance(error, NoAnswer):
        evidence = PortEvidence(port=error.port, baud_rate=error.baud_rate, silence=error.silence)
    found = None if evidence is None else diagnose(evidence)
    if found is not None:
        return found
    if isinstance(error, Slept):
        return Explanation(tr("The computer slept; the operation was cancelled."), tr("Try again"))
    return Explanation(
        tr("Unexpected error: {error}.", error=error),
        tr("Connect again. If it fails, save a support bundle (Diagnosis)."),
    )
