"""Tests of app/trigger_records/."""
