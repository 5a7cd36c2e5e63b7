"""Tests of app/records/."""
