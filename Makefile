# make demo   set up .venv, then draw the astronaut
# make test   set up .venv, then run every test
# make lint   the linters and the type checker
# make bench  measure speed and memory, print a table, write docs/benchmarks.md (MODELS=DIR: the face models of Zhu & Ramanan too)
# make fuzz   fuzz every reader of outside data (TIME=seconds for each; HARNESS="svg gcode": only these)
# make docs   the documentation as a site, into build/site
# make reference  the pages of it that are made from the program
# make dist   build sdist and wheel into dist
# make licences  docs/licences.md: the licence of every package that is used
# make bench-studio how long a person waits in the studio, in Chromium
# make studio-pictures  the studio's screens in the documentation, and its example, drawn anew
# make studio-3d    bundle the 3-D view of the studio (needs npm); make dist does it too where npm is
# make clean  remove what was built

VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet install --constraint constraints.txt
OUT    := build/demo
# Debian's rospy is found by Python 3.11, its packages last.
ROS    := /usr/lib/python3/dist-packages
SITE   := $(VENV)/lib/python3.11/site-packages
DEBIAN  = $(shell grep -v '^\#' tests/debian.txt)
# The newest of the usual names that is new enough.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)

.PHONY: fuzz studio-3d bench-studio studio-pictures demo test lint bench docs reference dist licences clean
.DEFAULT_GOAL := demo

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "limner needs Python 3.11 or newer; install it, or run: make PYTHON=/path/to/python3"; exit 2; }
	@echo "setting up $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv $(VENV) || { echo "Python's venv module is missing (Debian: apt-get install python3-venv)"; rm -rf $(VENV); exit 2; }

$(VENV)/.demo: $(BIN)/python pyproject.toml constraints.txt
	@echo "installing limner and scikit-image (for its picture of the astronaut)"
	@$(PIP) --editable '.[demo]'
	@touch $@

$(VENV)/.dev: $(BIN)/python pyproject.toml constraints.txt
	@echo "installing limner and what its tests need"
	@$(PIP) --editable '.[dev]'
	@touch $@ $(VENV)/.demo

demo: $(VENV)/.demo
	@mkdir -p $(OUT)
	@echo "drawing the astronaut"
	@$(BIN)/limner draw "$$($(BIN)/python -c 'import skimage, pathlib; print(pathlib.Path(skimage.__file__).parent / "data" / "astronaut.png")')" \
		--out $(OUT)/astronaut.svg --out $(OUT)/astronaut.png

test: $(VENV)/.dev
	@test "$$CI" != true || dpkg -s $(DEBIAN) >/dev/null 2>&1 || { echo "installing ROS, Chromium and what else the tests drive"; \
		apt-get -qq update && apt-get -qq install -y --no-install-recommends $(DEBIAN); } >/dev/null
	@test ! -d $(ROS)/rospy || test ! -d $(SITE) || echo $(ROS) > $(SITE)/zz_debian_ros.pth
	@echo "running the tests on $$(nproc 2>/dev/null || echo 2) cores (all the slow ones too: make test LIMNER_SLOW=1)"
	@LIMNER_SLOW=$(LIMNER_SLOW) OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q --numprocesses auto

lint: $(VENV)/.dev
	$(BIN)/ruff check src tests tools examples fuzz
	$(BIN)/ruff format --check src tests tools examples fuzz
	$(BIN)/mypy

bench: $(VENV)/.dev
	@$(BIN)/limner evaluate speed --batch 40 --write docs $(if $(MODELS),--models $(MODELS))
	@$(BIN)/limner evaluate strokes
	@$(BIN)/limner evaluate arm

fuzz: $(VENV)/.dev
	@nice -n 15 $(BIN)/python -m fuzz --time $(or $(TIME),60) $(HARNESS)

docs: $(VENV)/.dev reference
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict
	@echo build/site/index.html

reference: $(VENV)/.dev
	@$(BIN)/python tools/reference.py

dist: $(VENV)/.dev
	@rm -rf dist
	@! command -v npm >/dev/null || $(MAKE) --no-print-directory studio-3d
	@$(BIN)/python -m build --outdir dist .
	@ls -l dist

licences: $(VENV)/.dev
	@$(BIN)/python tools/licences.py

bench-studio: $(VENV)/.dev
	@PYTHONPATH=tests $(BIN)/python tools/studio_bench.py

studio-pictures: $(VENV)/.dev
	@PYTHONPATH=tests $(BIN)/python tools/studio_pictures.py

studio-3d:
	@command -v npm >/dev/null || { echo "the 3-D view needs npm (Debian: apt-get install npm)"; exit 2; }
	@mkdir -p build/arm3d && cp src/limner/studio/arm3d/package.json src/limner/studio/arm3d/arm3d.js build/arm3d
	@cd build/arm3d && npm install --no-package-lock --no-audit --no-fund --silent && npm run --silent build -- --outfile=../../src/limner/studio/page/built/arm3d.js --log-level=warning

clean:
	rm -rf build dist src/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
