# `make demo` and `make test` set up everything they need in .venv.

PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
BIN = .venv/bin
NATIVE_TOOLS = $(BIN)/python -c "import ziglang" 2>/dev/null
# Tests start hundreds of processes: each would compile all that it imports.
unexport PYTHONDONTWRITEBYTECODE
# Packages by uv, in a quarter of pip's time, from pip's index and within pip's constraints. Where uv cannot, pip
# installs, and says why it failed. A newer pip repeats the warnings of build tools. A comma is written +, for make
# calls with commas.
comma := ,
PIP = PYTHONWARNINGS=ignore $(BIN)/python -m pip
UV = UV_DEFAULT_INDEX="$${UV_DEFAULT_INDEX:-$${PIP_INDEX_URL:-$$($(PIP) config get global.index-url 2> /dev/null)}}" \
	UV_CONSTRAINT="$${UV_CONSTRAINT:-$$PIP_CONSTRAINT}" $(BIN)/uv pip install --quiet --python $(BIN)/python
what = $(subst +,$(comma),$(1))
install = { $(UV) $(what) 2> /dev/null || $(PIP) install --quiet --disable-pip-version-check --no-compile $(what); }

.PHONY: demo generate claims estimation docs check check-all check-built test tests thorough quick build native lint bench \
	pages mutants mutants-tool coverage claims-check lock release clean

# A run builds the FMUs that it needs, and no others.
demo: .venv/.demo
	$(BIN)/maglev report 3dof-setpoints-improved

claims: .venv/.demo
	$(BIN)/maglev run --all
	$(BIN)/python tools/write_claims.py results/claims.md

# Check that the table of claims has the numbers of the runs. They are native where possible, because both kinds have
# the same bits. Other pages are compared with native runs only.
claims-check: .venv/.test
	@mkdir -p results
	$(BIN)/maglev run --all --out results/claims > results/claims.log
	@if $(NATIVE_TOOLS); then set -x; $(BIN)/python tools/page_numbers.py; fi
	$(BIN)/python tools/write_claims.py results/claims/claims.md --check

# Friction, estimated from part of the evidence and judged on the rest: docs/estimation.md.
estimation: .venv/.test
	$(BIN)/python -m studies.estimation

# The site, which needs no network: docs/_build/html/index.html. Its notebooks and its experiments are run; where
# there is a compiler the live stage runs on the first page.
docs: build
	$(call install,--editable '.[report+data+design+docs]')
	@$(call install,--editable '.[native]') || echo "left out: the live page, for pip cannot install the extra 'native'"
	@if $(NATIVE_TOOLS); then set -x; $(BIN)/maglev live --out docs/_made/extra/stage; fi
	$(BIN)/python docs/site/experiments.py docs/_made/experiments
	$(MAKE) claims-check
	FMUS=$(CURDIR)/fmus $(BIN)/python -m sphinx -q -W --keep-going -D nb_execution_mode=force -b html docs docs/_build/html
	@echo docs/_build/html/index.html

check: .venv/.demo
	$(BIN)/maglev check

build: .venv/.demo
	$(BIN)/maglev build

native: .venv/.test
	$(BIN)/maglev build --kind native

test: .venv/.test
	$(MAKE) --jobs=2 lint tests
	$(MAKE) check-built
	PYTHONPATH=tests/support $(BIN)/python benchmarks/step_cost.py --gate --fmus .venv/fmus
	$(BIN)/python benchmarks/whole_run.py --gate --fmus .venv/fmus

# Matrices have a handful of rows: threads of BLAS would wait for each other, on processors that other tests could have.
tests thorough quick coverage mutants-tool: export OPENBLAS_NUM_THREADS = 1

# They leave their FMUs behind, for the check. Four at a time on two cores: many wait for processes that start. Files go in
# the order of tests/conftest.py, the longest first. One process goes ahead: four would compile all that they import.
tests: .venv/.test
	@$(BIN)/python -m pytest --collect-only -m "not thorough" > /dev/null || :   # errors are printed below
	$(BIN)/python -m pytest -n 4 --dist loadfile --no-loadscope-reorder --durations=25 -m "not thorough" --fmus=.venv/fmus

# Long tests of parts that seldom change, and the types of all tests.
thorough: .venv/.test
	$(BIN)/mypy tests
	$(BIN)/python -m pytest -n 2 --dist loadfile -m thorough

# The tests that need no FMU, compiler or browser, and do not run for long: to be run after every change.
quick: .venv/.test
	$(BIN)/python -m pytest -n 2 --dist loadfile -m quick

