"""The Qt side without widgets: bridge, connection, preferences, what a page is given."""
