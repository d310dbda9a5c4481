# make run [RECORDING=FILE]   set up, then the main job; prints where the report is
# make test                   set up, then checks and tests
# make check                  lint, format and types
# make bench                  what is measured, as ratios, and benchmarks/results.json
# make clean                  remove everything that was made
.DEFAULT_GOAL := run
.PHONY: run test check bench clean
BIN := .venv/bin

.venv/.ready: pyproject.toml constraints.txt .ci/setup
	@.ci/setup

run: .venv/.ready
	@$(BIN)/pneuservo demo --out out/demo $(if $(RECORDING),--recording "$(RECORDING)")

check: .venv/.ready
	@$(BIN)/ruff check --quiet .
	@$(BIN)/ruff format --check --quiet .
	@$(BIN)/mypy --no-error-summary

test: check
	@$(BIN)/python -m pytest -n 2 --dist loadfile

bench: .venv/.ready
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv out .pytest_cache .mypy_cache .ruff_cache
