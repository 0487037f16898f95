# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
#
# make demo       install into .venv and run the whole chain on simulated sensors
# make quick      form, and the tests that need neither ROS nor other processes: while you work
# make test       install into .venv and run everything that CI runs
# make coverage   which lines of the package the quick tests run
# make release    all checks before a release: hours of fuzz, and the tables of the decision rule
# make test-pins  the tests with the versions of Ubuntu 24.04 (needs Python 3.12)
# make sbom       the libraries with versions and licences, as CycloneDX: build/sbom.cdx.json
# make docs       write what docs and config repeat from the sources, and build the site: docs/_build
# make format     sort imports and repair the form
# make clean      remove everything that the others made
#
# Options: PYTHON=python3.12   the interpreter of .venv
#          PYTEST='-k pairing' passed to pytest

PYTHON ?= python3
PYTEST ?=
PINNED ?=
export PYTHON
# Some containers set it: each of the hundreds of processes of the tests would compile all sources.
unexport PYTHONDONTWRITEBYTECODE

BIN := .venv/bin
# An editable install follows all sources but these.
INSTALLED := setup.py setup.cfg pyproject.toml heading_intercompare/core/version.py .ci/venv
# The first Python 3.12 that starts; pyenv runs its own only if PYENV_VERSION selects it.
PYTHON312 := $(shell for p in python3.12 "$$(pyenv prefix 3.12 2>/dev/null)/bin/python3.12"; do \
	"$$p" -c 'import ensurepip, venv' 2>/dev/null && command -v "$$p" && break; done)

# For two cores: two workers for the tests that run graphs, which mostly wait, and two that yield to
# them (conftest.py).
WORKERS ?= 4
# Of the quick tests those that show what versions change: figures, bytes, readers, one whole path.
OF_VERSIONS := $(addprefix test/,$(addprefix core/,statistics timing pairing decision verdict \
	test_pipeline.py) messages readers bags/mcap app/test_analysis.py cli/test_what_binds.py \
	report/figures test_packaging.py)
TESTS := -m pytest --numprocesses $(WORKERS) --dist loadscope --no-loadscope-reorder
SITE := $(BIN)/python -m sphinx --fail-on-warning --keep-going -q -b html -d build/doctrees docs docs/_build
TABLES := A B E cells gaps drift rates runs means looks open short

.PHONY: demo quick test test-pins coverage release addresses sbom docs format clean help

help:
	@sed -n 's/^# make/make/p' Makefile

demo: .venv/.demo
	@echo '== heading-intercompare demo --out demo_out --web :0'
	$(BIN)/heading-intercompare demo --out demo_out --web :0

quick: .venv/.test
	@.ci/step form $(BIN)/ruff check .
	@.ci/step 'quick tests' $(BIN)/python $(TESTS) -q -m 'not (slow or ros or process)' $(if $(filter test%,$(PYTEST)),,test) $(PYTEST)

test: .venv/.test
ifneq ($(PYTHON312),)
	@# The environment of part 5 is made meanwhile; if that fails, part 5 says why.
	@nice -n 10 $(MAKE) --no-print-directory .venv-pins/.test >/dev/null 2>&1 &
endif
	@.ci/step '1/5 form' $(BIN)/ruff check .
	@# One core each.
	@if $(BIN)/python -c 'import numpy; numpy.strings.slice' 2>/dev/null; \
		then .ci/step '2/5 types' $(BIN)/mypy; \
		else echo '== 2/5 left out: types are checked with numpy 2.3 or later'; fi & types=$$!; \
	.ci/step '3/5 documentation' $(SITE); site=$$?; wait $$types && exit $$site
	@.ci/step '4/5 tests, examples in docstrings, installation with pip and with colcon' \
		$(BIN)/python $(TESTS) -m 'not endurance' --durations=10 $(PYTEST)
ifeq ($(PYTHON312),)
	@echo '== 5/5 left out: the tests with the versions of Ubuntu 24.04 need Python 3.12'
else
	@.ci/step '5/5 quick tests with the versions of Ubuntu 24.04' \
		$(MAKE) --no-print-directory test-pins PINNED='$(OF_VERSIONS)'
