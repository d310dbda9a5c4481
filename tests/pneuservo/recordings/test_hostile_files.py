"""Files that would hang a reader or fill its memory are refused."""

import h5py
import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from pneuservo.errors import InputError
from pneuservo.recordings import read_recording
from pneuservo.recordings.table import MAX_SAMPLES


def test_groups_that_hang_in_each_other_are_visited_once(tmp_path):
    path = tmp_path / "tangle.h5"
    with h5py.File(path, "w") as file:
        group = file.create_group("g0")
        for depth in range(1, 15):
            inner = file.create_group(f"g{depth}")
            for link in range(8):
                group[f"l{link}"] = inner
            group = inner
        file["time"] = np.arange(20) * 0.01
        file["displacement"] = np.full(20, 0.01)
    assert len(read_recording(path)) == 20


def test_a_small_file_with_many_rows_is_refused_unread(tmp_path):
    path = tmp_path / "long.parquet"
    rows = pyarrow.array(np.zeros(MAX_SAMPLES // 2 + 1, dtype=np.int8))
    parquet.write_table(pyarrow.table({"time": rows, "displacement": rows}), path)
    assert path.stat().st_size < 1_000_000
    with pytest.raises(InputError, match="cut it shorter"):
        read_recording(path)


def test_a_name_longer_than_csv_takes_is_no_traceback(tmp_path):
    path = tmp_path / "wide.csv"
    path.write_text('time,"' + "x" * 200_000 + '"\n' + "".join(f"{i},0\n" for i in range(20)))
    with pytest.raises(InputError):
        read_recording(path)


@pytest.mark.parametrize(
    ("sidecar", "message"),
    [
        ('[time]\ncolumn = "time"\nunit = "s"\n[channels.pressure_a]\ncolumn = "p"\n'
         'unit = "Pa"\nscale = 1e200\n', "not finite"),
        ('[time]\nrate = "1e-320 Hz"\n[channels.pressure_a]\ncolumn = "p"\nunit = "Pa"\n', "rate"),
    ],
)  # fmt: skip
def test_numbers_beyond_range_are_refused(tmp_path, sidecar, message):
    path = tmp_path / "a.csv"
    path.write_text("time,p\n" + "".join(f"{i},1e200\n" for i in range(20)))
    (tmp_path / "a.toml").write_text(sidecar)
    with pytest.raises(InputError, match=message):
        read_recording(path)
