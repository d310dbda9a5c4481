# make run [RECORDING=FILE]   set up, then the main job; prints where the report is
# make test                   set up, then checks and tests
# make check                  lint, format and types
# make benchmark              what is measured, as ratios
# make clean                  remove everything that was made
.DEFAULT_GOAL := run
.PHONY: run test check benchmark clean
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
	@$(BIN)/python -m pytest

benchmark: .venv/.ready
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv out .pytest_cache .mypy_cache .ruff_cache
