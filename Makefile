# Shortcuts for packaging/bootstrap.py, which works without make. Arguments: make test ARGS="-k frame"
PYTHON ?= python3
ARGS ?=

.PHONY: demo test check bench soak adversary mutants nightly package packages clean
demo test check bench soak adversary mutants nightly package clean:
	$(PYTHON) packaging/bootstrap.py $@ $(ARGS)

packages: package
