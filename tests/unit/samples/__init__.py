"""Tests of app/samples/."""
