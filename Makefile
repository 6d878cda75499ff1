# Every target makes its own .venv from Python 3.11 or newer (PYTHON=python3.12 make demo picks another one).
PYTHON ?= python3
PYTEST_ARGS ?=
BENCH_ARGS ?=
VENV := .venv
BIN := $(VENV)/bin
DEMO := runs/sort_coins
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help demo test peers check bench docs clean

help:
	@echo "make demo    a Puma 560 sorts the coins it sees in a photograph; writes $(DEMO)/report.html"
	@echo "make test    lint, types, layers, then every test (PYTEST_ARGS='-k ik' narrows them)"
	@echo "make peers   the same quantities by peer libraries, and every benchmark once, small"
	@echo "make check   lint, types and layers only"
	@echo "make bench   speed beside the peer libraries"
	@echo "make docs    HTML documentation in docs/_build/html"
	@echo "make clean   removes .venv, caches and builds (runs/ stays)"

demo: $(VENV)/demo.stamp
	$(BIN)/holonom run examples/01_sort_coins/cell.toml -o $(DEMO)
	@echo "Report: file://$(CURDIR)/$(DEMO)/report.html"

test: check
	$(BIN)/python -m pytest -m 'not oracle' $(PYTEST_ARGS)

peers: $(VENV)/all.stamp
	$(BIN)/python -m pytest -m oracle $(PYTEST_ARGS)

check: $(VENV)/test.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/all.stamp
	$(BIN)/holonom bench $(BENCH_ARGS)

docs: $(VENV)/all.stamp
	$(BIN)/sphinx-build -q -W --keep-going docs docs/_build/html
	@echo "Documentation: file://$(CURDIR)/docs/_build/html/index.html"

clean:
	rm -rf $(VENV) build dist docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +

# Debian's python3 without python3-venv has no ensurepip: then the pip beside $(PYTHON) fills the environment.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Holonom needs Python 3.11 or newer, $(PYTHON) is `$(PYTHON) -V 2>&1`; use PYTHON=python3.12 make ..."; exit 2; }
	$(PYTHON) -m venv $(VENV) || \
	  { $(PYTHON) -m venv --clear --without-pip $(VENV) && $(PYTHON) -m pip --python $@ install --quiet pip; }

# Three stamps: the demo does not wait for the test tools, the tests not for the peers.
$(VENV)/demo.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[vision]'
	@touch $@

$(VENV)/test.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[vision,xacro,motion,plots,symbolic,test]'
	@touch $@ $(VENV)/demo.stamp

$(VENV)/all.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) '.[all]'
	@touch $@ $(VENV)/demo.stamp $(VENV)/test.stamp
