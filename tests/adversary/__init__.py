"""A campaign against the program: every fault and lie of the simulated module, every command, and a judge who knows the
module's own memory. See `python -m tests.adversary --help`."""
