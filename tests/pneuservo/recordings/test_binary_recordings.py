"""Parquet, HDF5, MATLAB and TDMS files: read, refused when damaged, never trusted with objects."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from nptdms import ChannelObject, TdmsWriter
from pyarrow import parquet
from scipy.io import savemat

from pneuservo.recordings import read_recording

COUNT = 400
TIME = np.arange(COUNT) * 0.01
LASER = 15.0 + 9.0 * np.sin(TIME)  # mm
SIDECAR = """
[time]
column = "Time (ms)"
unit = "ms"

[channels]
displacement = { column = "Laser (mm)", unit = "mm" }
"""
COLUMNS = {"Time (ms)": 1000.0 * TIME, "Laser (mm)": LASER}


def write_parquet(path: Path, columns: dict) -> Path:
    parquet.write_table(pyarrow.table(columns), path)
    return path


def write_hdf5(path: Path, columns: dict) -> Path:
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[name] = values
    return path


def write_v73(path: Path, columns: dict) -> Path:
    """Write as MATLAB does: a block of text before the HDF5 file, row vectors, classes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in columns.items():
            # Arrays are stored transposed.
            file[name] = np.asarray(values)[:, None]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon May 12 1998 HDF5 schema 1.00 ."
    with path.open("r+b") as stream:
        stream.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def write_tdms(path: Path, columns: dict, **properties) -> Path:
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("rig", name, values, properties) for name, values in columns.items()]
        )
    return path


def write_v5(path: Path, columns: dict) -> Path:
    savemat(path, columns)
    return path


def write_compressed_v5(path: Path, columns: dict) -> Path:
    savemat(path, columns, do_compression=True)
    return path


def with_sidecar(path: Path, sidecar: str = SIDECAR) -> Path:
    path.with_suffix(".toml").write_text(sidecar)
    return path


@pytest.mark.parametrize(
    ("write", "suffix"),
    [
        (write_parquet, ".parquet"),
        (write_hdf5, ".h5"),
        (write_hdf5, ".hdf5"),
        (write_tdms, ".tdms"),
        (write_v5, ".mat"),
        (write_v73, ".mat"),
    ],
)
def test_every_form_gives_the_same_recording(tmp_path, write, suffix):
    # MATLAB has no names with blanks.
    plain = suffix == ".mat"
    columns = {"t": COLUMNS["Time (ms)"], "x": LASER} if plain else COLUMNS
    sidecar = SIDECAR.replace("Time (ms)", "t").replace("Laser (mm)", "x") if plain else SIDECAR
    path = with_sidecar(write(tmp_path / f"run{suffix}", columns), sidecar)
    before = (path.read_bytes(), path.stat().st_mtime_ns)
    recording = read_recording(path)
    assert recording.time == pytest.approx(TIME, rel=1e-15)
    assert np.array_equal(recording["displacement"], LASER * 0.001)
    assert recording.warnings == ()
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before


@pytest.mark.parametrize(
    ("write", "suffix", "kept"),
    [
        (write_parquet, ".parquet", 0.9),
        (write_parquet, ".parquet", 0.1),
        (write_hdf5, ".h5", 0.9),
        (write_hdf5, ".h5", 0.1),
        (write_tdms, ".tdms", 0.9),
        (write_tdms, ".tdms", 0.01),
        (write_v5, ".mat", 0.9),
        (write_v5, ".mat", 0.02),
        (write_compressed_v5, ".mat", 0.9),
        (write_v73, ".mat", 0.9),
        (write_v73, ".mat", 0.05),
    ],
)
def test_a_file_that_is_cut_off_is_refused(tmp_path, refusal, write, suffix, kept):
    path = write(tmp_path / f"run{suffix}", {"time": TIME, "displacement": LASER})
    path.write_bytes(path.read_bytes()[: int(kept * path.stat().st_size)])
    message = refusal(path)
    assert str(path) in message
    assert "cut off" in message


