# Everything here works on a fresh Debian or Ubuntu with python3 (3.11 or newer), venv and make:
# each target that needs packages makes .venv by itself, with the versions pinned in requirements.lock.

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help figures notebooks lab test lint bench lock clean report site replicate

PYTHON  ?= python3
PROFILE ?= default
JOBS    ?= 2
NAMES   ?=
LOCKFLAGS ?=
CELL_TIMEOUT ?= 600
LABFLAGS ?=

VENV  := .venv
PY    := $(VENV)/bin/python
STAMP := $(VENV)/.complete
UV    := uv==0.13.9

# One thread a process: the jobs share the cores, and sums come out in the same order every time.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export MKL_NUM_THREADS ?= 1
export VECLIB_MAXIMUM_THREADS ?= 1
export NUMBA_NUM_THREADS ?= 1
export PYTHONHASHSEED := 0
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export JUPYTER_PREFER_ENV_PATH := 1
export PYDEVD_DISABLE_FILE_VALIDATION := 1
ifeq ($(shell uname -s),Linux)
export VTK_DEFAULT_OPENGL_WINDOW := vtkEGLRenderWindow
endif

# A stamp of another place (a copied checkout) or of a Python that is gone must not count.
ifneq ($(wildcard $(STAMP)),)
ifneq ($(shell $(PY) -c 'import os, sys; print(open(sys.argv[1]).read().strip() == os.getcwd())' $(STAMP) 2>&1),True)
$(shell rm -f $(STAMP))
endif
endif

help: ## show this list
	@echo "make <target>, where <target> is one of"
	@sed -n 's/^\([a-z]*\):.*## \(.*\)$$/  \1|\2/p' $(MAKEFILE_LIST) | awk -F'|' '{ printf "%-12s %s\n", $$1, $$2 }'
	@echo "variables: PYTHON=$(PYTHON)  PROFILE=$(PROFILE) (or paper)  JOBS=$(JOBS)  NAMES=\"fig26_convergence ...\" (all)"

figures: $(STAMP) ## execute the notebooks that are stale and write figures/ (PROFILE=paper: figures/paper/)
	@$(PY) -m geoweave.artifact.doctor --rendering
	@$(PY) -m geoweave.artifact.figures figures --profile $(PROFILE) --jobs $(JOBS) $(NAMES)

notebooks: $(STAMP) ## refresh the outputs stored in notebooks/
	@$(PY) -m geoweave.artifact.doctor --rendering
	@$(PY) -m geoweave.artifact.figures refresh --jobs $(JOBS) $(NAMES)

# What is published there must not overwrite the committed figures. requirements-lab.lock is bound by
# requirements.lock: installing it moves no version that figures depend on.
lab: $(STAMP) ## open JupyterLab on the notebooks (LABFLAGS="--no-browser --port=8890")
	@$(PY) -c 'import jupyterlab' 2>/dev/null || { \
	  echo "Installing JupyterLab into $(VENV) (about 20 MB to fetch, once)" >&2; \
	  $(PY) -m pip install --quiet --requirement requirements-lab.lock; }
	@mkdir -p build/lab
	@GEOWEAVE_FIGURES="$(CURDIR)/build/lab/figures" IPYTHONDIR="$(CURDIR)/build/lab/ipython" PYVISTA_OFF_SCREEN=true \
	  $(PY) -m jupyterlab --ServerApp.root_dir="$(CURDIR)" --LabApp.default_url=/lab/tree/notebooks/README.md $(LABFLAGS)

test: $(STAMP) ## ruff, mypy, the tests, and nbval over every notebook not executed as it is now
	@$(PY) -m geoweave.artifact.doctor --rendering
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .
	@$(PY) -m mypy
	@rm -rf build/test && mkdir -p build/test/figures
	@again=$$($(PY) -m geoweave.artifact.replay) && \
	  GEOWEAVE_FIGURES="$(CURDIR)/build/test/figures" IPYTHONDIR="$(CURDIR)/build/test/ipython" \
	  $(PY) -m pytest -n $(JOBS) --dist loadscope --no-loadscope-reorder \
	  --nbval-lax --nbval-current-env --nbval-cell-timeout=$(CELL_TIMEOUT) tests $$again

lint: $(STAMP) ## ruff and mypy, with what ruff can mend mended
	@$(PY) -m ruff check --fix .
	@$(PY) -m ruff format .
	@$(PY) -m mypy

bench: $(STAMP) ## speed, memory and growth, as multiples of the limit
	@$(PY) -m benchmarks

replicate: $(STAMP) ## draw Fig. 7 into build/ and compare its numbers with the committed ones
	@$(PY) scripts/replicate.py

report: $(STAMP) ## write the claims into docs/results.md, times and memory into REPRODUCING.md
	@$(PY) -m geoweave.artifact.figures report

site: $(STAMP) ## write the notebooks as pages for a browser, without a network: build/site/index.html
	@$(PY) -m geoweave.artifact.site

lock: ## choose versions anew for requirements.lock (LOCKFLAGS=--upgrade for the newest)
	@$(PYTHON) -m venv build/uv
	@build/uv/bin/python -m pip install --quiet $(UV)
	@build/uv/bin/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --all-extras \
	  --no-annotate --custom-compile-command "make lock" $(LOCKFLAGS) pyproject.toml --output-file requirements.lock
	@build/uv/bin/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --group lab \
	  --constraints requirements.lock --no-annotate --custom-compile-command "make lock" $(LOCKFLAGS) \
	  --output-file requirements-lab.lock

clean: ## remove .venv, build/ and every cache; figures/ and notebooks/ stay
	@rm -rf $(VENV) build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
	@find . -path ./.git -prune -o -type d \( -name __pycache__ -o -name .ipynb_checkpoints \) -prune -exec rm -rf {} +

# .incomplete marks a .venv that is being filled; one that was left so is thrown away and made anew.
$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "geoweave needs Python 3.11 or newer and '$(PYTHON)' is: $$($(PYTHON) --version 2>&1)." >&2; \
	  echo "Install one (sudo apt-get install python3 python3-venv), or name one: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; \
	  exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { \
	  echo "Python's venv is missing. Run: sudo apt-get install python3-venv" >&2; exit 1; }
	@sh scripts/graphics_library.sh
	@if [ -e $(VENV)/.incomplete ] || ! $(PY) -c '' 2>/dev/null; then rm -rf $(VENV); fi
	@mkdir -p $(VENV) && rm -f $(STAMP) && touch $(VENV)/.incomplete
	@echo "Installing the pinned packages into $(VENV) (about 400 MB to fetch; a few minutes the first time)" >&2
	@$(PYTHON) -m venv $(VENV)
	@$(PY) -m pip install --requirement requirements.lock
	@$(PY) -m pip install --quiet --no-build-isolation --no-deps --editable .
	@$(PY) -m pip check --quiet || { \
	  echo "requirements.lock does not satisfy pyproject.toml: run 'make lock'" >&2; exit 1; }
	@pwd -P > $(VENV)/.complete.new && mv $(VENV)/.complete.new $(STAMP) && rm -f $(VENV)/.incomplete
