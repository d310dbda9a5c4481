"""Processes that share work."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from analog_card.processes import processes

_SHARE = """
import time
from analog_card.processes import processes
import os

def work(seconds):
    time.sleep(seconds)

if __name__ == "__main__":
    with processes(2, finish={finish}, start={start!r}) as pool:
        print(*[pool.submit(os.getpid).result() for _ in range(2)], flush=True)
        pool.submit(work, 60).result()
"""


def runs(process: int) -> bool:
    """Return whether a process is there and has not ended."""
    try:
        state = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return False
    return state[0] not in "ZX"


@pytest.mark.parametrize(("finish", "start"), [(True, "spawn"), (False, "spawn"), (False, "fork")])
def test_processes_end_with_the_program_that_was_killed(tmp_path, finish, start):
    file = tmp_path / "share.py"
    file.write_text(_SHARE.format(finish=finish, start=start), encoding="utf-8")
    program = subprocess.Popen([sys.executable, file], stdout=subprocess.PIPE, text=True)
    workers = {int(word) for word in program.stdout.readline().split()}
    assert all(runs(worker) for worker in workers)
    os.kill(program.pid, signal.SIGKILL)
    program.communicate()
    end = time.monotonic() + 20.0
    while any(runs(worker) for worker in workers):
        assert time.monotonic() < end, "its processes run on"
        time.sleep(0.05)


def test_what_was_begun_is_finished_where_that_is_asked_for():
    with processes(1, finish=True) as pool:
        assert pool.submit(signal.getsignal, signal.SIGINT).result() == signal.SIG_IGN
