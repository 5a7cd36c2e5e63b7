"""Tests of app/preflight/."""
