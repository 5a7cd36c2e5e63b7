"""The simulated module: its memory, its world, its line and the ports that it is offered on."""