@pytest.mark.parametrize("left", [20, 100, 3000])  # of the lead-in, description and samples
def test_a_tdms_file_cut_within_a_later_segment_is_refused(tmp_path, refusal, left):
    path = tmp_path / "run.tdms"
    channels = [ChannelObject("rig", "time", TIME), ChannelObject("rig", "force", LASER)]
    for mode in ("w", "a"):
        with TdmsWriter(path, mode=mode) as writer:
            writer.write_segment(channels)
    whole = path.read_bytes()
    length = len(whole) // 2  # both segments are alike
    path.write_bytes(whole[: length + left])
    assert f"its segment at byte {length} is incomplete" in refusal(path)


@pytest.mark.parametrize("suffix", [".parquet", ".h5", ".mat", ".tdms"])
def test_a_file_of_another_kind_is_refused(tmp_path, refusal, suffix):
    path = tmp_path / f"run{suffix}"
    path.write_text("time,force\n" + "".join(f"{i},1.5\n" for i in range(20)))
    assert f"{path}: is cut off or not a" in refusal(path)


def test_columns_in_groups_have_the_group_in_their_name(tmp_path, refusal):
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["slow/time"] = TIME[::2]
        file["slow/force"] = LASER[::2]
        file["fast/time"] = TIME
        file["fast/displacement"] = LASER
        file["fast/gain"] = 3.0
        file["fast/operator"] = "somebody"
    with_sidecar(path, '[time]\ncolumn = "slow/time"\nunit = "s"\n[channels]\n'
                 'force = { column = "force", unit = "N" }\n')  # fmt: skip
    recording = read_recording(path)
    assert len(recording) == COUNT // 2
    assert recording["force"][1] == LASER[2]
    with_sidecar(path, '[time]\ncolumn = "slow/time"\nunit = "s"\n[channels]\n'
                 'force = { column = "fast/displacement", unit = "N" }\n')  # fmt: skip
    assert "'slow/time' has 200, 'fast/displacement' has 400" in refusal(path)
    with_sidecar(path, '[time]\ncolumn = "time"\nunit = "s"\n[channels]\n'
                 'force = { column = "force", unit = "N" }\n')  # fmt: skip
    message = refusal(path)  # there are two of them
    assert "no column 'time'" in message
    assert "'fast/displacement', 'fast/time', 'slow/force', 'slow/time'" in message


@pytest.mark.parametrize("orientation", ["rows", "columns"])
@pytest.mark.parametrize("suffix", [".h5", ".mat"])
def test_a_single_matrix_is_a_table(tmp_path, suffix, orientation):
    matrix = np.column_stack([TIME, LASER])
    matrix = matrix if orientation == "columns" else matrix.T
    path = tmp_path / f"run{suffix}"
    if suffix == ".h5":
        write_hdf5(path, {"data": matrix})
    else:
        write_v5(path, {"data": matrix})
    numbered = '[time]\ncolumn = "data[0]"\nunit = "s"\n[channels]\n' + (
        'displacement = { column = "data[1]", unit = "mm" }\n'
    )
    assert np.array_equal(
        read_recording(with_sidecar(path, numbered))["displacement"], LASER * 1e-3
    )
    named = '[table]\nheader = false\nnames = ["t", "x"]\n' + (
        numbered.replace("data[0]", "t").replace("data[1]", "x")
    )
    assert np.array_equal(read_recording(with_sidecar(path, named))["displacement"], LASER * 1e-3)


def test_names_for_a_matrix_have_to_be_as_many_as_its_columns(tmp_path, refusal):
    path = write_hdf5(tmp_path / "run.h5", {"data": np.column_stack([TIME, LASER])})
    with_sidecar(path, '[table]\nheader = false\nnames = ["t", "x", "y"]\n')
    assert "3 names for 2 columns (data[0], data[1])" in refusal(path)


def test_the_fields_of_a_compound_dataset_are_columns(tmp_path):
    table = np.zeros(COUNT, dtype=[("time", "f8"), ("displacement", "f4"), ("note", "S4")])
    table["time"], table["displacement"] = TIME, LASER
    recording = read_recording(write_hdf5(tmp_path / "run.h5", {"table": table}))
    assert np.array_equal(recording["displacement"], LASER.astype("f4"))


def test_the_fields_of_a_struct_are_columns(tmp_path):
    path = write_v5(tmp_path / "run.mat", {"log": {"time": TIME, "force": LASER, "unit": "N"}})
    assert np.array_equal(read_recording(path)["force"], LASER)


