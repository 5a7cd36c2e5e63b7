"""All pre-flight checks, in the order of the page."""

from app.preflight.findings import Check
from app.preflight.line_checks import LINE_CHECKS
from app.preflight.module_checks import MODULE_CHECKS

CHECKS: tuple[Check, ...] = (*LINE_CHECKS, *MODULE_CHECKS)
