# axisgate.  `make demo` and `make test` work on a bare machine: they make .venv and, as root on Debian, install what is missing.

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
STAMP := $(VENV)/installed.stamp
JUDGES := $(VENV)/judges.stamp
REFERENCES := $(patsubst hil_tests/bench/%.c,build/%,$(wildcard hil_tests/bench/*.c))
DEMO ?=
BENCH ?=
SOAK ?=
MOTION ?=
POLE ?=
FUZZ ?=
MATRIX ?=
MUTANTS ?=

.DELETE_ON_ERROR:
.PHONY: help setup judges tools kernel references pythons native demo lint check test pytest bench soak fuzz branches losses mutants coverage-matrix docs pictures lock clean

help:
	@echo "make demo             six emulated drives, two PLCs, one cable to unplug (DEMO='--seed 7': its options)"
	@echo "make check            lint, types, import arrows and the pure tests on two processors: the daily loop"
	@echo "make test             lint, types, import arrows, all tests and lanes"
	@echo "make lint             lint, types, import arrows only"
	@echo "make bench            all benchmarks; rewrites docs/benchmarks.md"
	@echo "make coverage-matrix  which test proves which row of the manuals, from the last make test of this tree (else the tests run)"
	@echo "make mutants          do those tests detect a broken function? rewrites docs/proof.tsv and docs/proof.md (MUTANTS=--missing: what changed; '-k NAME', '--sample 60 --seed 7': a part)"
	@echo "make docs             pages from decisions, errors and evidence; the site in build/site"
	@echo "make pictures         docs/pictures from the last run of the page's tests"
	@echo "make soak             a million 3964R and RK512 telegrams, a tenth of them spoiled (SOAK=50000: fewer); 1,000 motion programs and 200 on belts (MOTION='100 20000': fewer); 10,000 lines beside a wrist pole (POLE=1000: fewer) and three minutes of curve in a cell; 60,000 emergency messages; 200 deaths of interpreter and PLC under PALTEST (KILLS=20: fewer); ten minutes of everything hostile at once (HOSTILE=60: fewer seconds); then make losses"
	@echo "make losses           100 deaths of the cycle under moving drives of both families"
	@echo "make branches         every branch of the serial protocols is tested"
	@echo "make fuzz             bad input for Modbus, 3964R and RK512 from a seed (FUZZ='--seed 7 --seconds 600 --only rk512')"

# ------------------------------------------------------------------------------------------------------------- set-up

setup: $(STAMP) native

$(STAMP): requirements.lock pyproject.toml
	@sh hil_tests/rig/setup.sh python $(PYTHON)
	@test -x $(PY) || $(PYTHON) -m venv $(VENV)
	@echo "set-up: installing requirements.lock into $(VENV)"
	@$(PY) -m pip install --quiet --disable-pip-version-check -r requirements.lock
	@$(PY) -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

$(JUDGES): $(STAMP) hil_tests/requirements.lock
	@echo "set-up: installing hil_tests/requirements.lock into $(VENV): the judges of the tests, about 1 GB"
	@$(PY) -m pip install --quiet --disable-pip-version-check -r requirements.lock -r hil_tests/requirements.lock
	@touch $@

judges: $(JUDGES)

tools:
	@sh hil_tests/rig/setup.sh tools $(PYTHON)

# The guest's kernel with a clock of its own; without it the guest runs on Debian's kernel.
kernel: tools
	@sh hil_tests/rig/uml/kernel.sh build/guest-kernel

# C references of the benchmarks: hil_tests/bench/NAME.c becomes build/NAME.  One that does not build fails lane cref, not make.
references: tools
	@$(MAKE) --no-print-directory --keep-going $(REFERENCES) || echo "references: not all built; lane cref says which"

# Packages for the other Pythons of this machine, those of another minor version (lane pythons).
pythons: $(STAMP)
	@$(PY) -m hil_tests.lab.running.pythons || echo "pythons: not all prepared; lane pythons says which"

# Parts of the cycle in C (AX-320).  Without a compiler or Python's headers their Python twins run, and a line says so.
native: $(STAMP)
	@$(PY) -m gateway.cycle.native.build || true

build/%: hil_tests/bench/%.c
	@mkdir -p build
	$(CC) -O2 -Wall -Wextra -pthread -o $@ $< $$(sed -n 's|^ \*  *build: ||p' $<)

# --------------------------------------------------------------------------------------------------------------- work
# make itself ends with 2 whenever a recipe fails, whatever the recipe's own code was (it stands in make's message "Error N").

# A kernel is never built here: that takes minutes, or much longer on a machine that is busy anyhow.
demo: $(STAMP) native
	@$(VENV)/bin/axisgate demo $(DEMO); code=$$?; [ $$code -eq 4 ] || exit $$code; \
	if [ -x build/guest-kernel ]; then \
		echo "make demo: this machine is too busy to run the demo in real time: once more in the guest, which has a clock of its own (AX-591)"; \
		exec $(VENV)/bin/axisgate demo --own-time $(DEMO); \
	fi; \
	echo "make demo: this machine is too busy to run the demo in real time. End other programs and try again, or type:"; \
	echo "    make kernel                  builds a guest with a clock of its own: once, some minutes and 1.5 GB while it builds; Debian, linux-source-6.1"; \
	echo "    make demo DEMO=--own-time    runs the demo in it"; \
	exit 4

lint: $(JUDGES)
	@mkdir -p build
	$(VENV)/bin/ruff format --check --quiet .
	$(VENV)/bin/ruff check --quiet .
	$(VENV)/bin/mypy
	$(PY) -m hil_tests.matrix.spelled
	$(PY) -m hil_tests.house.words
	$(PY) -m hil_tests.house.dead
	@$(VENV)/bin/lint-imports --no-cache > build/import-contracts.txt 2>&1 && tail -n 2 build/import-contracts.txt || { cat build/import-contracts.txt; exit 1; }

# Pure tests only, by two processes; no process, port or clock takes part, so it may run on a busy machine.
PURE := hil_tests/unit hil_tests/requirements hil_tests/properties
SLOWEST := --durations=10
check: $(JUDGES) native
	@lint=0; $(MAKE) --no-print-directory lint || lint=1; \
	$(PY) -m pytest -q --pair $(SLOWEST) $(PURE); tests=$$?; \
	test $$lint -eq 0 || { echo "make check: lint failed (above the tests)" >&2; exit 1; }; \
	exit $$tests

# Lint and branches first, beside each other, then all tests whatever they said; pytest's closing line is the last one.
test: $(JUDGES) references native kernel pythons
	@mkdir -p build || exit 1; $(MAKE) --no-print-directory branches > build/branches.txt 2>&1 & pid=$$!; trap "kill $$pid" INT TERM; \
	lint=0; $(MAKE) --no-print-directory lint || lint=1; \
	branches=0; wait $$pid || branches=1; trap - INT TERM; cat build/branches.txt; \
	$(PY) -m pytest $(SLOWEST) --matrix=build/matrix/results.json; tests=$$?; \
	test $$lint -eq 0 || { echo "make test: lint failed (above the tests)" >&2; exit 1; }; \
	test $$branches -eq 0 || { echo "make test: a branch of the serial protocols is not tested (above the tests)" >&2; exit 1; }; \
	exit $$tests

bench: $(JUDGES) references native
	@$(VENV)/bin/axisgate bench $(or $(BENCH),all)

coverage-matrix: $(JUDGES) references native kernel
	@$(PY) -m hil_tests.matrix.coverage $(MATRIX)

mutants: $(JUDGES) references native kernel
	@$(PY) -m hil_tests.matrix.mutants $(MUTANTS)

DOCS := build/docs-env
$(DOCS)/installed.stamp: docs/requirements.lock
	@$(PYTHON) -m venv $(DOCS)
	@$(DOCS)/bin/python -m pip install --quiet --disable-pip-version-check -r docs/requirements.lock
	@touch $@

docs: $(STAMP) $(DOCS)/installed.stamp  # pages that stand in the tree, then the site in build/site
	@$(PY) docs/assemble.py
	@$(PY) docs/site_pages.py
	@NO_MKDOCS_2_WARNING=1 $(DOCS)/bin/mkdocs build --quiet --strict --config-file build/mkdocs.yml
	@echo "docs: build/site/index.html"

pictures: $(JUDGES)  # the page's pictures from the last run of its tests (hil_tests/rig/web) into docs/pictures
	@$(PY) docs/keep_pictures.py

soak: $(JUDGES)
	@$(PY) -m hil_tests.soak $(SOAK)
	@$(PY) -m hil_tests.soak.motion $(MOTION)
	@AXISGATE_POLE_LINES=$(or $(POLE),10000) AXISGATE_WHOLE_CURVE=1 $(PY) -m pytest -q hil_tests/properties/test_pole_lines.py hil_tests/unit/motion/program/test_slow_programs.py
	@AXISGATE_STORM=60000 $(PY) -m pytest -q hil_tests/rig/canopen/test_emergency_storm.py
	@AXISGATE_PALTEST_KILLS=$(or $(KILLS),200) $(PY) -m pytest -q hil_tests/rig/programs/test_robotstar_guide.py -k killed
	@$(PY) -m hil_tests.soak.hostile $(HOSTILE)
	@$(MAKE) --no-print-directory losses

losses: $(STAMP)  # 100 deaths of the cycle: killed and stopped, boosters and CiA 402 drives, 25 each
	@AXISGATE_TEST_ON_HOST=1 AXISGATE_LOSSES=25 $(PY) -m pytest -q hil_tests/rig/death/test_cycle_dies.py hil_tests/rig/death/test_cycle_dies_402.py hil_tests/rig/death/loss_by_the_bus.py

SERIAL := protocols/p3964r,protocols/rk512,protocols/buep64,protocols/telegrams
branches: $(STAMP)
	@mkdir -p build
	@COVERAGE_FILE=build/branches $(PY) -m coverage run --branch --source=$(SERIAL) -m pytest -q -p no:cacheprovider $(foreach part,p3964r rk512 buep64,hil_tests/requirements/$(part)) hil_tests/unit/protocols/telegrams
	@COVERAGE_FILE=build/branches $(PY) -m coverage report --show-missing --skip-covered --fail-under=100

fuzz: $(STAMP)
	@$(PY) -m hil_tests.fuzz $(FUZZ)

# ---------------------------------------------------------------------------------------------------------- upkeep

lock:  # renews requirements.lock from the ranges of pyproject.toml, in an environment of its own
	$(PYTHON) -m venv build/lock && build/lock/bin/python -m pip install --quiet --editable '.[test]'
	{ head -n 1 requirements.lock; build/lock/bin/python -m pip freeze --exclude-editable; } > build/lock/small.txt
	build/lock/bin/python -m pip install --quiet --editable '.[test,judges]' -c build/lock/small.txt
	{ head -n 1 hil_tests/requirements.lock; build/lock/bin/python -m pip freeze --exclude-editable | grep -vxFf build/lock/small.txt; } > build/lock/judges.txt
	mv build/lock/small.txt requirements.lock && mv build/lock/judges.txt hil_tests/requirements.lock

clean:
	rm -rf build gateway/cycle/native/*.so .mypy_cache .ruff_cache .pytest_cache .hypothesis