def test_whole_numbers_and_single_precision_become_numbers(tmp_path):
    columns = {"time": np.arange(COUNT, dtype=np.int32), "valve_voltage": LASER.astype("f4")}
    recording = read_recording(write_parquet(tmp_path / "run.parquet", columns))
    assert recording["valve_voltage"].dtype == np.float64
    assert recording.time[-1] == COUNT - 1


def test_time_stamps_become_seconds_from_the_start(tmp_path):
    stamps = np.datetime64("1998-05-12T10:00:00") + (1000 * TIME).astype("timedelta64[ms]")
    path = write_parquet(tmp_path / "run.parquet", {"time": stamps, "force": LASER})
    assert read_recording(path).time == pytest.approx(TIME, abs=1e-12)


def test_time_stamps_of_another_name_need_no_unit_and_take_none(tmp_path, refusal):
    stamps = np.datetime64("1998-05-12T10:00:00") + (1000 * TIME).astype("timedelta64[ms]")
    path = write_parquet(tmp_path / "run.parquet", {"Time": stamps, "force": LASER})
    sidecar = path.with_suffix(".toml")
    channel = '[channels]\nforce = { column = "force", unit = "N" }\n'
    sidecar.write_text(f'[time]\ncolumn = "Time"\n{channel}')
    assert read_recording(path).time == pytest.approx(TIME, abs=1e-12)
    sidecar.write_text(f'[time]\ncolumn = "Time"\nunit = "ms"\n{channel}')
    assert "holds dates and times, and its unit is 'ms'" in refusal(path)


def test_missing_samples_of_encoded_columns_stay_missing(tmp_path):
    values = [None if k == 8 else float(k % 3) for k in range(COUNT)]
    encoded = pyarrow.array(values).dictionary_encode()
    path = tmp_path / "run.parquet"
    parquet.write_table(pyarrow.table({"time": TIME, "force": encoded}), path)
    recording = read_recording(path)
    # Bridged between its neighbours, 1 and 0.
    assert recording["force"][8] == 0.5


def test_a_column_of_text_is_refused(tmp_path, refusal):
    columns = {"time": TIME, "force": [f"{x}" for x in LASER]}
    message = refusal(write_parquet(tmp_path / "run.parquet", columns))
    assert "column 'force'" in message
    assert "not numbers" in message


def test_a_parquet_file_that_repeats_a_name_is_refused(tmp_path, refusal):
    path = tmp_path / "run.parquet"
    table = pyarrow.Table.from_arrays(
        [pyarrow.array(TIME)] * 2 + [pyarrow.array(LASER)], names=["time", "time", "force"]
    )
    parquet.write_table(table, path)
    assert "'time' appears more than once" in refusal(path)


def test_a_waveform_knows_its_rate(tmp_path, refusal):
    path = write_tdms(tmp_path / "run.tdms", {"Load": LASER}, wf_increment=0.002)
    sidecar = '[channels]\nforce = { column = "rig/Load", unit = "N" }\n'
    assert read_recording(with_sidecar(path, sidecar)).time == pytest.approx(
        np.arange(COUNT) * 0.002, rel=1e-12
    )
    recording = read_recording(with_sidecar(path, '[time]\nrate = "1 kHz"\n' + sidecar))
    assert recording.time[1] == 0.001
    assert any("500 Hz" in text and "1000 Hz is used" in text for text in recording.warnings)


def test_waveforms_of_different_rates_are_refused(tmp_path, refusal):
    path = tmp_path / "run.tdms"
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject("rig", "force", LASER, {"wf_increment": 0.002}),
                ChannelObject("rig", "displacement", LASER, {"wf_increment": 0.001}),
            ]
        )
    assert "different sample rates" in refusal(path)


def test_waveforms_without_a_rate_need_one(tmp_path, refusal):
    path = write_tdms(tmp_path / "run.tdms", {"force": LASER})
    assert "[time]" in refusal(path)


def test_an_index_file_does_not_stand_in_for_the_samples(tmp_path):
    path = write_tdms(tmp_path / "run.tdms", {"time": TIME, "force": LASER})
    (tmp_path / "run.tdms_index").write_bytes(b"TDSh, and then nothing of use")
    assert np.array_equal(read_recording(path)["force"], LASER)


