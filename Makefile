# The project's commands; `make help` lists them.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules

# All paths are relative to the repository root, also for make -C and -f.
ROOT := $(patsubst %/,%,$(dir $(abspath $(lastword $(MAKEFILE_LIST)))))
BIN := $(ROOT)/.venv/bin
IN_ROOT := cd "$(ROOT)" &&

# Options of `make plan`; `pathgene plan --help` explains them.
TERRAIN ?= jacksboro
# Start and goal: metres east and north of the south-west corner, metres above ground.
START ?= 2300,2500,100
GOAL ?= 26900,28400,100
NOFLY_CIRCLES ?= 10900,11600,2100 18300,19400,2100
BOARD ?= sim:
# Planners to compare with, on the same problem.
BESIDE ?= ga-fpga,astar
SEED ?= 1
# Milliseconds of the plan by the clock of the chip, on sim: and model: alone, where they take a minute.
CHIP_MS ?= 20
OUT ?= out/plan

# Turbulence of `make fly`, and what happens in it.
GUSTS ?= light
SCENARIO ?= examples/storm.toml

# Options of `make sim` (default: all benches on both simulators), `make bench`, `make formal`
# (default: all proofs), `make faults` and `make test`; chip of `make bitstream`.
CHIP ?=
SIM ?=
BENCH ?=
ONLY ?=
WAVES ?=
PROOF ?=
SEEDS ?= 0:300
WORKERS ?= 2
PYTEST_ARGS ?=

# The tools get these as arguments; as environment variables they could have other effects.
unexport CHIP SIM BENCH ONLY WAVES PROOF SEEDS

# The first Python that is new enough, starting with that of .venv; the script exits with 75 if its
# Python is too old. -ES makes the start quick.
define SET_UP
	@for python in "$(BIN)/python" python3 python3.13 python3.12 python3.11; do \
		command -v "$$python" > /dev/null || continue; \
		status=0; \
		"$$python" -ES "$(ROOT)/tools/setup.py" $(1) || status=$$?; \
		[ $$status -eq 75 ] || exit $$status; \
	done; \
	echo "setup: Python 3.11 or newer is missing; install the Debian package python3." >&2; \
	exit 1
endef

.PHONY: help
help:
	@echo "make plan       plan over real terrain by the planner core, in the simulated board,"
	@echo "                and with the paper's ga-fpga and with astar beside it"
	@echo "                (TERRAIN= START= GOAL= NOFLY_CIRCLES= BOARD= BESIDE= SEED= OUT=)"
	@echo "make fly        the same, then fly the path in a flight-dynamics model, with zones that"
	@echo "                appear, replanned by the chip (and GUSTS= SCENARIO=)"
	@echo "make desk       a local web page to draw problems, plan them and compare the plans (OUT=out/desk)"
	@echo "make setup      install what the tests need, once"
	@echo "make test       the tests of minutes (WORKERS= PYTEST_ARGS=)"
	@echo "make test-ci    the costly tests: full sizes, lint, smoke tests of benchmarks"
	@echo "make test-long  all tests: hours of random and soak runs"
	@echo "make coverage   unit tests of the protocol and of the link: every branch of hdl/protocol and"
	@echo "                host/device must run; of the host's verdict: 95 % of the branches, and a pair of"
	@echo "                cases for each condition of the strict rule; writes docs/reliability.md"
	@echo "make verilog    synthesizable Verilog of every top, in build/verilog/"
	@echo "make bitstream  place and route for a real board, with open tools"
	@echo "                (BOARD=ulx3s-85f CHIP=planner|paper)"
	@echo "make sim        cocotb benches on Icarus and Verilator (SIM= BENCH= WAVES=1)"
	@echo "make formal     prove claims about the gateware with Yosys and Z3 (PROOF=)"
	@echo "make faults     sessions with faults of line, chip, clock, disk and signals, decided by seeds"
	@echo "                (SEEDS=0:300 BOARD=model: or sim:)"
	@echo "make bench      measure every speed claim (BENCH=; of fpga, flight, quality and safety, rows named like ONLY=)"
	@echo "make wheel      a wheel with compiled kernels, so that an installation compiles nothing (OUT=dist)"
	@echo "make docs       the documentation as a site, in build/docs/ (open index.html)"
	@echo "make lint       ruff (rules and format), mypy, the rules of imports, Verilator's lint of the"
	@echo "                generated Verilog"
	@echo "make clean      remove everything generated but .venv/"

.PHONY: setup setup-plan
setup:
	$(call SET_UP,test)

setup-plan:
	$(call SET_UP,plan)

.PHONY: plan
plan: setup-plan
	@$(IN_ROOT) "$(BIN)/pathgene" plan --terrain "$(TERRAIN)" --agl --start "$(START)" --goal "$(GOAL)" \
		$(foreach circle,$(NOFLY_CIRCLES),--nofly-circle "$(circle)") \
		--board "$(BOARD)" $(if $(filter sim: model:,$(BOARD)),--chip-ms "$(CHIP_MS)") --seed "$(SEED)" $(if $(BESIDE),--beside "$(BESIDE)") \
		--write plan,kml --out "$(OUT)"

