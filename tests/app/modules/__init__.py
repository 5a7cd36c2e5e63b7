"""Tests of app/modules/."""
