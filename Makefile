# Two commands for a newcomer: `make demo` and `make test`. Both make their own environment.
PYTHON ?= $(firstword $(shell command -v python3.11 python3.12 python3))
VENV := .venv
BIN := $(VENV)/bin
PROJECTS := schemas services/nlu services/perception services/mapper services/dialogue \
            services/viewer sim-feeder evaluation console
PACKAGES := $(wildcard schemas/doro_* services/*/doro_* sim-feeder/doro_* evaluation/doro_* console/doro_*)
STAMP := $(VENV)/.installed

.PHONY: setup demo test check format lock generate clean

setup: $(STAMP)

$(STAMP): requirements.lock requirements-ai2thor.lock $(addsuffix /pyproject.toml,$(PROJECTS))
	@test -n "$(PYTHON)" || { echo "no Python 3.11 or newer was found: install one, or call make PYTHON=/path/to/python" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps -r requirements-ai2thor.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation $(addprefix -e ./,$(PROJECTS))
	@touch $(STAMP)

demo: setup
	$(BIN)/doro demo

test: setup check
	$(BIN)/python -m pytest

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy $(PACKAGES)

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Pinned requirements with hashes; names no host. Needs uv.
lock:
	uv pip compile --quiet --universal --generate-hashes --no-emit-index-url --no-annotate --no-header \
	    --python-version 3.11 --group dev --extra render --extra render-gl \
	    $(foreach name,schemas nlu perception mapper dialogue viewer sim-feeder evaluation,--no-emit-package doro-$(name)) \
	    $(addsuffix /pyproject.toml,$(PROJECTS)) -o requirements.lock
	@echo "requirements-ai2thor.lock is pinned by hand: one package, no dependencies"

# What is generated and committed: JSON Schemas, golden bytes, the topic table in the READMEs.
generate: setup
	$(BIN)/python -m tools.generate

clean:
	rm -rf $(VENV) out .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
	find . -name '*.egg-info' -type d -prune -exec rm -rf {} +
