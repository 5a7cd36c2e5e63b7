"""The Qt side without widgets: bridge, list of the ports, preferences, work in the background."""
