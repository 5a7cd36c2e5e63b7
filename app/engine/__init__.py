"""One open port and what is known about the module on it."""
