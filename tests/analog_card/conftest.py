"""What tests of netlists share."""

import pytest


@pytest.fixture
def circuit(tmp_path):
    """Return a function that writes a netlist of the given lines and returns its path."""

    def write(*lines):
        file = tmp_path / "circuit.cir"
        file.write_text("\n".join(lines) + "\n")
        return file

    return write
