# make demo      set everything up, film the model railway, score it, write the report
# make test      set everything up, run the linters, the type checker and the tests
# make accuracy  film the whole rail, hold every expectation, write docs/accuracy.md
# make model     film the training scenarios and learn perception/models/*.json from them

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
export MUJOCO_GL ?= egl

.PHONY: demo test accuracy model setup lint clean

demo: setup
	$(BIN)/gantry run oval-two-vehicles --out runs/demo
	$(BIN)/gantry report runs/demo

test: setup lint
	$(BIN)/pytest

accuracy: setup
	$(BIN)/python -m bench.accuracy

TRAINING := $(basename $(notdir $(wildcard scenarios/library/train-*.toml)))

model: setup
	$(BIN)/gantry run $(TRAINING) --oracle detect --oracle calibrate --frames --out runs/training
	$(BIN)/gantry learn $(addprefix runs/training/,$(TRAINING)) --out perception/models/rail.json \
		--baselines perception/models/baselines.json

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
