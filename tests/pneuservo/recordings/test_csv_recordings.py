"""CSV files: every dialect gives the same numbers, and what is unclear is refused."""

import time

import numpy as np
import pytest

from pneuservo.recordings import read_recording

SIDECAR = """
[time]
column = "Time (ms)"
unit = "ms"

[channels]
displacement = { column = "Laser, raw (mm)", unit = "mm" }
force = { column = "Load", unit = "N" }
"""
MILLISECONDS = np.arange(20) * 10.0 + 0.5
MILLIMETRES = np.array([12.125 + 0.25 * i for i in range(20)])
NEWTONS = np.array([-3.5e-2 * i for i in range(20)])


def table(delimiter: str, mark: str = ".", end: str = "\n", quote: str = "") -> str:
    header = delimiter.join(['"Time (ms)"', '"Laser, raw (mm)"', " Load "])
    rows = [
        delimiter.join(quote + repr(float(v)).replace(".", mark) + quote for v in row)
        for row in zip(MILLISECONDS, MILLIMETRES, NEWTONS, strict=True)
    ]
    return end.join([header, *rows]) + end


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(table(","), id="comma"),
        pytest.param(table(";"), id="semicolon"),
        pytest.param(table("\t"), id="tab"),
        pytest.param(table(";", ","), id="semicolon, decimal comma"),
        pytest.param(table("\t", ","), id="tab, decimal comma"),
        pytest.param(table(",", ",", quote='"'), id="quoted decimal comma"),
        pytest.param(table(" , "), id="blanks round the delimiter"),
        pytest.param(table(",", end="\r\n"), id="Windows line ends"),
        pytest.param(table(",", end="\r"), id="old Macintosh line ends"),
        pytest.param("\ufeff" + table(","), id="byte order mark"),
        pytest.param(table(",") + "\n  \n\n", id="blank lines at the end"),
        pytest.param(table(",") + ",,\n,,\n", id="rows of bare delimiters at the end"),
        pytest.param(table(",").rstrip("\n"), id="no line end after the last line"),
        pytest.param(table(",").replace("\n", ",\n"), id="delimiter at every line end"),
        pytest.param(table(",").replace(" Load ", "Load,", 1), id="delimiter at the header's end"),
        pytest.param(table(",", quote='"'), id="quoted numbers"),
        pytest.param(table(",").replace("e-", "E-"), id="capital exponents"),
    ],
)
def test_every_dialect_gives_the_same_numbers(save, text):
    recording = read_recording(save(text, SIDECAR))
    assert recording.time == pytest.approx(np.arange(20) * 0.01, abs=1e-15)
    # One multiplication by the factor of the unit: equal to the last bit.
    assert np.array_equal(recording["displacement"], MILLIMETRES * 0.001)
    assert np.array_equal(recording["force"], NEWTONS)
    assert recording.warnings == ()


def test_without_a_sidecar_canonical_names_are_si_on_the_single_axis(save):
    rows = [f"{i / 100!r},{i / 1000!r},650000.0" for i in range(20)]
    recording = read_recording(save("\n".join(["time,displacement,pressure_a", *rows, ""])))
    assert recording.rig == "single-axis"
    assert set(recording.channels) == {"displacement", "pressure_a"}
    assert recording["displacement"][7] == 0.007
    assert recording["pressure_a"][0] == 650000.0
    assert recording.time[-1] == 0.19


def test_without_header_the_sidecar_names_the_columns(save):
    text = "".join(f"{10 * i}\t{i}.5\t9\n" for i in range(20))
    sidecar = '[table]\nheader = false\nnames = ["t", "x", "unused"]\n' + (
        '[time]\ncolumn = "t"\nunit = "ms"\n[channels]\nforce = { column = "x", unit = "kN" }\n'
    )
    recording = read_recording(save(text, sidecar))
    assert recording.time[-1] == pytest.approx(0.19)
    assert recording["force"][0] == 500.0


def test_a_sample_rate_stands_in_for_a_time_column(save):
    sidecar = '[time]\nrate = "0.5 kHz"\n[channels]\nforce = { column = "F", unit = "N" }\n'
    recording = read_recording(save("F\n" + "".join(f"{i}\n" for i in range(20)), sidecar))
    assert np.array_equal(recording.time, np.arange(20) / 500.0)


def test_in_a_single_column_a_blank_line_is_a_missing_sample(save):
    sidecar = '[time]\nrate = "1 Hz"\n[channels]\nforce = { column = "F", unit = "N" }\n'
    rows = [str(i * i) for i in range(20)]
    rows[4] = ""
    recording = read_recording(save("\n".join(["F", *rows, ""]), sidecar))
    assert len(recording) == 20
    assert recording["force"][4] == (9 + 25) / 2  # interpolated, not closed up
    assert any("1 missing sample was interpolated" in text for text in recording.warnings)


