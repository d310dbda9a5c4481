"""What the tests of both packages share."""

import os
from pathlib import Path

import pytest

FIRST = (
    # What takes longest: the last file would have a process to itself.
    "test_servo_diagnosis.py",
    "test_readme.py",
    "test_no_effect_controls.py",
    # Beside the next file, which the other process would take, both would compile its kernels.
    "test_figure_command.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files in an order in which both processes have work to the end, each its own."""
    items.sort(key=lambda item: item.path.name not in FIRST)


@pytest.fixture(scope="session")
def real_recordings() -> Path:
    """Return the folder of the real recordings, which are not part of the project."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "recordings"
    folder = Path(os.environ.get("PNEUSERVO_RECORDINGS", beside))
    if not folder.is_dir():
        reason = f"no real recordings in {folder}; set PNEUSERVO_RECORDINGS to their folder"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    return folder


@pytest.fixture
def circuit(tmp_path):
    """Return a function that writes a netlist of the given lines and returns its path."""

    def write(*lines):
        file = tmp_path / "circuit.cir"
        file.write_text("\n".join(lines) + "\n")
        return file

    return write
