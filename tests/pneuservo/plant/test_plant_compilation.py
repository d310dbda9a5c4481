"""Where compiled code is kept, and what happens where it cannot be."""

import os
import subprocess
import sys

import numba
import pytest

from pneuservo.plant import compilation


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of three files, two of them with kernels, and an empty cache."""
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "gas.py").write_text("from pneuservo.plant.compilation import compiled\n")
    (folder / "valve.py").write_text("from pneuservo.plant.compilation import compiled\nx = 1\n")
    (folder / "plots.py").write_text("")
    monkeypatch.setattr(compilation, "_PACKAGE", folder)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    compilation.cache_folder.cache_clear()
    yield folder
    compilation.cache_folder.cache_clear()


def folder_now():
    compilation.cache_folder.cache_clear()
    return compilation.cache_folder()


def test_any_kernel_file_decides_the_folder(package):
    before = folder_now()
    assert before.is_dir()
    (package / "plots.py").write_text("changed = True\n")
    assert folder_now() == before
    (package / "valve.py").write_text("from pneuservo.plant.compilation import compiled\nx = 2\n")
    assert folder_now() != before


def test_other_users_of_the_compiler_keep_their_cache(package):
    before = numba.config.CACHE_DIR
    compilation.compiled(lambda x: x)
    assert before == numba.config.CACHE_DIR


def test_a_cache_that_cannot_be_written_only_costs_time():
    program = (
        "from pneuservo.plant import compilation, gas\n"
        "assert compilation.cache_folder() is None\n"
        "print(gas.ideal_gas(293.0, 287.0, 1.4).critical_pressure_ratio)\n"
    )
    # No folder can be made below a device, not even by root.
    environment = {**os.environ, "XDG_CACHE_HOME": "/dev/null/none", "HOME": "/dev/null"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0.528")
