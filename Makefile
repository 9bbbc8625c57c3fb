# Everything a newcomer needs: `make convergence` runs the main job, `make test` passes.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
# One process a core with one thread each.
THREADS ?= 1
BENCH := $(VENV)/.bench
ONLY_THREADS := OMP_NUM_THREADS=$(THREADS) MKL_NUM_THREADS=$(THREADS) OPENBLAS_NUM_THREADS=1
PYTEST := OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadfile

.DEFAULT_GOAL := help
.PHONY: help env convergence convergence-full paper schemes report check judge-report mutants rough-starts test test-quick lint docs clean \
  bench bench-compare bench-reactions bench-million

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

env: $(INSTALLED)  ## create .venv and install the package with its pinned dependencies

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "needs Python >= 3.11, but $(PYTHON) is older or missing; try: make PYTHON=python3.11 env" >&2; exit 2; }
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || { rm -rf $(VENV); $(PYTHON) -m venv $(VENV); } || \
	  { rm -rf $(VENV); echo "cannot create $(VENV): on Debian and Ubuntu install python3-venv" >&2; exit 2; }
	@echo "installing the package and its dependencies into $(VENV) (once, about a minute) ..."
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

convergence: $(INSTALLED)  ## run the default studies: rate tables, plots and verdicts below results/runs
	@$(BIN)/esfem run

convergence-full: $(INSTALLED)  ## the default studies and those below harness/studies/full
	@$(BIN)/esfem run --all

# `make env` installs pyvista with the extra [pictures]; without it the surfaces are not drawn.
paper: $(INSTALLED)  ## the paper's section 7: its figures, tables, and sentences, checked: results/paper
	@$(BIN)/esfem paper

schemes: $(INSTALLED)  ## Dziuk's and BGN's scheme beside this one, mean curvature flow: results/schemes
	@$(BIN)/esfem schemes

check: $(INSTALLED)  ## run what has a baseline and compare: verdicts, orders, errors; JUnit in results/runs/check.xml
	@$(BIN)/esfem check --junit results/runs/check.xml

DIR ?= results/runs
report: $(INSTALLED)  ## one HTML file, LaTeX and data of the results in DIR=results/runs: DIR/report
	@$(BIN)/esfem report $(DIR)

judge-report: $(INSTALLED)  ## the judge, judged on tables of known order: results/judge
	@OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 $(BIN)/esfem judge-report

rough-starts: $(INSTALLED)  ## the order in time where the first moments are fast: results/rough-starts
	@OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/esfem rough-starts

mutants: $(INSTALLED)  ## seeded bugs in the solver, and the studies that catch them: results/mutants
	@OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 $(BIN)/esfem mutants

test: $(INSTALLED)  ## the whole test suite
	@$(PYTEST)

test-quick: $(INSTALLED)  ## the tests that take no more than a few seconds each
	@$(PYTEST) -m "not slow"

$(BENCH): $(INSTALLED)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	@touch $@

bench: $(BENCH)  ## times and ratios to the textbook way: results/bench/latest.json (THREADS=1)
	@mkdir -p results/bench
	@$(ONLY_THREADS) $(BIN)/python -m pytest benchmarks -o filterwarnings=default --benchmark-columns=min,median \
	  $(if $(filter 1,$(THREADS)),--benchmark-timer=time.process_time) --benchmark-max-time=0.5 --benchmark-min-rounds=3 --benchmark-json=results/bench/latest.json

bench-compare: $(BENCH)  ## the ratios of latest.json against the committed baseline.json
	@$(BIN)/python -m benchmarks.compare results/bench/latest.json results/bench/baseline.json

bench-reactions: $(INSTALLED)  ## implicit, extrapolated, linearised: errors, costs, stability: results/bench/reactions-*.csv
	@$(ONLY_THREADS) $(BIN)/python -m benchmarks.reactions

bench-million: $(BENCH)  ## one step with a million nodes: seconds and memory
	@$(ONLY_THREADS) $(BIN)/python -m benchmarks.million

lint: $(INSTALLED)  ## ruff: lint and format check; mypy: types; import-linter: which room imports which
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/python tests/helpers/links.py build/types
	@$(BIN)/mypy
	@PYTHONPATH=build/types $(BIN)/lint-imports --no-logo --cache-dir build/imports

docs: $(INSTALLED)  ## the pages of docs and the Python API as HTML: docs/_build/html/index.html
	@$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html

clean:  ## remove .venv and caches; results stay
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis build docs/_build *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
