"""Compiled code is kept for as long as the physics that it came from."""

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
