# make demo      set everything up, film the model railway, score it, write the report
# make test      set everything up, run the linters, the type checker and the tests
# make accuracy  film everything, hold every expectation, write docs/accuracy.md

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
export MUJOCO_GL ?= egl

.PHONY: demo test accuracy setup lint clean

demo: setup
	$(BIN)/gantry run oval-two-vehicles --out runs/demo
	$(BIN)/gantry report runs/demo

test: setup lint
	$(BIN)/pytest

accuracy: setup
	$(BIN)/python -m bench.accuracy

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy

setup: $(VENV)/.installed
	@$(BIN)/python -m sim.system_libraries

$(VENV)/.installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) runs
