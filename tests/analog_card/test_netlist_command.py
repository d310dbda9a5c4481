"""``analog-card simulate``, ``opamp`` and ``schematic``."""

import json
import re
import shlex
import sys
import xml.etree.ElementTree as ElementTree
from subprocess import run as run_program

import h5py
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.quantities import as_text
from analog_card.schematic import draw_card

pytestmark = pytest.mark.ngspice

OWN = """my low pass
.param r=1k
.include part.lib
V1 in 0 dc 2 ac 1 pulse(0 2 0 1n 1n 1 2)
Xpart in out low_pass
.ac dec 10 10 10k
.tran 1u 1m
.dc V1 0 2 0.5
.end
"""
PART = ".subckt low_pass in out\nR1 in out {r}\nC1 out 0 100n\n.ends\n"


@pytest.fixture
def analog_card(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.cir").write_text(OWN)
    (tmp_path / "part.lib").write_text(PART)

    def call(line):
        return CliRunner().invoke(main, shlex.split(line))

    return call


def test_a_netlist_of_ones_own(analog_card):
    result = analog_card("simulate own.cir --analysis ac --param r=2k --out own.csv --node out")
    assert result.exit_code == 0, result.output
    table = pd.read_csv("own.csv")
    assert list(table) == ["frequency [Hz]", "out_magnitude [V]", "out_phase [degree]"]
    f = table["frequency [Hz]"]
    # pandas writes every digit; ngspice's own conductance of 1e-12 S is left.
    np.testing.assert_allclose(
        table["out_magnitude [V]"], 1 / np.hypot(1, 2 * np.pi * f * 2e-4), rtol=1e-8
    )


@pytest.mark.parametrize("form", ["csv", "parquet", "h5"])
def test_every_form_holds_the_same(analog_card, form):
    assert analog_card(f"simulate own.cir --analysis dc --out own.{form}").exit_code == 0
    if form == "h5":
        with h5py.File("own.h5") as file:
            assert file["out"].attrs["unit"] == "V"
            sweep, out = file["v-sweep"][:], file["out"][:]
    else:
        table = pd.read_csv("own.csv") if form == "csv" else pd.read_parquet("own.parquet")
        sweep, out = table["v-sweep [V]"], table["out [V]"]
    np.testing.assert_allclose(sweep, [0, 0.5, 1, 1.5, 2], atol=1e-12)
    np.testing.assert_allclose(out, sweep, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("simulate own.cir --analysis op", ["out", "V", "2"]),
        ("simulate own.cir --analysis tran --to 2ms --step 10us --node out", ["time", "0.002"]),
        ("simulate own.cir --analysis dc --source V1 --from 0 --to 1 --step 0.5", ["v-sweep"]),
        ("simulate own.cir --analysis noise --source V1 --node out --from 10 --to 1kHz",
         ["onoise_spectrum", "V/√Hz"]),
        ("simulate boundary-layer --analysis dc --node control", ["control", "5.00"]),
        ("simulate card-noise --analysis noise --node velocity", ["inoise_spectrum"]),
    ],
)  # fmt: skip
def test_every_analysis_prints_a_table(analog_card, line, words):
    result = analog_card(line)
    assert result.exit_code == 0, result.output
    for word in words:
        assert word in result.output


