"""Tests of app/flight_logs/."""
