# make demo: three simulated wells through every stage.  make test, make lint.  Needs make and python3 only.
.DEFAULT_GOAL := help
.PHONY: help setup demo rigs run field bench bench-fleet blind learn discoveries test mutants lint format lock docs site tutorial gallery clean

UV_VERSION := 0.13.8
BIN := .venv/bin
COMMAND := $(BIN)/drillid
READY := .venv/ready
KERNELS := .venv/kernels
PROFILE ?= workflow/profiles/default
TUTORIAL ?= docs
JOBS ?=
STRICT ?= 1
RUN := $(COMMAND) run --profile $(PROFILE) $(if $(JOBS),--jobs $(JOBS)) $(if $(filter 0,$(STRICT)),--no-strict)

# compiled bytecode saves most of the imports' time; some machines switch it off
unexport PYTHONDONTWRITEBYTECODE
# compiled kernels live as long as the environment
export NUMBA_CACHE_DIR := $(CURDIR)/.venv/numba

help:
	@echo "make demo    three small simulated wells from raw logs to results/demo/report.html"
	@echo "make run     the wells of config/wells.tsv; JOBS=4 for four cores, STRICT=0 to end with 0 although wells failed"
	@echo "make rigs    the wells of config/shared-rigs"
	@echo "make field   start of rotation of a real well, beside its measurement in ../shared/data/field"
	@echo "make bench   accuracy and speed of identification beside their targets, and a comparison with other tools"
	@echo "make bench-fleet    what a fleet costs and survives: planning, overhead, speed-up, nights, faults; PARTS=plan for some"
	@echo "make blind   hidden causes, drawn and simulated, against the discovery engine; WORLD=other FIRST=60000 CASES=40 for a look"
	@echo "make learn   causes that only a fleet shows, and what is learnt where no cause explains; PARTS=… for some"
	@echo "make discoveries    what the simulations get wrong on wells, motor bench and field start, and why"
	@echo "make test    all tests;  make lint    all checks of code and workflow"
	@echo "make mutants    faults put into a copy of the library on purpose, which its tests must catch; ROOMS=records for some"
	@echo "make docs    write the generated documents again;  make lock    renew requirements.lock"
	@echo "make site    the documentation as a site in results/site"
	@echo "make gallery     every figure of a well of the demo, and the page that shows them"
	@echo "make tutorial    run the tutorials, docs/*.py, and write their pages with figures"

setup: $(READY) $(COMMAND) $(KERNELS)

$(READY): requirements.lock
	python3 -m venv .venv
	$(BIN)/python -m pip install --quiet uv==$(UV_VERSION)
	$(BIN)/uv pip sync --require-hashes --compile-bytecode --python $(BIN)/python requirements.lock
	touch $@

# made here with a line for each, so that the first wells need not wait for them
$(KERNELS): $(READY) $(shell find drillid/compiled.py drillid/physics drillid/fits drillid/simulation -name '*.py' 2>/dev/null)
	$(BIN)/python -m scripts.compile_kernels
	touch $@

$(COMMAND): scripts/drillid.sh $(READY)
	install -m 755 scripts/drillid.sh $@

demo: setup
	$(RUN) --configfile config/demo/config.yaml

rigs: setup
	$(RUN) --configfile config/shared-rigs/config.yaml

run: setup
	$(RUN)

field: $(READY)
	$(BIN)/python -m benchmarks.field.start_up
	$(BIN)/python -m benchmarks.field.transfer

# times are those of one core
bench: export OPENBLAS_NUM_THREADS := 1
bench: $(READY)
	$(BIN)/python -m benchmarks.identification.bench

# wells are simulated once and kept in results/bench-fleet
bench-fleet: export OPENBLAS_NUM_THREADS := 1
bench-fleet: setup
	$(BIN)/python -m benchmarks.fleet $(PARTS)

# hours from nothing; what is done already is kept in results/blind
blind: export OPENBLAS_NUM_THREADS := 1
blind: $(READY)
	$(BIN)/python -m benchmarks.blind$(if $(REGISTER),.register) $(if $(WORLD),--world $(WORLD)) $(if $(FIRST),--first $(FIRST)) $(if $(CASES),--cases $(CASES)) $(if $(MINUTES),--minutes $(MINUTES))

# hours from nothing; what is simulated is kept in results/learn
learn: export OPENBLAS_NUM_THREADS := 1
learn: $(READY)
	$(BIN)/python -m benchmarks.learn $(PARTS)

# the wells' verdicts first, as far as they are missing or out of date
discoveries: export OPENBLAS_NUM_THREADS := 1
discoveries: setup
	test ! -d ../shared/data/rig-logs || $(RUN) --configfile config/shared-rigs/config.yaml
	$(BIN)/python -m benchmarks.discoveries

# three processes on two cores, as a test of the workflow waits for what it starts; threads would wait for each other
test: export OPENBLAS_NUM_THREADS := 1
test: setup
	env $$($(BIN)/python -m tests.memory) $(BIN)/python -m pytest -n 3 --dist loadscope --no-loadscope-reorder tests

# two at a time; one thread each
mutants: export OPENBLAS_NUM_THREADS := 1
mutants: $(READY)
	$(BIN)/python -m tests.mutants $(ROOMS)

lint: $(READY)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/mypy --strict drillid
	$(BIN)/lint-imports --no-cache
	$(BIN)/vulture
	$(BIN)/oxlint --deny-warnings drillid/report/templates
	$(BIN)/snakemake --lint --configfile config/demo/config.yaml

format: $(READY)
	$(BIN)/ruff check --fix
	$(BIN)/ruff format
	$(BIN)/snakefmt Snakefile workflow

docs: $(READY)
	$(BIN)/python -m scripts.write_documents

# warnings are errors
site: $(READY)
	NO_MKDOCS_2_WARNING=1 PYTHONPATH=. $(BIN)/mkdocs build --quiet --strict

tutorial: $(READY)
	$(BIN)/python -m scripts.write_tutorial $(TUTORIAL)

# the figures of a demo well, which is run first as far as it is missing or out of date
gallery: demo
	$(BIN)/python -m scripts.write_gallery

# uv.lock names hosts, so only its export is kept
lock: $(READY)
	$(BIN)/uv lock --upgrade
	$(BIN)/uv export --frozen --all-extras --no-emit-project --no-header --no-annotate --no-emit-index-url --output-file requirements.lock
	$(BIN)/python -m scripts.write_documents

clean:
	rm -rf .snakemake .pytest_cache .mypy_cache .ruff_cache .hypothesis results/demo
