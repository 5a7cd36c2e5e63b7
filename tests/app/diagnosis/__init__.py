"""Tests of app/diagnosis/."""
