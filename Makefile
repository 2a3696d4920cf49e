# Needs make and a Python of 3.11 or newer; everything else goes into .venv. `make help` lists the targets.

.DEFAULT_GOAL := help
.NOTPARALLEL:
.SUFFIXES:
MAKEFLAGS += --no-print-directory

VENV := .venv
PYTHON := $(VENV)/bin/python
XDIST ?= -n 2 --dist worksteal
# Comparisons that take minutes may take half an hour before they count as hung.
LONG := -o faulthandler_timeout=1800
# Which Python makes .venv: the first of these that will do.
BASE_PYTHON ?= python3 python3.13 python3.12 python3.11 python3.14

# The oldest dependencies and extras that pyproject.toml allows, on the oldest Python, and the tests that see
# most of them at work. `make matrix` has the commands of a user on them.
OLDEST := .venv-oldest
OLDEST_PYTHON ?= python3.11 python3.12 python3
OLDEST_TESTS := tests/units tests/golden tests/modelfile/test_modelfile.py \
    tests/modelfile/test_modelfile_set_by_path.py tests/modelfile/test_modelfile_nouns.py \
    tests/results/test_result.py tests/results/test_runfile.py tests/results/test_export.py \
    tests/plots/test_figures_of_all_kinds.py tests/measures tests/cli/test_run.py \
    tests/studies/test_cluster.py tests/studies/test_indices.py tests/studies/test_optimise.py tests/studies/test_searching.py \
    tests/compiler/test_cuda_bindings.py tests/live/test_served.py tests/plots/test_film.py::test_an_mp4_has_its_frames
# The tests that call the kernels themselves; of what is compiled no tool sees a line.
COVERAGE_TESTS := tests/kernels

# In a process of its own: beside others the emulated processor misses pages of code.
ELSEWHERE := tests/verification/test_numerics_elsewhere.py

# A module is compiled when it is first imported: of twenty thousand files a test run needs a quarter.
INSTALL := -qq --no-compile

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export MPLBACKEND ?= Agg
# A test run starts a hundred processes, and each would compile the package anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test system matrix golden oldest coverage lint docs texts package release bench verify soak mutations clean help

demo: $(VENV)/.runtime  ## what clearance costs an air compressor in force, energy and noise; figures in runs/demo
	@$(PYTHON) examples/compressor.py runs/demo
	@echo "Next: $(VENV)/bin/vfife run examples/compressor.toml --set joint.small-end.clearance=\"50 um\" -o runs/mine --figures"
	@echo "      $(VENV)/bin/vfife new compressor -o mine.toml    $(VENV)/bin/vfife run examples/four_bar.toml (the paper's four-bar)"

test: $(VENV)/.test  ## run the tests of every idea, about four minutes on two cores (PYTEST="-k name" narrows it)
	@command -v chromium >/dev/null || echo "No chromium here: tests of pages in a browser are skipped (on Debian: apt-get install chromium)."
	@$(PYTHON) -m pytest $(XDIST) $(PYTEST)

system: $(VENV)/.test  ## the tests that start processes, browsers and emulators, and those that take long
	@$(PYTHON) -m pytest $(XDIST) -m "system and not verify and not soak" $(PYTEST)

matrix: $(VENV)/.test  ## commands of a user under other kernels of BLAS, processors, libraries and versions: the same bits? (MATRIX="--example NAME")
	@$(PYTHON) tests/matrix/matrix.py $(MATRIX)

golden: $(VENV)/.test  ## take the answers and hashes anew that every machine is held to; a change of the numbers says why in its commit
	@PYTHONPATH=tests $(PYTHON) tests/golden/test_golden.py
	@$(PYTHON) tests/matrix/matrix.py --take

oldest: $(OLDEST)/.test  ## the tests that show it where every dependency is the oldest that is allowed
	@$(OLDEST)/bin/python -m pytest --disable-warnings $(XDIST) -m "not verify and not soak and not bench" $(OLDEST_TESTS) $(PYTEST)

coverage: $(VENV)/.test  ## the kernels as plain Python: which of their lines the tests run
	@$(PYTHON) -m pytest -m "system or not (verify or soak or bench)" $(COVERAGE_TESTS) --cov=src/vfife/kernels --cov-report=term-missing:skip-covered --cov-fail-under=95 $(PYTEST)

lint: $(VENV)/.dev  ## style (of JavaScript too), types, import contracts
	@$(PYTHON) -m ruff check .
	@$(PYTHON) -m ruff format --check src tests benchmarks examples docs/extensions
	@$(PYTHON) -m mypy
	@$(VENV)/bin/lint-imports
	@$(VENV)/bin/biome check --error-on-warnings

docs: $(VENV)/.dev  ## build the pages, running every example; a warning is an error
	@$(PYTHON) -m sphinx -W --keep-going -j auto -b html -d docs/_build/doctrees docs docs/_build/html
	@echo "docs/_build/html/index.html"

