# Shortcuts for packaging/bootstrap.py, which works without make. Arguments: make test ARGS="-k frame"
PYTHON ?= python3
ARGS ?=

.PHONY: demo test check bench soak gestures adversary nightly package packages
demo test check bench soak gestures adversary nightly package:
	$(PYTHON) packaging/bootstrap.py $@ $(ARGS)

packages: package