def test_columns_of_text_do_no_harm_when_they_are_not_used(save):
    rows = [f"{i},{i}.5,comment {i}" for i in range(20)]
    path = save(
        "\n".join(["t,x,note", *rows, ""]),
        '[time]\ncolumn = "t"\nunit = "s"\n[channels]\nforce = { column = "x", unit = "N" }\n',
    )
    assert read_recording(path)["force"][-1] == 19.5


def test_blank_lines_between_samples_are_skipped_and_told(save):
    text = "time,force\n" + "".join(f"{i},{i}.5\n" for i in range(20))
    recording = read_recording(save(text.replace("\n7,", "\n\n\n7,")))
    assert len(recording) == 20
    assert any("blank lines between the samples were skipped: 2" in w for w in recording.warnings)


def test_a_long_file_reads_fast(save):
    rng = np.random.default_rng(1)
    rows = [f"{a!r},{b!r}" for a, b in rng.normal(size=(131_072, 2)).tolist()]
    path = save(
        "\n".join(["V1,V2", *rows, ""]),
        '[recording]\nrig = "circuit"\n[time]\nrate = "610 Hz"\n[channels]\n'
        'circuit_input = { column = "V1", unit = "V" }\n'
        'circuit_output = { column = "V2", unit = "V" }\n',
    )
    start = time.perf_counter()
    recording = read_recording(path)
    # It takes about 0.2 s; a second leaves room for a busy machine.
    assert time.perf_counter() - start < 1.0
    assert len(recording) == 131_072


# What a cell may hold that is not clearly one number. Each row: cells of the force column,
# delimiter, what the message has to say.
UNCLEAR = [
    pytest.param("998;999;1.000,5;1.001,5", ";", ["line 4", "'1.000,5'", "thousands"], id="both"),
    pytest.param("998;999;1,000;1,010", "\t", ["line 4", "'1,000'", "thousands"], id="from 1000"),
    pytest.param("998;999;1.000;1.010", ";", ["line 4", "'1.000'", "thousands"], id="points"),
    pytest.param('7.5;8.5;"1,000";2.5', ",", ["line 4", "'1,000'", "thousands"], id="quoted"),
    pytest.param('"1,000";"1,010";"1,020"', ",", ["line 2", "thousands"], id="quoted, all of them"),
    pytest.param("1,234,567;1,5;2,5", "\t", ["line 2", "'1,234,567'", "thousands"], id="two"),
    pytest.param("1.5;2.5;n.a.;3.5", ",", ["line 4", "'n.a.'", "not a number"], id="text"),
    pytest.param("1.5;12:30;3.5", ",", ["line 3", "'12:30'", "not a number"], id="clock"),
    pytest.param("1.5;0x1F;3.5", ",", ["line 3", "'0x1F'", "not a number"], id="hexadecimal"),
    pytest.param("1.5;1_000;3.5", ",", ["line 3", "'1_000'", "not a number"], id="underscore"),
    pytest.param("1.5;inf;3.5", ",", ["line 3", "infinite"], id="infinite"),
]


@pytest.mark.parametrize(("cells", "delimiter", "told"), UNCLEAR)
def test_a_cell_that_is_not_clearly_a_number_is_refused(save, refusal, cells, delimiter, told):
    given = cells.split(";")
    whole = [*given, *[given[-1]] * (20 - len(given))]
    rows = [f"{i}{delimiter}{cell}" for i, cell in enumerate(whole)]
    message = refusal(save("\n".join([f"time{delimiter}force", *rows, ""])))
    for text in [*told, "run.csv", "'force'"]:
        assert text in message


def test_points_in_one_column_and_commas_in_another_are_refused(save, refusal):
    rows = [f"{i},5;{i}.25" for i in range(20)]
    message = refusal(save("\n".join(["time;force", *rows, ""])))
    assert "column 'time' has '0,5'" in message
    assert "column 'force' has '0.25'" in message


def test_three_decimals_after_a_comma_throughout_are_decimals(save):
    rows = [f"{i};{i + 1},125" for i in range(20)]
    assert read_recording(save("\n".join(["time;force", *rows, ""])))["force"][0] == 1.125