# Every run against its baseline. The native FMUs take a third of the time, and the tests compare both kinds bit for
# bit. Some machines cannot build native FMUs.
check-all: .venv/.test
	@if $(NATIVE_TOOLS); then set -x; $(BIN)/maglev build --kind native --target host --fmus .venv/fmus; \
		else set -x; $(BIN)/maglev build --fmus .venv/fmus/python; fi
	$(MAKE) check-built

check-built: .venv/.test
	@if $(NATIVE_TOOLS); then set -x; $(BIN)/maglev check --kind native --fmus .venv/fmus; \
		else echo "left out: native FMUs, for the extra 'native' is not installed"; set -x; \
		$(BIN)/maglev check --fmus .venv/fmus/python; fi

# The pages of the stages, from their descriptions in the folder stages.
generate: .venv/.demo
	$(BIN)/python -m maglev.descriptions

lint: .venv/.test
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/mypy tools benchmarks docs/site
	$(BIN)/python tools/plain_english.py

# Cost of a step, a run and a sample of a study, for docs/accuracy.md: on a machine with nothing else to do.
bench: .venv/.test
	PYTHONPATH=tests/support $(BIN)/python benchmarks/step_cost.py
	$(BIN)/python benchmarks/whole_run.py

# The versions of all that the tests install, for every system: after a run of `make test` with them, to be committed.
lock: .venv/.test
	{ head -n 2 constraints.txt; $(BIN)/uv pip compile pyproject.toml --universal --python-version 3.11 --upgrade --quiet \
		--extra report --extra test --extra native --extra interop --no-header --no-emit-index-url --no-annotate; } \
		> constraints.new
	mv constraints.new constraints.txt

# Everything that a version ships, into dist: wheel, FMUs for all platforms, site, checksums, provenance. The checksums
# of two machines are equal if both use a fresh clone with the locked tools.
release: export PIP_CONSTRAINT := $(CURDIR)/constraints.txt
release: docs .venv/.test
	$(BIN)/python tools/release.py

# A page of every kind in results, and the index that leads to them.
pages: .venv/.test
	$(BIN)/maglev build --kind native --target host --fmus .venv/fmus
	$(BIN)/maglev build --kind native --target wasm --fmus .venv/fmus
	$(BIN)/maglev live --fmus .venv/fmus
	$(BIN)/maglev report --kind native --fmus .venv/fmus
	$(BIN)/maglev compare 2dof-step-4-linear --controller Regulator2DOF --controller LinearRegulator2DOF \
		--kind native --fmus .venv/fmus --out results
	$(BIN)/maglev study payload-friction --kind native --fmus .venv/fmus --out results
	@echo $(CURDIR)/results/index.html

# Mutants that `maglev check` does not notice: one line of the blocks changed at a time. It takes half an hour.
mutants: .venv/.test
	$(BIN)/python tools/mutants.py

# Mutants, in the code that judges and compares, that its quick tests do not notice: one expression changed at a time.
# Survivors are listed.
mutants-tool: .venv/.test
	$(call install,mutmut==3.8.1)
	@mkdir -p results
	$(BIN)/mutmut run > results/mutmut.log
	$(BIN)/mutmut results

# Lines and branches that no test runs, by file. It is for reading: no number is asked for.
coverage: .venv/.test
	$(call install,pytest-cov==7.1.0)
	$(BIN)/python -m pytest -n 4 --dist loadfile --no-loadscope-reorder -m "not thorough" --fmus=.venv/fmus \
		--cov --cov-report=term-missing:skip-covered

clean:
	rm -rf .venv results dist docs/_made docs/_build fmus/*.fmu fmus/*.ssp fmus/native fmus/fmi3 fmus/wasm

.venv/.venv:
	@test -n "$(PYTHON)" || { echo "make: no Python 3.11 or newer found, expected one; set PYTHON=/path/to/python3"; exit 1; }
	$(PYTHON) -m venv .venv
	@$(PIP) install --quiet uv || $(PIP) install --quiet --upgrade pip || echo "left out: uv and the newest pip, which take less time"
	@touch $@

.venv/.demo: .venv/.venv pyproject.toml
	@echo installing packages into .venv
	@$(call install,--editable '.[report]')
	@touch $@

# All extras at once, which takes half the time; if pip cannot install them, as many as it can.
.venv/.test: .venv/.venv pyproject.toml
	@echo installing packages into .venv
	@$(call install,--editable '.[report+test+native+interop]') || { $(call install,--editable '.[report+test]') \
		&& { $(call install,--editable '.[native]') || echo "left out: native FMUs, for pip cannot install the extra 'native'"; } \
		&& { $(call install,--editable '.[interop]') || echo "left out: masters of others, for pip cannot install the extra 'interop'"; }; }
	@touch .venv/.demo $@