texts: $(VENV)/.runtime  ## write the lists of commands and keys into docs, and numbers, film and figure of the demo into the README
	@$(PYTHON) .ci/texts.py

package: $(VENV)/.dev  ## build wheel and sdist into dist/, and try the wheel in a bare environment outside this folder
	@$(PYTHON) .ci/package.py

release: $(VENV)/.dev  ## put version and date where they stand, then make package: make release VERSION=0.2.0
	@$(PYTHON) .ci/release.py "$(VERSION)"
	@$(PYTHON) .ci/package.py

bench: $(VENV)/.runtime  ## measure speed into benchmarks/latest.json
	@$(PYTHON) benchmarks/run.py

verify: $(VENV)/.verify  ## the long comparisons with references and published numbers
	@$(PYTHON) -m pytest $(XDIST) $(LONG) -m verify --ignore $(ELSEWHERE) $(PYTEST)
	@$(PYTHON) -m pytest $(LONG) -m verify $(ELSEWHERE) $(PYTEST) || test $$? = 5

soak: $(VENV)/.test  ## long runs, killed and restarted; thousands of mechanisms; all examples of every property
	@$(PYTHON) -m pytest -s -o faulthandler_timeout=0 -m soak $(PYTEST)
	@VFIFE_EXAMPLES=all $(PYTHON) -m pytest $(XDIST) $(LONG) -m "(hypothesis or rounds) and not verify" $(PYTEST)

mutations: $(VENV)/.test  ## small faults, 100 in kernels and 40 in each of five packages: does the suite see them? (MUTATE="--package measures --count 9")
	@$(PYTHON) tests/mutations/mutate.py $(MUTATE)

clean:  ## remove what was built, except .venv and runs/
	@rm -rf build dist docs/_build docs/_made docs/api docs/examples docs/gallery docs/notebooks docs/sg_execution_times.rst \
	    .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	@find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*##  *\(.*\)/  make \1#\2/p' $(firstword $(MAKEFILE_LIST)) | awk -F'#' '{ printf "%-15s %s\n", $$1, $$2 }'

# A stamp for each set of packages; all are laid again when pyproject.toml changes, or when .venv was made anew.

# The first Python of a list that will do makes a virtual environment: $(call environment,list,folder).
define environment
	@base=; \
	for name in $(1); do \
	    if $$name -c 'import ensurepip, sys, venv; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' >/dev/null 2>&1; \
	    then base=$$name; break; fi; \
	done; \
	if [ -z "$$base" ]; then \
	    echo "None of ($(1)) is a Python 3.11 to 3.14 with its venv module; name one: make BASE_PYTHON=..." >&2; exit 1; \
	fi; \
	echo "Making $(2) with $$($$base --version)"; \
	$$base -m venv --clear $(2)
endef

$(PYTHON):
	$(call environment,$(BASE_PYTHON),$(VENV))

$(OLDEST)/bin/python:
	$(call environment,$(OLDEST_PYTHON),$(OLDEST))

$(OLDEST)/.test: pyproject.toml .ci/oldest.py $(OLDEST)/bin/python
	@echo "Installing vfife with its oldest dependencies into $(OLDEST) (a minute or two the first time)"
	@$(OLDEST)/bin/python .ci/oldest.py > $(OLDEST)/constraints.txt
	@$(OLDEST)/bin/python -m pip install $(INSTALL) --editable '.[test,parquet,video]' --constraint $(OLDEST)/constraints.txt
	@touch $@

$(VENV)/.runtime: pyproject.toml $(PYTHON)
	@echo "Installing vfife into $(VENV) (a minute or two the first time)"
	@$(PYTHON) -m pip install $(INSTALL) --editable .
	@touch $@

$(VENV)/.test: pyproject.toml $(PYTHON)
	@echo "Installing vfife and what its tests need into $(VENV) (a minute or two the first time)"
	@$(PYTHON) -m pip install $(INSTALL) --editable '.[test]'
	@touch $(VENV)/.runtime $@

# Where there are no emulators for this machine, the tests that need them say so.
$(VENV)/.verify: $(VENV)/.test
	@$(PYTHON) -m pip install $(INSTALL) --only-binary bochscpu-python,unicorn --editable '.[verify]' || echo "No emulated processors here: code for AVX-512 and AArch64 is read, not run."
	@touch $(VENV)/.runtime $(VENV)/.test $@

$(VENV)/.dev: pyproject.toml $(PYTHON)
	@echo "Installing vfife and what its developers need into $(VENV) (a minute or two the first time)"
	@$(PYTHON) -m pip install $(INSTALL) --editable '.[dev]'
	@touch $(VENV)/.runtime $(VENV)/.test $@
