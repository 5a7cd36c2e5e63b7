"""Tests of the packages, built and run by `python3 packaging/bootstrap.py package`."""
