# `make demo` and `make test` work on a fresh clone with nothing but Python 3.11 or newer.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: demo test docs campaign paper benchmark lint clean
.DEFAULT_GOAL := demo

demo: $(VENV)/.demo
	$(BIN)/python tools/demo.py --out out

test: $(VENV)/.test
	$(BIN)/python -m pytest -n auto --dist worksteal $(PYTEST_FLAGS)

docs: $(VENV)/.docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going -b html docs out/docs

campaign: $(VENV)/.test
	$(BIN)/python -m pytest -n auto -m campaign

paper: $(VENV)/.demo
	$(BIN)/python tools/reproduce_paper.py --out out/paper

benchmark: $(VENV)/.benchmark
	$(BIN)/python tools/benchmark.py balance
	$(BIN)/python tools/benchmark.py importing
	$(BIN)/python tools/benchmark.py pace
	$(BIN)/python tools/benchmark.py planning
	$(BIN)/python tools/benchmark.py reading
	$(BIN)/python tools/benchmark.py refusals
	$(BIN)/python tools/benchmark.py replanning
	$(BIN)/python tools/benchmark.py sweeping
	$(BIN)/python tools/benchmark.py solving --smoothness 0 --frames 51 --out out/benchmark/first-order
	$(BIN)/python tools/benchmark.py solving --out out/benchmark

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/codespell

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "ggo-factors needs Python 3.11 or newer; say which: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	touch $@

$(VENV)/.test: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	touch $@

$(VENV)/.docs: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	touch $@

$(VENV)/.benchmark: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[benchmark]'
	touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) out
