"""Tests of app/port_urls/."""
