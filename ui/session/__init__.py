"""What the window knows of the ports and of the modules at them."""