@pytest.mark.parametrize("analysis", ["ac", "tran", "dc"])
def test_every_curve_is_drawn(analog_card, analysis, tmp_path):
    assert analog_card(f"simulate own.cir --analysis {analysis} --plot own.svg").exit_code == 0
    text = (tmp_path / "own.svg").read_text()
    ElementTree.fromstring(text)  # noqa: S314 - our own picture
    assert "<!-- out -->" in text


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("simulate no.cir --analysis op", "no.cir: No such file"),
        ("simulate opamp-slow --analysis op", "nearest is 'opamp-slew'"),
        ("simulate own.cir --analysis pz", "is not one of"),
        ("simulate own.cir --analysis noise", "no .noise line"),
        ("simulate own.cir --analysis tran --to 1ms", "--step: needed too"),
        ("simulate own.cir --analysis tran --to 1kHz --step 1us", "a time is needed"),
        ("simulate own.cir --analysis ac --from 10 --to 1", "0 < start < stop"),
        ("simulate own.cir --analysis op --param rr=1", "no parameter 'rr'; nearest is 'r'"),
        ("simulate own.cir --analysis op --param r", "write for example resistance=22k"),
        ("simulate own.cir --analysis op --param r=1M", "M is a thousandth in SPICE"),
        ("simulate own.cir --analysis op --param r=1Mohm", "M is a thousandth in SPICE"),
        ("simulate own.cir --analysis op --param r=1.0e0M", "M is a thousandth in SPICE"),
        ("simulate own.cir --analysis op --param r=-5M", "M is a thousandth in SPICE"),
        ("simulate own.cir --analysis op --step 1", "--step: not used by --analysis op"),
        ("simulate own.cir --analysis op --source V1", "--source: not used by --analysis op"),
        ("simulate own.cir --analysis ac --points 3", "--points: not used with the netlist's own"),
        ("simulate own.cir --analysis tran --from 1 --to 1 --step 1e-3",
         "--from: not used by --analysis tran; it takes --to, --step"),
        ("simulate own.cir --analysis noise --node in --node out", "noise is computed at one node"),
        ("simulate own.cir --analysis dc --source Xpart", "no voltage or current source 'Xpart'"),
        ("simulate own.cir --analysis ac --from 1 --to 9 --points 100000000000",
         "fewer points a decade are needed"),
        ("simulate own.cir --analysis op --param r=big", "write for example r=22k"),
        ("simulate own.cir --analysis op --node outt", "no node 'outt'; nearest is 'out'"),
        ("simulate own.cir --analysis op --plot own.svg", "an operating point has no curve"),
        ("simulate own.cir --analysis op --plot own.bmp", "unknown form of picture"),
        ("simulate own.cir --analysis op --out own.xlsx", "unknown form '.xlsx'"),
        ("simulate own.cir --analysis dc --source 'V1; shell ls' --from 0 --to 1 --step 1",
         "is not a name"),
        ("schematic --out card.bmp", "unknown form of picture"),
        ("schematic", "Missing option '--out'"),
    ],
)  # fmt: skip
def test_bad_input_exits_with_status_2(analog_card, line, expected):
    result = analog_card(line)
    assert result.exit_code == 2, result.output
    assert expected in result.output
    assert "Traceback" not in result.output


def test_a_large_mega_is_none_of_a_milli(analog_card):
    for written in ("1MEGohm", "1Meg", "1m"):
        result = analog_card(f"simulate own.cir --analysis op --param r={written}")
        assert result.exit_code == 0, result.output


def test_nothing_is_written_for_a_plot_that_cannot_be(analog_card, tmp_path):
    result = analog_card("simulate own.cir --analysis op --out own.csv --plot own.svg")
    assert result.exit_code == 2
    assert not (tmp_path / "own.csv").exists()


@pytest.mark.parametrize(("option", "file"), [("--out", "part.csv"), ("--plot", "net.svg")])
def test_what_is_read_is_not_written_over(analog_card, tmp_path, option, file):
    (tmp_path / "part.csv").write_text(PART)
    (tmp_path / "net.svg").write_text(OWN.replace("part.lib", "part.csv"))
    before = (tmp_path / file).read_text()
    result = analog_card(f"simulate net.svg --analysis tran {option} ./{file}")
    assert result.exit_code == 2
    assert f"{file}: is read, and nothing that is read is written over" in result.output
    assert (tmp_path / file).read_text() == before


@pytest.mark.parametrize("name", [".", "/b", "a/c"])
def test_a_name_that_hdf5_cannot_hold_is_refused(analog_card, tmp_path, name):
    (tmp_path / "odd.cir").write_text(f"odd\nV1 a 0 1\nR1 a {name} 1k\nR2 {name} 0 1k\n.end\n")
    result = analog_card("simulate odd.cir --analysis op --out odd.h5")
    assert result.exit_code == 2
    assert f"HDF5 cannot hold the name '{name}'; write .csv, .parquet" in result.output
    assert analog_card("simulate odd.cir --analysis op --out odd.csv").exit_code == 0