endif

# Apart from the other tests, which it would slow down by more than half.
coverage: .venv/.test
	$(BIN)/python $(TESTS) -q -m 'not (slow or ros or process)' --cov=heading_intercompare \
		--cov-report=term:skip-covered $(if $(filter test%,$(PYTEST)),,test) $(PYTEST)

# What tests say of the sources does not depend on versions.
test-pins: .venv-pins/.test
	HYPOTHESIS_PROFILE=pins .venv-pins/bin/python $(TESTS) -m 'not (slow or ros or process) or colcon' \
		$(addprefix --ignore=test/test_,architecture.py plain_english.py ament_lint.py benchmarks.py) \
		$(if $(filter test%,$(PYTEST)),,$(PINNED)) $(PYTEST)

release: addresses test
	@.ci/step 'tests that take long' $(BIN)/python $(TESTS) -m endurance
	@.ci/step 'all quick tests with the versions of Ubuntu 24.04' $(MAKE) --no-print-directory test-pins
	@.ci/step 'nodes with the versions of Ubuntu 24.04' .venv-pins/bin/python $(TESTS) -m 'not slow' test/nodes
	@.ci/step 'large fuzz' env HYPOTHESIS_PROFILE=release $(BIN)/python $(TESTS) test/bags test/nodes
	@.ci/venv .venv ros,serial,report,pdf,terminal,fast,dask,docs,test,browser,dev,notebook
	@.ci/step 'notebooks' $(BIN)/jupyter execute examples/*.ipynb
	@.ci/step 'soaks of 30 min, without faults and with' env HEADING_INTERCOMPARE_SOAK_S=1800 \
		$(BIN)/python -m pytest test/nodes/test_soak.py test/nodes/test_soak_with_faults.py
	@for table in $(TABLES); do \
		.ci/step "table $$table of the decision rule" \
			$(BIN)/python benchmarks/decision_risk.py --keep --table $$table --jobs $(WORKERS) || exit 1; done
	@.ci/step 'interpolation' $(BIN)/python benchmarks/interpolation.py --keep --replications 5000
	@.ci/step 'sensors of one source' $(BIN)/python benchmarks/same_source.py --keep
	@.ci/step 'pairs of sound sensors' $(BIN)/python benchmarks/sound_pairs.py --keep --jobs $(WORKERS)

# First: a release without the addresses of its owner is none.
addresses:
	@.ci/step 'addresses of the owner' $(PYTHON) .ci/addresses

# Of the package with the extras that a ship installs.
sbom: .venv/.demo
	@.ci/venv .venv-sbom serial,report,pdf,terminal,web,push,fast,bags,parquet,sun
	@.ci/venv .venv sbom
	@mkdir -p build
	$(BIN)/cyclonedx-py environment --output-reproducible -o build/sbom.cdx.json .venv-sbom/bin/python

docs: .venv/.test
	$(BIN)/python docs/generate.py
	$(BIN)/python docs/house.py
	$(SITE)
	@echo '== docs/_build/index.html'

format: .venv/.test
	$(BIN)/ruff check --fix .

.venv/.demo: $(INSTALLED)
	@.ci/venv .venv ros,serial,report,terminal,fast,web
	@touch $@

.venv/.test: $(INSTALLED)
	@.ci/venv .venv ros,serial,report,pdf,terminal,fast,dask,docs,test,browser,dev
	@touch $@ .venv/.demo

.venv-pins/.test: $(INSTALLED) .ci/ubuntu-24.04.txt
	@test -n '$(PYTHON312)' || { echo 'error: python3.12 with venv is not installed' >&2; exit 1; }
	@PYTHON='$(PYTHON312)' PIP_CONSTRAINT=.ci/ubuntu-24.04.txt \
		.ci/venv .venv-pins ros,serial,report,terminal,fast,dask,test,dev
	@touch $@

clean:
	rm -rf docs/_build docs/reference/api docs/reference/commands.md .venv .venv-pins .venv-sbom build install log demo_out *.egg-info .pytest_cache .hypothesis \
		.ruff_cache .mypy_cache .coverage
