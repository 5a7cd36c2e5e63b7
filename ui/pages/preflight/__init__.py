"""The pre-flight check, its records, and the guided tests."""
