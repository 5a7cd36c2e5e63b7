"""Fit to fly? Checks, evidence, verdict, record, report."""