.PHONY: fly
fly: setup plan
	@$(IN_ROOT) "$(BIN)/pathgene" fly "$(OUT)/summary.json" --gusts "$(GUSTS)" --seed "$(SEED)" \
		--scenario "$(SCENARIO)" --planner ga-chip --board "$(BOARD)"

.PHONY: desk
desk: OUT = out/desk
desk: setup
	@$(IN_ROOT) "$(BIN)/pathgene" desk --open --out "$(OUT)"

.PHONY: setup-long
setup-long:
	$(call SET_UP,long)

# The C library keeps freed memory. Returning it to the kernel takes up to half of a test's time.
# Bytecode is kept, whatever the caller's environment says: without it, every run compiles the tests.
PYTEST = MALLOC_MMAP_THRESHOLD_=33554432 MALLOC_TRIM_THRESHOLD_=1073741824 PYTHONDONTWRITEBYTECODE= \
	"$(BIN)/python" -m pytest -n $(WORKERS) --dist worksteal

# A test that hangs ends with the tracebacks of its threads and fails; a new worker runs the rest.
# The largest take 40 s on an idle machine. Long tests have no limit.
LIMIT = -o faulthandler_timeout=600 -o faulthandler_exit_on_timeout=true

.PHONY: test test-ci test-long
test: setup
	@$(IN_ROOT) status=0; $(PYTEST) $(LIMIT) $(PYTEST_ARGS) || status=$$?; \
		echo "make test: $$SECONDS s" >&2; exit $$status

test-ci: setup
	@$(IN_ROOT) $(PYTEST) $(LIMIT) -m "ci and not long" $(PYTEST_ARGS)

test-long: setup-long
	@$(IN_ROOT) $(PYTEST) -m "long or not long" $(PYTEST_ARGS)

# The left-out test runs 2,000 generations of what others run with fewer.
.PHONY: coverage
coverage: setup
	@$(IN_ROOT) "$(BIN)/python" -m coverage run -m pytest -q -p no:cacheprovider -m "not long" -k "not rank-2000" \
		tests/unit/protocol tests/unit/device
	@$(IN_ROOT) "$(BIN)/python" -m coverage report
	@$(IN_ROOT) "$(BIN)/python" -m tools.conditions --workers $(WORKERS)

.PHONY: verilog
verilog: setup-plan
	@$(IN_ROOT) "$(BIN)/python" -m pathgene.hdl.verilog build/verilog

.PHONY: setup-synth bitstream
setup-synth:
	$(call SET_UP,synth)

bitstream: setup-synth
	@$(IN_ROOT) "$(BIN)/python" -m pathgene.hdl.boards.build "$(BOARD)" $(if $(CHIP),--chip "$(CHIP)")

.PHONY: sim
sim: setup
	@$(IN_ROOT) "$(BIN)/python" -m tools.runner $(if $(SIM),--sim "$(SIM)") \
		$(if $(BENCH),--bench "$(BENCH)") $(if $(filter-out 0,$(WAVES)),--waves)

.PHONY: formal
formal: setup
	@$(IN_ROOT) "$(BIN)/python" -m tools.formal $(if $(PROOF),--proof "$(PROOF)")

.PHONY: faults
faults: BOARD = model:
faults: setup
	@$(IN_ROOT) "$(BIN)/python" -m tools.faults --board "$(BOARD)" --seeds "$(SEEDS)"

.PHONY: bench
bench: setup $(if $(filter fpga,$(BENCH)),setup-synth)
	@$(IN_ROOT) "$(BIN)/python" -m bench $(if $(BENCH),"$(BENCH)") $(if $(ONLY),--only "$(ONLY)")

.PHONY: wheel
wheel: OUT = dist
wheel: setup
	@$(IN_ROOT) "$(BIN)/python" -m tools.wheel --out "$(OUT)"

.PHONY: docs
docs: setup
	@$(IN_ROOT) "$(BIN)/python" -m tools.protocol_page
	@$(IN_ROOT) "$(BIN)/python" -m sphinx -W --keep-going -q -b html docs build/docs
	@echo "$(ROOT)/build/docs/index.html"

.PHONY: lint
lint: setup verilog
	@$(IN_ROOT) "$(BIN)/ruff" check .
	@$(IN_ROOT) "$(BIN)/ruff" format --check --quiet .
	@$(IN_ROOT) "$(BIN)/mypy"
	@$(IN_ROOT) PYTHONPATH=. "$(BIN)/lint-imports" --no-logo --no-cache
	@$(IN_ROOT) "$(BIN)/python" -m tools.lint build/verilog/*.v

.PHONY: clean
clean:
	@$(IN_ROOT) rm -rf build dist out *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
