# make demo · test · test-slow · check · bench · fuzz · reference · experiments
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: demo test test-slow check bench fuzz reference experiments clean
.DEFAULT_GOAL := help

help:
	@head -1 Makefile | cut -c3-

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

demo: $(READY)
	$(BIN)/rangeface demo

test: $(READY)
	$(BIN)/python -m pytest -m 'not slow'

test-slow: $(READY)
	$(BIN)/python -m pytest -m slow

check: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(READY)
	$(BIN)/python -m benchmarks

reference: $(READY)
	$(BIN)/python -m rangeface.app.reference
	$(BIN)/rangeface train src/rangeface/data/default.model

experiments: $(READY)
	$(BIN)/rangeface experiment all --out rangeface-experiments
	$(BIN)/rangeface figures --out rangeface-experiments/figures

fuzz: $(READY)
	$(BIN)/python tests/fuzz.py --cases $(or $(CASES),20000)

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis
