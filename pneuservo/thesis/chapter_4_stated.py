"""What chapter 4 of the thesis states, as data."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any


@cache
def stated() -> dict[str, Any]:
    """Return the content of ``chapter_4.toml``, in SI."""
    text = (files("pneuservo.thesis") / "chapter_4.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
