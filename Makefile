# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# Thin, over CMake. `make demo` and `make check` need nothing but a Debian machine with root or sudo.
BUILD  ?= build
PREFIX ?= /usr/local
JOBS   ?= $(shell nproc)
PYTHON ?= $(firstword $(wildcard /usr/bin/python3) python3)
SCENE  ?= params/flume.yaml
RESULT ?= runs/$(basename $(notdir $(SCENE))).h5
# More for cmake, such as CMAKE_ARGS="-DRY_NATIVE=ON"
CMAKE_ARGS ?=

MAKEFLAGS += --no-print-directory

.PHONY: all build setup setup-check setup-bench demo check bench validity install docs instructions format lint clean

all: build

setup:
	@bash cmake/setup-debian.sh build

setup-check:
	@bash cmake/setup-debian.sh check

setup-bench:
	@bash cmake/setup-debian.sh bench

build: setup
	@cmake -S . -B $(BUILD) $(CMAKE_ARGS) >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS) --target ryusa_program ryusa

demo: build
	@mkdir -p runs
	$(BUILD)/ryusa run $(SCENE) -o $(RESULT) --force
	$(PYTHON) -B postprocess/all.py $(RESULT)
	@echo
	@echo "Done. The result is $(RESULT) (look inside: $(BUILD)/ryusa info $(RESULT));"
	@echo "pictures and films are in runs/."

check: setup-check
	@cmake -S . -B $(BUILD) -DRY_WERROR=ON $(CMAKE_ARGS) >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS)
	ctest --test-dir $(BUILD) --output-on-failure --parallel $(JOBS)

# Speed of this machine, alone and against LAMMPS, LIGGGHTS and YADE (Debian's packages), and whole jobs against LAMMPS:
# bench-speed, bench-peers and bench-jobs, .csv and .png, in runs/. Half an hour; `make bench QUICK=--quick`: some minutes.
QUICK ?=
bench: setup-bench build
	@mkdir -p runs
	$(BUILD)/ryusa bench speed -o runs/bench-speed.h5 --force $(QUICK)
	$(PYTHON) -B tests/peers/peers.py --ryusa $(BUILD)/ryusa --csv runs/bench-peers.csv $(QUICK)
	$(PYTHON) -B tests/peers/jobs.py --ryusa $(BUILD)/ryusa --csv runs/bench-jobs.csv $(QUICK)
	$(PYTHON) -B postprocess/bench.py runs/bench-speed.h5
	$(PYTHON) -B postprocess/bench.py runs/bench-peers.csv
	$(PYTHON) -B postprocess/bench.py runs/bench-jobs.csv

# q* of three grains against relations, and its convergence: tables and pictures in runs/validity/results.
validity: build
	@runs/validity/run.sh $(BUILD)/ryusa

install: build
	cmake --install $(BUILD) --prefix $(PREFIX)

# Pages that are made from the source; the tests check that they are up to date.
docs: build
	$(BUILD)/ryusa show --parameters > docs/parameters.md

# The table of tests/test_instructions.py, after a change that costs or saves instructions.
instructions: setup-check build
	RY_UPDATE=1 RYUSA=$(abspath $(BUILD))/ryusa SOURCE_DIR=$(CURDIR) BUILD_DIR=$(abspath $(BUILD)) \
	    $(PYTHON) -B tests/test_instructions.py

# Of C files, the lines that differ from the last commit.
CHANGED = git clang-format --binary $$(command -v clang-format-14 || command -v clang-format) --extensions c,h HEAD
format:
	$(CHANGED) --force

lint:
	@diff=$$($(CHANGED) --diff -q); [ -z "$$diff" ] || { echo "$$diff"; echo "make format would change this"; false; }
	$(PYTHON) -B tests/test_layers.py

clean:
	rm -rf $(BUILD)