@pytest.mark.parametrize(
    "lines",
    [
        ".control\nshell touch ran\n.endc",
        "*# shell touch ran",
        ".include ../secret.lib",
        ".lib ../secret.lib tt",
        "A1 a b code\n.model code d_process(process_file=touch)",
        ".model m numd level=1 \\\\\noutput rootfile=ran",
        ".model d_state numd level=1\nD1 a 0 d_state",
    ],
)
def test_what_is_not_a_circuit_is_refused(analog_card, tmp_path, lines):
    (tmp_path / "inner").mkdir()
    (tmp_path / "secret.lib").write_text("R1 a 0 1\n")
    (tmp_path / "inner" / "bad.cir").write_text(f"bad\nV1 a 0 1\n{lines}\n.end\n")
    result = analog_card("simulate inner/bad.cir --analysis op")
    assert result.exit_code == 2
    assert "bad.cir, line 3" in result.output
    assert not list(tmp_path.rglob("ran"))


def test_a_command_behind_the_first_letter_of_an_element_is_not_run(analog_card, tmp_path):
    part = ".subckt unused a b\nv#shell touch ran\n.ends"
    (tmp_path / "bad.cir").write_text(f"bad\nV1 a 0 1\nR1 a 0 1k\n{part}\n.end\n")
    result = analog_card("simulate bad.cir --analysis op")
    assert result.exit_code == 2
    assert "bad.cir, line 5: a hidden command" in result.output
    assert not list(tmp_path.rglob("ran"))


def test_a_failure_of_ngspice_is_a_message(analog_card, tmp_path):
    (tmp_path / "loop.cir").write_text("loop\nV1 a 0 1\nV2 a 0 2\n.end\n")
    result = analog_card("simulate loop.cir --analysis op")
    assert result.exit_code == 2
    assert re.search(r"loop\.cir: node v\d#branch: loop\.cir line [23]: .*singular", result.output)


def test_opamp_table(analog_card):
    result = analog_card("opamp")
    assert result.exit_code == 0
    assert result.output.count("pass") == 22
    assert "FAIL" not in result.output
    assert "[3] rise time" in result.output
    found = json.loads(analog_card("opamp --json").output)
    assert found["passed"] is True
    assert {"name", "data_sheet", "measured", "deviation_per_cent", "why"} <= set(
        found["figures"][0]
    )


def test_opamp_fails_with_status_1(analog_card, tmp_path):
    # A slow one misses the full-power bandwidth of the data sheet.
    (tmp_path / "slow.toml").write_text('[soldered.operational_amplifier]\nslew_rate = "4 V/us"\n')
    result = analog_card("opamp --design slow.toml")
    assert result.exit_code == 1
    assert "FAIL" in result.output


def test_the_schematic_carries_the_values_of_the_design(analog_card, tmp_path):
    (tmp_path / "mine.toml").write_text(
        '[soldered.inverter]\nresistance = "27 kohm"\n[turned]\nlevel = 0.333\n'
    )
    assert analog_card("schematic --design mine.toml --out card.svg").exit_code == 0
    text = (tmp_path / "card.svg").read_text()
    ElementTree.fromstring(text)  # noqa: S314 - our own picture
    for word in ("Ri 27 kΩ", "33.3 %", "acceleration tap", "U9"):
        assert f"<!-- {word} -->" in text or word in text, word


def drawn_texts():
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 12), layout="constrained")
    ax = figure.subplots()
    assert draw_card(load_design(), ax) is ax
    figure.draw_without_rendering()
    return [(text.get_text(), text.get_window_extent()) for text in ax.texts if text.get_text()]


def test_no_text_of_the_schematic_lies_on_another():
    texts = drawn_texts()
    assert len(texts) > 60
    for number, (first, box) in enumerate(texts):
        for second, other in texts[number + 1 :]:
            assert not box.overlaps(other), (first, second)


def test_every_part_of_a_channel_is_on_the_schematic():
    words = " ".join(text for text, _ in drawn_texts())
    parts = load_design().soldered
    assert re.findall(r"\bU\d", words) == [f"U{k}" for k in (1, 3, 4, 2, 5, 6, 7, 8, 9)]
    for name in ("P1", "P2", "P3", "P4", "R1", "R2", "R3", "Rf", "D1, D2", "Rg", "Rb", "Rc"):
        assert name in words
    for value in (
        parts.surface_amplifier.velocity_resistance,
        parts.boundary_layer_amplifier.ground_resistance,
    ):
        assert as_text(value, "ohm", 3) in words


def test_help_is_light():
    # The command line must not load numerical libraries to print its help.
    code = (
        "import sys; from analog_card.command_line import main;"
        "print([name for name in ('numpy', 'matplotlib', 'schemdraw') if name in sys.modules])"
    )
    done = run_program([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
