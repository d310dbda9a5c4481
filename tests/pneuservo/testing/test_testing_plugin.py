"""The example of the documentation, run by pytest as a user's: the fixture is there by itself."""

import shutil
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[3] / "docs" / "example_test_tuning.py"
FAILING = """
from pneuservo.testing import assert_settles_within

def test_step(closed_loop):
    assert_settles_within(closed_loop("proportional", demand="15,24 mm"), "10 ms")
"""


def test_the_example_runs_where_nothing_else_is_and_failures_are_short(tmp_path):
    shutil.copy(EXAMPLE, tmp_path / "test_tuning_example.py")
    (tmp_path / "test_failing.py").write_text(FAILING)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert "1 failed, 3 passed" in done.stdout
    assert "step from 15 to 24 mm at t = 0.5 s: settles after" in done.stdout
    assert "controller: proportional, gain = 1, level = 5" in done.stdout
    # What is shown is the user's own line, not the inside of the package.
    assert "test_failing.py:5: AssertionError" in done.stdout
    assert "words.py" not in done.stdout


def test_the_plugin_is_light():
    """Every pytest of the environment loads it, also where nothing of this package is used."""
    code = (
        "import sys, pneuservo.pytest_plugin; "
        "print([name for name in ('numba', 'numpy', 'pneuservo.testing') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
