# Shortcuts for packaging/bootstrap.py, which works without make. Arguments: make test ARGS="-k frame"
PYTHON ?= python3
ARGS ?=
THOROUGH = HYPOTHESIS_PROFILE=thorough $(PYTHON) packaging/bootstrap.py test -o faulthandler_timeout=7200
CAMPAIGN = QT_QPA_PLATFORM=offscreen .venv/bin/python -m
READERS = .venv/bin/python -m pip install --quiet pyulog pymavlink && $(CAMPAIGN) tests.files.readers

.PHONY: demo test check setup translations package bench soak hands walk readers nightly
demo test check setup translations package:
	$(PYTHON) packaging/bootstrap.py $@ $(ARGS)

# Campaigns, which take minutes to hours.
bench: setup
	$(CAMPAIGN) tests.bench $(ARGS)
readers: setup
	$(READERS)
soak: setup
	$(CAMPAIGN) tests.campaigns.soak 1800
hands walk: setup
	$(THOROUGH) tests/campaigns/test_$@.py $(ARGS)

# All tests with all that they otherwise take a part of, then what is no test, whatever fails before.
nightly: setup
	failed=0; \
	$(THOROUGH) || failed=1; \
	$(CAMPAIGN) tests.campaigns.soak 1800 || failed=1; \
	$(READERS) || failed=1; \
	$(CAMPAIGN) tests.bench || failed=1; \
	exit $$failed
