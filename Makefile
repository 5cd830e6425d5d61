# lamc: everything a newcomer needs is `make demo` and `make test`. Each sets up its own environment first.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out/demo
STAMP := $(VENV)/.lamc-installed
PARALLEL ?= -n 2 --dist worksteal # neighbours stay with one worker, which has what a module's tests share

.PHONY: demo test test-ci test-hostile test-all lint types format docs map methods bench ledgers pictures clean check-tools

demo: $(STAMP)
	$(BIN)/lamc split lamc/examples/pendulum.cad --out $(OUT)
	$(BIN)/lamc run lamc/examples/pendulum.cad --t-end 10 --rtol 1e-9 --film --out $(OUT)
	$(BIN)/lamc check lamc/examples/pendulum.cad
	$(BIN)/lamc bench lamc/examples/pendulum.cad --out $(OUT)
	$(BIN)/lamc plate --example strip --out $(OUT)/plate
	@echo
	@echo "Look into $(OUT): folded.png, angles_energy.png, split.png, bench.png, the animation, results.csv; plate/deflection.png"

test: $(STAMP)
	$(BIN)/python -m pytest -q $(PARALLEL) -m "not slow"

test-ci: $(STAMP) # all tests but the campaigns
	$(BIN)/python -m pytest -q $(PARALLEL) -m "not campaign" --thorough

test-hostile: $(STAMP) # umask 077, a home that cannot be written, stderr closed; with another compiler: CC=clang
	$(BIN)/python -m pytest -q $(PARALLEL) -m "not slow" --hostile -p no:faulthandler 2>&-

test-all: $(STAMP) # campaigns too, with new examples of hypothesis, with the flags that users get, and with the peers that some tests need: MuJoCo, CasADi, FMPy, zig
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[bench,fmi,cc]'
	$(BIN)/python -m pytest -q $(PARALLEL) --as-shipped --new-examples

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-cache
	$(BIN)/clang-format --dry-run -Werror runtime_c/include/*.h runtime_c/src/*.[ch] runtime_c/ensemble/*.[ch] runtime_c/sensitivity/*.[ch] runtime_c/adjoint/*.[ch] runtime_c/absent/*.[ch] runtime_c/bare/*.h runtime_c/plate/*.[ch] runtime_c/mesher/*.[ch] runtime_c/tests/*.[ch]
	$(BIN)/clang-format --style=file:runtime_c/.clang-format --dry-run -Werror templates/export/fmu/*.[ch]

types: $(STAMP)
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/clang-format --style=file:runtime_c/.clang-format -i templates/export/fmu/*.[ch]
	$(BIN)/clang-format -i runtime_c/include/*.h runtime_c/src/*.[ch] runtime_c/ensemble/*.[ch] runtime_c/sensitivity/*.[ch] runtime_c/adjoint/*.[ch] runtime_c/absent/*.[ch] runtime_c/bare/*.h runtime_c/plate/*.[ch] runtime_c/mesher/*.[ch] runtime_c/tests/*.[ch]

docs: $(STAMP) # the pages as a site, in out/site; a link that leads nowhere is an error
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "Look into out/site: index.html"

map: $(STAMP) # docs/map.md: every module in a line
	$(BIN)/python docs/make_map.py

methods: $(STAMP) # what C and the guide say of the integrators, from lamc/run/methods.py
	$(BIN)/python docs/make_methods.py

bench: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[bench]'
	$(BIN)/python -m benchmarks.spine
	$(BIN)/python -m benchmarks.hard_cases
	$(BIN)/python -m benchmarks.sheets
	$(BIN)/python -m benchmarks.plates
	$(BIN)/python -m benchmarks.precision
	$(BIN)/python -m benchmarks.other_engines
	$(BIN)/python -m benchmarks.embedding
	$(BIN)/python -m benchmarks.ensembles
	$(BIN)/python -m benchmarks.gradients

ledgers: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[bench]'
	$(BIN)/python -m benchmarks.ledgers

pictures: $(STAMP)
	$(BIN)/lamc run lamc/examples/pendulum.cad --t-end 10 --out out/pictures
	cp out/pictures/folded.png docs/pendulum.png
	$(BIN)/lamc examples --picture docs/gallery.png
	$(BIN)/lamc plate --example strip --out out/pictures
	cp out/pictures/deflection.png docs/plate.png

clean:
	rm -rf $(VENV) out build dist

check-tools:
	@command -v $(PYTHON) >/dev/null || { echo "lamc needs Python 3.11 or newer, and '$(PYTHON)' is not there: install python3, or set PYTHON=…"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "lamc needs Python 3.11 or newer; '$(PYTHON)' is older: set PYTHON=…"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "Python's venv module is missing: install it (Debian: apt install python3-venv)"; exit 1; }
	@command -v $${CC:-cc} >/dev/null || { echo "a C compiler is missing: install gcc or clang (Debian: apt install gcc libc6-dev), or set CC=…"; exit 1; }

# Python compiles what is used when it is first used: pip would compile all of ten thousand files.
$(STAMP): pyproject.toml packaging_hook.py | check-tools
	@test -x $(BIN)/python || { echo "Setting up $(VENV) (once) …"; $(PYTHON) -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -e '.[test,lint]'
	@touch $@
