"""The window around the pages: top bar, sidebar, status bar, notifications, shutdown."""
