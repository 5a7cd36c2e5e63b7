"""Tests of app/cli/reference."""
