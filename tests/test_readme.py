"""Every example of the README runs as it stands."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\$ (.+)$", README, re.MULTILINE)
COMMAND_FOLDER = Path(sys.executable).parent


@pytest.mark.ngspice
def test_commands_run_one_after_the_other(tmp_path):
    assert len(COMMANDS) >= 8
    for line in COMMANDS:
        program, *arguments = shlex.split(line)
        result = subprocess.run(
            [COMMAND_FOLDER / program, *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        assert result.returncode == 0, f"{line}\n{result.stderr}"
    assert "leak" in (tmp_path / "out/diagnosis/report.html").read_text(encoding="utf-8")


# What the examples in Python print, by a word in them.
SAID = {"diagnose": "missing-physics ['leakage.", "SampledController": "settled after 0."}


def test_python_examples_run(capsys):
    examples = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert examples
    for example in examples:
        exec(compile(example, "README.md", "exec"), {"__name__": "example"})  # noqa: S102 - our own page, not input
        said = capsys.readouterr().out
        for word, expected in SAID.items():
            if word in example:
                assert said.startswith(expected)
