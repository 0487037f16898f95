# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
#
# make demo       install into .venv and run the whole chain on simulated sensors
# make test       install into .venv and run everything that CI runs
# make test-pins  the tests with the versions of Ubuntu 24.04 (needs Python 3.12)
# make docs       write what docs and config repeat of the sources: settings, list of modules
# make format     sort imports and mend form
# make clean      remove what the others made
#
# Options: PYTHON=python3.12   the interpreter of .venv
#          PYTEST='-k pairing' passed to pytest

PYTHON ?= python3
PYTEST ?=
export PYTHON

BIN := .venv/bin
# An editable install follows the sources by itself, all but these.
INSTALLED := setup.py setup.cfg pyproject.toml heading_intercompare/core/version.py .ci/venv
# Of several kinds of Python 3.12, the first that starts; pyenv hides its own behind PYENV_VERSION.
PYTHON312 := $(shell for p in python3.12 "$$(pyenv prefix 3.12 2>/dev/null)/bin/python3.12"; do \
	"$$p" -c 'import ensurepip, venv' 2>/dev/null && command -v "$$p" && break; done)

.PHONY: demo test test-pins docs format clean help

help:
	@sed -n 's/^# make/make/p' Makefile

demo: .venv/.demo
	@echo '== heading-intercompare demo --out demo_out'
	$(BIN)/heading-intercompare demo --out demo_out

test: .venv/.test
	@echo '== 1/3 form'
	$(BIN)/ruff check .
	@if $(BIN)/python -c 'import numpy; numpy.strings.slice' 2>/dev/null; \
		then echo '$(BIN)/mypy' && $(BIN)/mypy; \
		else echo 'types left out: they are checked with numpy 2.3 or later'; fi
	@echo '== 2/3 tests, examples in docstrings, installation with pip and with colcon'
	$(BIN)/python -m pytest --durations=10 $(PYTEST)
ifeq ($(PYTHON312),)
	@echo '== 3/3 left out: the tests with the versions of Ubuntu 24.04 need Python 3.12'
else
	@echo '== 3/3 the quick tests with the versions of Ubuntu 24.04'
	@$(MAKE) --no-print-directory test-pins
endif

test-pins: .venv-pins/.test
	@echo '== tests with the versions of Ubuntu 24.04'
	.venv-pins/bin/python -m pytest -m 'not slow or colcon' $(PYTEST)

docs: .venv/.test
	$(BIN)/python docs/generate.py

format: .venv/.test
	$(BIN)/ruff check --fix .

.venv/.demo: $(INSTALLED)
	@.ci/venv .venv ros,serial,fast
	@touch $@

.venv/.test: $(INSTALLED)
	@.ci/venv .venv ros,serial,fast,dask,test,dev
	@touch $@ .venv/.demo

.venv-pins/.test: $(INSTALLED) .ci/ubuntu-24.04.txt
	@test -n '$(PYTHON312)' || { echo 'error: python3.12 with venv is not here' >&2; exit 1; }
	@PYTHON='$(PYTHON312)' PIP_CONSTRAINT=.ci/ubuntu-24.04.txt \
		.ci/venv .venv-pins ros,serial,fast,dask,test,dev
	@touch $@

clean:
	rm -rf .venv .venv-pins build install log demo_out *.egg-info .pytest_cache .hypothesis \
		.ruff_cache .mypy_cache
