"""The pre-flight check and its records."""
