"""Tests of what people install: `python3 packaging/bootstrap.py package` builds the packages and runs these."""
