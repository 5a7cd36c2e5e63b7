# Shortcuts for packaging/bootstrap.py, which works without make. Arguments: make test ARGS="-k frame"
PYTHON ?= python3
ARGS ?=
CAMPAIGN = QT_QPA_PLATFORM=offscreen .venv/bin/python -m

.PHONY: demo test check setup translations package bench soak hands walk lines readers nightly
demo test check setup translations package:
	$(PYTHON) packaging/bootstrap.py $@ $(ARGS)

# Campaigns, which take minutes to hours.
bench: setup
	$(CAMPAIGN) tests.bench $(ARGS)
readers: setup
	$(CAMPAIGN) tests.files.readers $(ARGS)
hands lines soak walk: setup
	$(CAMPAIGN) tests.campaigns $@ $(ARGS)

# All tests with all that they otherwise take a part of, then all campaigns, whatever fails before.
nightly: setup
	failed=0; \
	HYPOTHESIS_PROFILE=thorough $(PYTHON) packaging/bootstrap.py test || failed=1; \
	$(CAMPAIGN) tests.campaigns soak --seconds 1800 || failed=1; \
	$(CAMPAIGN) tests.campaigns hands --rounds 2000 || failed=1; \
	$(CAMPAIGN) tests.campaigns walk --rounds 100 || failed=1; \
	$(CAMPAIGN) tests.files.readers || failed=1; \
	$(CAMPAIGN) tests.bench || failed=1; \
	exit $$failed