# Zeros at the end are not written.
_DECIMALS = b"".join(b"%d,1.%d\n" % (i, 10007 ** (1 + i % 3)) for i in range(40))
REFUSED_FILES = [
    pytest.param(b"", ["empty"], id="empty"),
    pytest.param(b"\n \n\n", ["blank lines"], id="blank"),
    pytest.param("time,kraft_ä\n0,1\n".encode("latin-1"), ["line 1", "header", "UTF-8"], id="l1"),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5\n" % i for i in range(20)) + b"20,\xb5\n",
        ["line 22", "UTF-8"],
        id="not UTF-8 below",
    ),
    pytest.param("time,force\n0,1\n".encode("utf-16"), ["line 1", "UTF-16"], id="UTF-16"),
    pytest.param(b"time,force\n0,1\n\0\0\0", ["line 3", "zero byte"], id="binary"),
    pytest.param(b"time,force,force\n0,1,2\n", ["line 1", "'force'", "more than once"], id="twice"),
    pytest.param(b"0,1.5\n1,2.5\n", ["line 1", "header = false"], id="no header"),
    pytest.param(b'"time,force\n0,1\n', ["line 1", "quotation mark"], id="open quotation mark"),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1,5\n" % i for i in range(20)),
        ["line 2", "3 fields", "header has 2", "semicolons"],
        id="unquoted decimal comma",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5\n" % i for i in range(9)) + b"9\n10,1.5\n",
        ["line 11", "1 field "],
        id="short line within",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5\n" % i for i in range(20)) + b"20",
        ["line 22", "cut off"],
        id="last line without all its fields",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.500\n" % i for i in range(20)) + b"20,1.5",
        ["line 22", "'1.5'", "cut off"],
        id="last number with fewer decimals",
    ),
    pytest.param(
        b"time,force\n"
        + b"".join(b"%d,1.%d\n" % (i, 10007 ** (1 + i % 3)) for i in range(40))
        + b"40,1.",
        ["line 42", "'1.'", "cut off"],
        id="last number at its decimal mark",
    ),
    pytest.param(
        b"time,force\n"
        + b"".join(b"%d,1.%d\n" % (i, 10007 ** (1 + i % 3)) for i in range(40))
        + b"40,1.10",
        ["line 42", "'1.10'", "cut off"],
        id="last number far shorter than any other",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5e-3\n" % i for i in range(20)) + b"20,1.5e-",
        ["line 22", "'1.5e-'", "cut off"],
        id="last number within its exponent",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,%d\n" % (i, i % 7) for i in range(15)),
        ["15 usable samples", "16"],
        id="15 samples",
    ),
    pytest.param(b"time,force\n", ["0 usable samples", "16"], id="only a header"),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,\n" % i for i in range(20)),
        ["column 'force'", "no number"],
        id="nothing but missing samples",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5\n" % i for i in (*range(10), 8, *range(10, 20))),
        ["line 12", "column 'time'", "backwards", "from 9 s to 8 s"],
        id="time backwards",
    ),
    pytest.param(
        b"time,force\n" + b"3.5,1.5\n" * 20,
        ["column 'time'", "3.5 s throughout"],
        id="time standing still",
    ),
    pytest.param(
        b"time,force\n" + b"".join(b"%d,1.5\n" % i for i in range(20)) + b"inf,1.5\n",
        ["line 22", "column 'time'", "infinite"],
        id="infinite time",
    ),
    pytest.param(
        b"Zeit,Kraft\n" + b"".join(b"%d,1.5\n" % i for i in range(20)),
        ["run.toml", "does not exist", "'Zeit', 'Kraft'", "displacement"],
        id="no sidecar and no canonical names",
    ),
    pytest.param(
        b"Zeit,force\n" + b"".join(b"%d,1.5\n" % i for i in range(20)),
        ["no column 'time'", "[time]", "'Zeit'"],
        id="no time",
    ),
]


@pytest.mark.parametrize(("content", "told"), REFUSED_FILES)
def test_a_file_that_cannot_be_used_is_refused(save, refusal, content, told):
    message = refusal(save(content))
    for text in [*told, "run.csv"]:
        assert text in message


def test_files_that_are_none_are_refused(tmp_path, refusal, save):
    save("time,force\n0,1\n", name="step15.csv")
    assert "Did you mean 'step15.csv'?" in refusal(tmp_path / "step16.csv")
    (tmp_path / "folder.csv").mkdir()
    assert "is a folder" in refusal(tmp_path / "folder.csv")
    message = refusal(save("x", name="run.xlsx"))
    assert "'.xlsx'" in message
    assert ".csv, .tsv, .txt, .parquet, .h5, .hdf5, .mat, .tdms" in message


def test_the_input_is_never_written_to(save):
    path = save("time,force\n" + "".join(f"{i},1.5\n" for i in range(20)), "[conditions]\n")
    files = [path, path.with_suffix(".toml")]
    before = [(file.read_bytes(), file.stat().st_mtime_ns) for file in files]
    read_recording(path)
    assert [(file.read_bytes(), file.stat().st_mtime_ns) for file in files] == before
    assert sorted(path.parent.iterdir()) == sorted(files)
