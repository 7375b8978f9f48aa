# Everything a person or a machine does with the project. `make help` lists it.
#
# Needs Python >= 3.11, a C compiler and make. The environment lives in .venv and is made with uv
# if there is one, else with venv and pip; it is made again only when pyproject.toml changes, the C
# engine only when its sources change.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules --no-print-directory

# the newest Python >= 3.11 that really runs and can make an environment
ifeq ($(origin PYTHON), undefined)
PYTHON := $(shell for p in python3.13 python3.12 python3.11 python3.14 python3 python; do \
    "$$p" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
    && { echo "$$p"; break; }; done)
endif
UV ?= $(shell command -v uv 2>/dev/null)

VENV := .venv
BIN := $(VENV)/bin
PY := $(BIN)/python
CC ?= cc
ENGINE := CMakeLists.txt $(wildcard engine/*.c engine/*.h)
EXAMPLE ?= examples/flexible_pendulum.py

export MPLBACKEND := Agg
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# one thread for each of the processes that run the tests
export OMP_NUM_THREADS ?= 1

.PHONY: help
help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

# ---- environment ---------------------------------------------------------------------------------

# $(call install,WHAT): into the environment, with uv or, if there is none or it fails, with pip
define install
	$(if $(UV),$(UV) pip install --quiet --python $(PY) $(1) ||) \
	{ $(PY) -m pip --version >/dev/null 2>&1 || $(PY) -m ensurepip; $(PY) -m pip install --quiet $(1); }
endef

$(VENV)/.made: pyproject.toml
	@if ! $(PY) -c '' 2>/dev/null; then \
	  rm -rf $(VENV); \
	  if [ -n "$(PYTHON)" ]; then $(if $(UV),$(UV) venv --quiet --python "$$(command -v $(PYTHON))" $(VENV) ||) $(PYTHON) -m venv $(VENV); \
	  elif [ -n "$(UV)" ]; then $(UV) venv --quiet --python '>=3.11' $(VENV); \
	  else echo "jousto needs Python 3.11 or newer (make PYTHON=/path/to/python3)" >&2; exit 1; fi; \
	fi
	@echo "installing jousto and its tools into $(VENV)"
	@$(call install,-e '.[dev]')
	@touch $@

LIB := src/jousto/engine/lib
$(LIB)/.built: $(VENV)/.made $(ENGINE)
	@mkdir -p build
	@$(BIN)/cmake -S . -B build/engine -G Ninja -DCMAKE_MAKE_PROGRAM="$$(pwd)/$(BIN)/ninja" \
	  -DCMAKE_BUILD_TYPE=Release -DJOUSTO_INPLACE=ON >build/engine.log 2>&1 || { cat build/engine.log; exit 1; }
	@$(BIN)/cmake --build build/engine | grep -v Building
	@touch $@

$(VENV)/.docs: $(VENV)/.made
	@$(call install,-e '.[docs]')
	@touch $@

$(VENV)/.bench: $(VENV)/.made
	@$(call install,-e '.[bench]')
	@touch $@

.PHONY: install engine
install: $(LIB)/.built  ## environment in .venv with jousto (editable) and all tools
engine: $(LIB)/.built  ## the C engine, built into src/jousto/engine/lib

# ---- what it can do --------------------------------------------------------------------------------

.PHONY: demo bench docs
demo: $(LIB)/.built  ## the flexible pendulum against its reference; plot and animation in out/
	@$(PY) $(EXAMPLE)

bench: $(LIB)/.built $(VENV)/.bench  ## speed side by side with EXUDYN and Pinocchio
	@$(PY) benchmarks/speed.py
	@$(PY) benchmarks/mechanisms.py
	@$(PY) benchmarks/beams.py

docs: $(LIB)/.built $(VENV)/.docs  ## documentation in build/docs, warnings are errors
	@$(PY) -m sphinx -W --keep-going -q -b html docs build/docs
	@echo "build/docs/index.html"

# ---- checks ----------------------------------------------------------------------------------------

.PHONY: test lint types layers sanitize unit slow format
test: lint types layers sanitize unit  ## every check except the slow verification runs

lint: $(VENV)/.made
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .

types: $(VENV)/.made
	@$(BIN)/mypy

layers: $(VENV)/.made
	@$(BIN)/lint-imports

# tests, doctests and examples
unit: $(LIB)/.built
	@$(PY) -m pytest -q -n auto $(PYTEST_ARGS)

slow: $(LIB)/.built  ## the long verification runs
	@$(PY) -m pytest -q -n auto -m slow $(PYTEST_ARGS) || [ $$? -eq 5 ]

format: $(VENV)/.made  ## reformat and repair what can be repaired
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

# the engine's own C tests under the address and undefined-behaviour sanitizers, warnings are errors;
# each engine/test/*.c is a program that returns 0
WARN := -std=c99 -Wall -Wextra -pedantic -Werror
SANITIZE := -g -O1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all
ENGINE_TESTS := $(patsubst engine/test/%.c,build/sanitize/%,$(wildcard engine/test/*.c))

sanitize: $(ENGINE_TESTS) build/sanitize/complex.ok  ## the C engine under sanitizers
	@for t in $(ENGINE_TESTS); do echo "sanitized $$t"; "$$t"; done

build/sanitize/%: engine/test/%.c $(ENGINE) $(wildcard engine/test/*.h)
	@mkdir -p $(@D)
	$(CC) $(WARN) $(SANITIZE) -Iengine $< $(wildcard engine/*.c) -o $@ -lm

build/sanitize/complex.ok: $(ENGINE)
	@mkdir -p $(@D)
	@for f in $(wildcard engine/*.c); do $(CC) $(WARN) -DJO_COMPLEX -Iengine -fsyntax-only $$f; done
	@touch $@

# ---- packages --------------------------------------------------------------------------------------

.PHONY: wheel wheel-check clean
wheel: $(VENV)/.made  ## a wheel in dist/
	@rm -rf dist
	@$(if $(UV),$(UV) build --quiet --python $(PY) --wheel --out-dir dist . ||) \
	{ $(PY) -m pip --version >/dev/null 2>&1 || $(PY) -m ensurepip; $(PY) -m pip wheel --quiet --no-deps -w dist .; }
	@ls dist

wheel-check: wheel  ## install that wheel into an empty environment and run the demo there
	@rm -rf build/wheel-check
	@$(PY) -m venv build/wheel-check
	@build/wheel-check/bin/python -m pip install --quiet dist/*.whl
	@cd build/wheel-check && bin/jousto --help >/dev/null && bin/python ../../$(EXAMPLE) >demo.log \
	  || { cat demo.log; exit 1; }
	@echo "the wheel works in an empty environment"

clean:  ## remove everything that was built, and the environment
	rm -rf $(VENV) build dist out src/jousto/engine/lib src/jousto/engine/jousto.h \
	  .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +
