"""Tests of app/flight_analysis/."""
