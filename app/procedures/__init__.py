"""What takes several exchanges with the module, each as a generator: see `app.procedure`."""
