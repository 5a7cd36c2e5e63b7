"""Tests of app/text/."""
