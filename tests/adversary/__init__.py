"""A campaign against the program: every fault and lie of the simulated module with every command, checked against the
module's memory. See `python -m tests.adversary --help`."""
