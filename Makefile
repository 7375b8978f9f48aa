# Everything a person or a machine does with the project. `make help` lists it.
#
# Needs Python >= 3.11, a C compiler and make. The environment lives in .venv and is made with uv
# if there is one, else with venv and pip; it is renewed only when pyproject.toml or the sources of
# the engine change. `make demo` loads what jousto needs to run, the checks their tools as well.
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
ENGINE := CMakeLists.txt src/jousto/model/native/declarations.py $(wildcard engine/*.c engine/*.h engine/*/*.c engine/*/*.h engine/*.cmake)
EXAMPLE ?= examples/flexible_pendulum.py

export MPLBACKEND := Agg
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# modules are compiled once and kept: hundreds of the tests' processes would each do it for two seconds
unexport PYTHONDONTWRITEBYTECODE
# one thread for each of the processes that run the tests
export OMP_NUM_THREADS ?= 1

.PHONY: help
help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

# ---- environment ---------------------------------------------------------------------------------

# .made: jousto itself, editable, with the engine built in place; the others add an extra each
STAMPS := $(addprefix $(VENV)/.,made dev large docs bench page peers)
$(VENV)/.made: pyproject.toml $(ENGINE)
$(filter-out %.made,$(STAMPS)): pyproject.toml | $(VENV)/.made

ifndef HOLDING
# one installation at a time in one folder: a second `make` waits, then looks again what is left to do
$(STAMPS):
	@$(or $(PYTHON),python3) tools/locked.py build/install.lock $(MAKE) HOLDING=1 $@
else

# $(call install,WHAT): into the environment, with uv or, if there is none or it fails, with pip,
# which then tells what it loads and how large that is
define install
	$(if $(UV),$(UV) pip install --python $(PY) $(1) ||) \
	{ $(PY) -m pip --version >/dev/null 2>&1 || $(PY) -m ensurepip; \
	  PYTHONUNBUFFERED=1 $(PY) -m pip install --no-compile --progress-bar off $(1) \
  | awk '/^ *(Downloading|Using cached) .* MB/ || /Building .* jousto.*started/ {print; fflush()}'; }
endef

$(VENV)/.made:
	@if ! $(PY) -c '' 2>/dev/null; then \
	  rm -rf $(VENV); \
	  if [ -n "$(PYTHON)" ]; then $(if $(UV),$(UV) venv --quiet --python "$$(command -v $(PYTHON))" $(VENV) ||) $(PYTHON) -m venv $(VENV); \
	  elif [ -n "$(UV)" ]; then $(UV) venv --quiet --python '>=3.11' $(VENV); \
	  else echo "jousto needs Python 3.11 or newer (make PYTHON=/path/to/python3)" >&2; exit 1; fi; \
	fi
	@echo "installing jousto into $(VENV): some 40 packages, 120 MB to load, and the C engine to compile"
	@$(call install,--config-settings=build-dir=build/engine -e .)
	@echo "  $$(du -sm $(VENV) | cut -f1) MB in $(VENV)"
	@touch $@

$(VENV)/.dev $(VENV)/.large $(VENV)/.docs $(VENV)/.bench $(VENV)/.page $(VENV)/.peers: $(VENV)/.%:
	@echo "adding what make needs for $*"
	@$(call install,'jousto[$*]')
	@echo "  $$(du -sm $(VENV) | cut -f1) MB in $(VENV)"
	@touch $@
endif

.PHONY: install engine
install: $(VENV)/.dev  ## environment in .venv with jousto (editable) and all tools
engine: $(VENV)/.made  ## the C engine, built into src/jousto/model/native/lib

# ---- what it can do --------------------------------------------------------------------------------

.PHONY: demo bench page docs
demo: $(VENV)/.made  ## the flexible pendulum against its reference; plot and animation in out/
	@$(PY) $(EXAMPLE)

bench: $(VENV)/.bench  ## speed beside EXUDYN, MuJoCo and Pinocchio: ten minutes; fills in the pages
	@$(PY) benchmarks/run.py

.PHONY: bench-short
bench-short: $(VENV)/.bench  ## the same with the smallest cases: that all of it still runs
	@$(PY) benchmarks/run.py short

# the page of the viewer: with the Node of this computer, else with that of a Python package; who has
# neither can do everything but look into a browser
PAGE := src/jousto/viewer/page/viewer.js
page: $(PAGE)  ## the viewer's page, built into src/jousto/viewer/page
$(PAGE): $(shell find frontend -path '*/node_modules' -prune -o -type f -print) | $(VENV)/.made
	@$(PY) frontend/build.py --probe >/dev/null 2>&1 || $(MAKE) $(VENV)/.page
	@$(PY) frontend/build.py

docs: $(VENV)/.docs $(PAGE)  ## documentation in build/docs, warnings are errors
	@$(PY) -m sphinx -W --keep-going -q -b html docs build/docs
	@! grep -rlE '<(script|link|img)[^>]*(src|href)="https?://' --include='*.html' build/docs \
	  || { echo "these pages need a network" >&2; exit 1; }
	@echo "build/docs/index.html"

# ---- checks ----------------------------------------------------------------------------------------

.PHONY: test quick lint types layers sanitize page-test unit slow cores kernels kernel-names old-processor tables format
test: $(VENV)/.dev $(PAGE)  ## every check except the slow verification runs
	@$(MAKE) -j2 lint types layers sanitize page-test
	@$(MAKE) unit

lint: $(VENV)/.dev
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .

# the package strictly, then what users write, as the editor shows it to them (pyright is Pylance's checker)
types: $(VENV)/.dev
	@$(BIN)/mypy
	@$(PY) frontend/build.py --probe >/dev/null 2>&1 || $(MAKE) $(VENV)/.page
	@rm -rf build/types && $(PY) tools/pages.py build/types
	@$(PY) frontend/build.py --types

layers: $(VENV)/.dev
	@$(BIN)/lint-imports

# neighbours stay in one process, which makes what they share once, until another is idle
PYTEST := $(PY) -m pytest -q -n auto --dist worksteal

# a third of the tests, those of the rooms that need no meshes and no long runs
QUICK := $(addprefix tests/,base materials sections mechanism model schema) \
  $(addprefix --ignore=tests/schema/,test_kept_meshes.py test_solids.py)
quick: lint  ## layout and the fast third of the tests: 40 s on two cores
	@$(PYTEST) $(PYTEST_ARGS) $(QUICK)

page-test: $(PAGE)  ## the tests of frontend/test, with the runner of Node
	@$(PY) frontend/build.py --test

# tests, doctests and examples
unit: $(VENV)/.dev $(PAGE)
	@$(PYTEST) $(PYTEST_ARGS)

slow: $(VENV)/.dev  ## the long verification runs
	@$(PYTEST) -m slow $(PYTEST_ARGS) || [ $$? -eq 5 ]

cores: $(VENV)/.dev $(PAGE)  ## all tests in joint coordinates, then in the positions of the bodies: half an hour
	@$(PYTEST) $(PYTEST_ARGS) --core joint
	@$(PYTEST) $(PYTEST_ARGS) --core maximal

# the tests of numbers once more with each set of kernels that OpenBLAS has for this processor, then as an
# old one computes: the engine, OpenBLAS and NumPy without AVX; not those that declare, read, cut and spoil files.
# Property tests try few examples: their laws were searched before, here other roundings are
ROOMS := $(addprefix tests/,design fatigue measurement model parts planar recovery reduction \
  sections simulation verification cli/test_hotspots.py cli/test_statics.py test_docs.py)
FILES := $(addprefix --ignore=tests/,parts/mesh parts/test_apart.py reduction/test_cache.py \
  simulation/test_damage.py measurement/monitor/test_damage.py)
FLAGS := $(shell grep -m1 '^flags' /proc/cpuinfo 2>/dev/null)
KERNELS := $(if $(filter avx512vl,$(FLAGS)),SkylakeX) $(if $(filter avx2,$(FLAGS)),Haswell) \
  $(if $(filter avx,$(FLAGS)),Sandybridge)
DISPATCHED := from numpy._core._multiarray_umath import __cpu_dispatch__ as d, __cpu_features__ as f; \
  print(*(x for x in d if f[x]))
# CI runs as many of them as it has time for; `make test` has run those that BLAS chooses for this processor
OWN := from threadpoolctl import threadpool_info as i; import numpy; print(i()[0]["architecture"])
kernel-names: $(VENV)/.dev
	@echo old-processor $$(for k in $(KERNELS); do [ "$$k" = "$$($(PY) -c '$(OWN)')" ] || echo "kernel-$$k"; done)
kernels: $(addprefix kernel-,$(KERNELS)) old-processor  ## the tests of numbers with other kernels of BLAS and NumPy
kernel-% old-processor: export HYPOTHESIS_PROFILE := few
kernel-%: export OPENBLAS_CORETYPE = $*
kernel-%: $(VENV)/.dev
	@echo "kernels of OpenBLAS: $*"
	@$(PYTEST) $(PYTEST_ARGS) $(FILES) $(ROOMS)
old-processor: export JOUSTO_CPU := baseline
old-processor: export OPENBLAS_CORETYPE := Nehalem
old-processor: $(VENV)/.dev  ## the same as a processor without AVX computes
	@echo "a processor without AVX: kernels Nehalem, NumPy without its own"
	@NPY_DISABLE_CPU_FEATURES="$$($(PY) -c '$(DISPATCHED)')" $(PYTEST) $(PYTEST_ARGS) $(FILES) $(ROOMS)

tables: $(VENV)/.made  ## the parts of docs/ that are made of the declarations: tables of joints, words of robots
	@$(PY) tools/tables.py
	@$(PY) tools/robot_words.py

format: $(VENV)/.dev  ## reformat and repair what can be repaired
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

# the engine's own C tests under the address and undefined-behaviour sanitizers, warnings are errors;
# each engine/test/*.c is a program that returns 0
WARN := -std=c99 -Wall -Wextra -pedantic -Werror
SANITIZE := -g -O1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all
ENGINE_TESTS := $(patsubst engine/test/%.c,build/sanitize/%,$(wildcard engine/test/*.c))

LANES_OK := $(if $(shell command -v cmake 2>/dev/null),build/sanitize/lanes.ok)
sanitize: $(ENGINE_TESTS) build/sanitize/complex.ok $(LANES_OK)  ## the C engine under sanitizers
	@for t in $(ENGINE_TESTS); do echo "sanitized $$t"; "$$t"; done

# the engine is compiled once for all of them
# every folder of the engine but these three is a room of it
ENGINE_C := $(filter-out engine/export/% engine/lanes/% engine/test/%,$(wildcard engine/*.c engine/*/*.c))
SANITIZED := $(patsubst engine/%.c,build/sanitize/objects/%.o,$(ENGINE_C))
.SECONDARY: $(SANITIZED)
build/sanitize/objects/%.o: engine/%.c $(wildcard engine/*.h engine/*/*.h)
	@mkdir -p $(@D)
	@$(CC) $(WARN) $(SANITIZE) -Iengine -c $< -o $@

build/sanitize/%: engine/test/%.c $(SANITIZED) $(wildcard engine/test/*.h)
	@$(CC) $(WARN) $(SANITIZE) -Iengine $< $(SANITIZED) -o $@ -lm

build/sanitize/complex.ok: $(ENGINE)
	@mkdir -p $(@D)
	@for f in $(ENGINE_C); do $(CC) $(WARN) -DJO_COMPLEX -Iengine -fsyntax-only $$f; done
	@touch $@

# machines side by side, where CMake builds them: their Python tests with a sanitized build
LANES := build/sanitize/lanes
build/sanitize/lanes.ok: $(ENGINE) $(wildcard engine/lanes/*) tests/model/test_ensemble.py $(VENV)/.dev
	@mkdir -p $(LANES)
	@cmake -S . -B $(LANES) -DCMAKE_C_COMPILER=$(CC) -DCMAKE_BUILD_TYPE=None \
	  -DCMAKE_C_FLAGS='$(SANITIZE) -ffp-contract=fast' >$(LANES)/log || { cat $(LANES)/log; exit 1; }
	@for l in v3 v4; do \
	  cmake --build $(LANES) --target help | grep jousto_lanes_$$l >/dev/null || continue; \
	  cmake --build $(LANES) -j 2 --target jousto_lanes_$$l >$(LANES)/log 2>&1 || { cat $(LANES)/log; exit 1; }; \
	done
	@if ls $(LANES)/jousto_lanes_*.so >/dev/null 2>&1; then echo "sanitized lanes"; \
	  LD_PRELOAD="$$($(CC) -print-file-name=libasan.so) $$($(CC) -print-file-name=libubsan.so)" \
	  ASAN_OPTIONS=detect_leaks=0 SANITIZED_LANES=$(abspath $(LANES)) \
	  $(PY) -m pytest -q -p no:cacheprovider --capture=no tests/model/test_ensemble.py; fi
	@touch $@

# ---- packages --------------------------------------------------------------------------------------

.PHONY: wheel wheel-check clean
wheel: $(VENV)/.made $(PAGE)  ## a wheel in dist/
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
	rm -rf $(VENV) build dist out src/jousto/model/native/lib \
	  src/jousto/viewer/page .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +
