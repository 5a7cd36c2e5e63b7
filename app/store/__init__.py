"""What outlives the program: one SQLite file in the platform's folder for data. See `app.store.database`."""
