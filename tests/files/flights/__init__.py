"""Tests of app/flights/."""
