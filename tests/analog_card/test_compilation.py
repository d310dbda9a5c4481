"""Compiled code is kept for as long as the physics that it came from."""

import subprocess
import sys

import pytest

from analog_card import compilation


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return the folder of a package whose kernel takes a constant from a file without kernels."""
    monkeypatch.setattr(compilation.platformdirs, "user_cache_dir", lambda name: tmp_path / name)
    folder = tmp_path / "pumps"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "limits.py").write_text("LARGEST = 3.0\n")
    (folder / "words.py").write_text("def greeting():\n    return 'hello'\n")
    (folder / "kernel.py").write_text(
        "from numba import njit\n\nfrom pumps.limits import (\n    LARGEST,\n)\n"
        "from pumps.words import greeting\n"
    )
    return folder


def test_the_folder_changes_with_a_constant_that_a_kernel_takes(package):
    before = compilation.kernel_folder(package)
    assert compilation.kernel_folder(package) == before
    (package / "limits.py").write_text("LARGEST = 4.0\n")
    assert compilation.kernel_folder(package) != before


def test_the_folder_stays_when_nothing_changed_that_a_kernel_takes(package):
    before = compilation.kernel_folder(package)
    (package / "words.py").write_text("def greeting():\n    return 'good morning'\n")
    assert compilation.kernel_folder(package) == before


PUMPS = """
import pickle
from pathlib import Path

from analog_card.compilation import compile_kernel

HERE = Path(__file__).parent / "compiled"


def compiled(function):
    return compile_kernel(function, HERE)


@compiled
def flow(speed):
    return 2.0 * speed


@compiled
def power(speed):
    return flow(speed) * speed


if __name__ == "__main__":
    import pumps

    assert pickle.loads(pickle.dumps(pumps.power)) is pumps.power
    print(pumps.power(3.0), pumps.flow(3.0), sum(pumps.power._called.stats.cache_hits.values()))
"""


def test_a_kernel_is_called_taken_in_and_found_again_in_another_process(tmp_path):
    (tmp_path / "pumps.py").write_text(PUMPS)
    said = [
        subprocess.run(
            [sys.executable, "pumps.py"], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout.split()
        for _ in range(2)
    ]
    assert said == [["18.0", "6.0", "0"], ["18.0", "6.0", "1"]]
