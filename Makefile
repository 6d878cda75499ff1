# Every target makes its own .venv from Python 3.11 or newer (PYTHON=python3.12 make demo picks another one), and installs
# into it what it needs, nothing else.
PYTHON ?= python3
PYTEST_ARGS ?=
PYTEST_WORKERS ?= 2
BENCH_ARGS ?=
FUZZ_ARGS ?=
VENV := .venv
BIN := $(VENV)/bin
DEMO := runs/sort_coins
PIP = $(BIN)/python -m pip --disable-pip-version-check
INSTALL = $(PIP) install --quiet -c constraints.txt -e

# The tests start a hundred programs: without its bytecode each of them takes a third of a second longer.
unexport PYTHONDONTWRITEBYTECODE

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help demo test oracle check fuzz bench docs wheel clean

help:
	@echo "make demo    a Puma 560 sorts the coins it sees in a photograph; writes $(DEMO)/report.html"
	@echo "make test    lint, types, layers, then every test in two processes (PYTEST_ARGS='-k ik' narrows them, PYTEST_WORKERS=0: one process)"
	@echo "make check   lint, types and layers only"
	@echo "make fuzz    every reader of files against damaged inputs (FUZZ_ARGS='cell --count 1000' narrows them)"
	@echo "make oracle  the same quantities by peer libraries, and every benchmark once, small"
	@echo "make bench   speed beside the peer libraries"
	@echo "make docs    HTML documentation in docs/_build/html"
	@echo "make wheel   the wheel in dist/, installed from nothing and used: its demo, a new cell"
	@echo "make clean   removes .venv, caches and builds (runs/ stays)"

demo: $(VENV)/demo.stamp
	$(BIN)/holonom run examples/01_sort_coins/cell.toml -o $(DEMO)
	@echo "Report: file://$(CURDIR)/$(DEMO)/report.html"

test: check $(VENV)/test.stamp
	$(BIN)/python -m pytest -m 'not oracle' -n $(PYTEST_WORKERS) --dist loadfile $(PYTEST_ARGS)

oracle: $(VENV)/oracle.stamp
	$(BIN)/python -m pytest -m oracle $(PYTEST_ARGS)

check: $(VENV)/check.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

fuzz: $(VENV)/test.stamp
	$(BIN)/python fuzz/run.py $(FUZZ_ARGS)

bench: $(VENV)/oracle.stamp
	$(BIN)/holonom bench $(BENCH_ARGS)

docs: $(VENV)/docs.stamp
	$(BIN)/sphinx-build -q -W --keep-going docs docs/_build/html
	@echo "Documentation: file://$(CURDIR)/docs/_build/html/index.html"

# As a user who has the wheel and no clone: everything happens in a folder of its own.
TRIAL := build/wheel
wheel: | $(BIN)/python
	rm -rf dist $(TRIAL) && mkdir -p $(TRIAL)
	$(PIP) wheel --quiet --no-deps -w dist .
	$(call venv,$(TRIAL)/venv)
	$(TRIAL)/venv/bin/python -m pip --disable-pip-version-check install --quiet -c constraints.txt "$$(echo dist/*.whl)[vision]"
	unset PYTHONPATH && cd $(TRIAL) && venv/bin/holonom demo --quiet && \
	  for kind in arm base agv; do venv/bin/holonom new $$kind $$kind && venv/bin/holonom run $$kind/cell.toml --quiet || exit; done

clean:
	rm -rf $(VENV) build dist docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +

# Debian's python3 without python3-venv has no ensurepip: then the pip beside $(PYTHON) fills the environment.
venv = $(PYTHON) -m venv $(1) || \
	{ $(PYTHON) -m venv --clear --without-pip $(1) && $(PYTHON) -m pip --python $(1)/bin/python install --quiet pip; }

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Holonom needs Python 3.11 or newer, $(PYTHON) is `$(PYTHON) -V 2>&1`; use PYTHON=python3.12 make ..."; exit 2; }
	$(call venv,$(VENV))

# A stamp for each: no target waits for what another one installs. Lint and types import little: byte code is not made. Tests
# read what the pages are made with, too.
$(VENV)/demo.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[vision]'
	@touch $@

$(VENV)/check.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[check]' --no-compile
	@touch $@

$(VENV)/test.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[vision,xacro,motion,plots,symbolic,mpc,docs,test]'
	@touch $@ $(VENV)/demo.stamp

$(VENV)/docs.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[docs]'
	@touch $@

$(VENV)/oracle.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[vision,xacro,motion,plots,symbolic,mpc,docs,test,oracle]'
	@touch $@ $(VENV)/demo.stamp $(VENV)/test.stamp