@pytest.mark.parametrize(
    ("value", "what"),
    [
        (np.array([{"a": 1}, "text", None], dtype=object), "cell"),
        (np.array([[1.0, 2.0], "text"], dtype=object), "cell"),
    ],
)
def test_cells_in_a_mat_file_are_refused(tmp_path, refusal, value, what):
    value = np.array([v for v in value if v is not None], dtype=object)
    path = write_v5(tmp_path / "run.mat", {"time": TIME, "force": LASER, "extra": value})
    message = refusal(path)
    assert "'extra'" in message
    assert what in message


def test_a_struct_that_holds_a_cell_is_refused(tmp_path, refusal):
    extra = {"force": LASER, "meta": np.array(["a", 1.0], dtype=object)}
    message = refusal(write_v5(tmp_path / "run.mat", {"time": TIME, "log": extra}))
    assert "'log/meta' is a cell array" in message


def test_an_object_in_a_v5_file_is_refused(tmp_path, refusal):
    from scipy.io.matlab import MatlabObject

    value = np.zeros((1, 1), dtype=[("secret", object)])
    value["secret"][0, 0] = np.array([[1.0]])
    path = tmp_path / "run.mat"
    savemat(path, {"time": TIME, "force": LASER, "thing": MatlabObject(value, "timeseries")})
    assert "'thing' is of class 'object'" in refusal(path)


@pytest.mark.parametrize(
    ("attributes", "what"),
    [
        ({"MATLAB_class": np.bytes_("timeseries"), "MATLAB_object_decode": np.int32(3)}, "object"),
        ({"MATLAB_class": np.bytes_("function_handle")}, "'function_handle'"),
        ({"MATLAB_class": np.bytes_("cell")}, "'cell'"),
    ],
)
def test_objects_in_a_v73_file_are_refused(tmp_path, refusal, attributes, what):
    path = write_v73(tmp_path / "run.mat", {"time": TIME, "force": LASER})
    with h5py.File(path, "r+") as file:
        file["thing"] = np.zeros((1, 6), dtype=np.uint32)
        file["thing"].attrs.update(attributes)
    message = refusal(path)
    assert "'thing'" in message
    assert what in message


def test_references_in_a_v73_file_are_refused(tmp_path, refusal):
    path = write_v73(tmp_path / "run.mat", {"time": TIME, "force": LASER})
    with h5py.File(path, "r+") as file:
        file["thing"] = np.array([[file["time"].ref]], dtype=h5py.ref_dtype)
    assert "'thing' is an array of references" in refusal(path)


def test_hdf5_that_reaches_for_another_file_is_refused(tmp_path, refusal):
    write_hdf5(tmp_path / "secret.h5", {"force": LASER})
    (tmp_path / "raw.bin").write_bytes(LASER.tobytes())
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        file["force"] = h5py.ExternalLink("secret.h5", "/force")
    assert "link to another file, 'secret.h5'" in refusal(path)
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        file.create_dataset(
            "force", (COUNT,), "f8", external=[(str(tmp_path / "raw.bin"), 0, COUNT * 8)]
        )
    assert "samples from another file" in refusal(path)
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        layout = h5py.VirtualLayout((COUNT,), "f8")
        layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "force", (COUNT,))
        file.create_virtual_dataset("force", layout)
    assert "samples from another file" in refusal(path)


def test_a_soft_link_is_not_followed(tmp_path):
    path = write_hdf5(tmp_path / "run.h5", {"time": TIME, "force": LASER})
    with h5py.File(path, "r+") as file:
        file["again"] = h5py.SoftLink("/")
    assert len(read_recording(path)) == COUNT


def test_a_small_file_that_claims_to_be_huge_is_refused(tmp_path, refusal):
    path = write_hdf5(tmp_path / "run.h5", {"time": TIME})
    with h5py.File(path, "r+") as file:
        file.create_dataset("force", (10**11,), "f8", chunks=(1024,))
    assert path.stat().st_size < 100_000
    assert "more than" in refusal(path)
    with h5py.File(path, "r+") as file:
        del file["force"]
        wide = np.dtype([("x", "f8"), ("pad", "S100000")])
        file.create_dataset("force", (1_000_000,), wide, chunks=(1,))
    assert "more than" in refusal(path)
