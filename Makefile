# Everything a newcomer needs:
#   make run    set up, run every table and figure of the paper, write the page with all of them
#   make quick  like make run, with a tenth of the periods, for a first look
#   make multiverse  like make run, and under what each claim of the paper holds: every reading, measure and limit
#   make test   set up, then lint, types and tests
#   make ui     open the MLflow UI on the recorded runs
#   make bench  set up with other implementations, then measure ours against them

PYTHON  ?= python3
VENV    ?= .venv
BIN     := $(VENV)/bin

export MLFLOW_DISABLE_TELEMETRY := true

.PHONY: help run quick multiverse test ui bench peers lint schemas lock clean
.DEFAULT_GOAL := help

help:
	@sed -n 's/^#   //p' Makefile

run: $(VENV)/.run
	$(BIN)/rl-design-space study=paper
	$(BIN)/rl-design-report all >/dev/null
	@echo "The page is outputs/report/index.html; the learning curves are in MLflow: make ui"

quick: $(VENV)/.run
	$(BIN)/rl-design-space study=paper task.periods=50 outputs=outputs/quick
	$(BIN)/rl-design-report all task.periods=50 outputs=outputs/quick >/dev/null
	@echo "The page is outputs/quick/report/index.html"

multiverse: $(VENV)/.run
	$(BIN)/rl-design-space study=paper,multiverse,claims_precise
	$(BIN)/rl-design-report multiverse >/dev/null
	$(BIN)/rl-design-report all >/dev/null
	@echo "The page is outputs/report/index.html, with the multiverse of the claims"

# Every command of a test reads the same modules, so their bytecode is kept whatever the user's environment says.
test: export PYTHONDONTWRITEBYTECODE :=
test: lint
	$(BIN)/python -m pytest -n 3

lint: schemas
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

# What editors know of conf/ follows from its files and from the classes that they name.
schemas: $(VENV)/.test
	$(BIN)/python -m rl_design_space.catalogue.schemas

ui: $(VENV)/.run
	$(BIN)/rl-design-space ui

bench: peers
	$(BIN)/python -m benchmarks

peers: $(VENV)/.bench

# A stamp records that the virtual environment holds what its lock file lists.
$(VENV)/.run: requirements.txt pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --no-deps --require-hashes -r requirements.txt
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/.test: requirements-test.txt $(VENV)/.run
	$(BIN)/python -m pip install --quiet --no-deps --require-hashes -r requirements-test.txt
	@touch $@

$(VENV)/.bench: requirements-bench.txt $(VENV)/.run
	$(BIN)/python -m pip install --quiet --no-deps --require-hashes -r requirements-bench.txt
	@touch $@

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "error: Python 3.11 or later is needed; name one with: make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
	  { echo "error: this Python cannot make virtual environments; on Debian: apt-get install python3-venv"; exit 1; }
	$(PYTHON) -m venv $(VENV)

# Exact versions with hashes, for every platform and Python version that pyproject.toml allows. Needs uv.
UV_COMPILE = echo 'hatchling>=1.27,<2' | uv pip compile pyproject.toml - --universal --generate-hashes --quiet \
  --no-emit-index-url --no-annotate --custom-compile-command 'make lock'
lock:
	$(UV_COMPILE) --output-file requirements.txt
	$(UV_COMPILE) --constraint requirements.txt --extra test --output-file requirements-test.txt
	$(UV_COMPILE) --constraint requirements.txt --extra bench --output-file requirements-bench.txt

clean:
	rm -rf $(VENV) .import_linter_cache .mypy_cache .pytest_cache .ruff_cache build dist
