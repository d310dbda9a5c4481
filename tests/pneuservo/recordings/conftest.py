"""Recordings on disk, as users leave them there."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.recordings import read_recording

MAPPED = """
[time]
column = "t"
unit = "s"

[channels]
displacement = { column = "x", unit = "mm" }
"""


@pytest.fixture
def save(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that saves a text file, with a sidecar if one is given."""

    def save(content: str | bytes, sidecar: str | None = None, name: str = "run.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        if sidecar is not None:
            path.with_suffix(".toml").write_text(sidecar, encoding="utf-8")
        return path

    return save


@pytest.fixture
def save_columns(save: Callable[..., Path]) -> Callable[..., Path]:
    """Return a function that saves time and samples as CSV, with a sidecar in s and mm."""

    def save_columns(time: Iterable[float], samples: Iterable[float]) -> Path:
        pairs = zip(time, samples, strict=True)
        rows = [f"{float(t)!r},{'' if np.isnan(x) else repr(float(x))}" for t, x in pairs]
        return save("\n".join(["t,x", *rows, ""]), MAPPED)

    return save_columns


@pytest.fixture
def refusal() -> Callable[[Path], str]:
    """Return a function that reads a file which has to be refused, and returns the message."""

    def refusal(path: Path) -> str:
        before = path.read_bytes() if path.is_file() else b""
        with pytest.raises(InputError) as caught:
            read_recording(path)
        assert caught.value.exit_code == 2
        assert not path.is_file() or path.read_bytes() == before
        return str(caught.value)

    return refusal
