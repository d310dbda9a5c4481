import re

import pytest

import netlists
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.netlist_text import read_netlist

BENCHES = sorted((netlists.ROOT / "benches").glob("*.cir"))
FILES = sorted(netlists.ROOT.rglob("*.lib")) + BENCHES


def write(folder, *lines, name="circuit.cir"):
    file = folder / name
    file.write_text("\n".join(lines) + "\n")
    return file


def test_includes_are_put_in_place_and_comments_taken_out(tmp_path):
    write(tmp_path, "* part", "R1 a b 1k ; one", "R2 b 0", "+ 2k $ two", name="part.lib")
    netlist = read_netlist(
        write(tmp_path, "divider", "V1 a 0 1 // source", "", '.include "part.lib"', ".end", "junk")
    )
    assert [line.text for line in netlist.lines] == [
        "divider",
        "V1 a 0 1",
        "R1 a b 1k",
        "R2 b 0 2k",
        ".end",
    ]
    assert [(line.file.name, line.number) for line in netlist.lines[2:4]] == [
        ("part.lib", 2),
        ("part.lib", 3),
    ]


def test_parameters_are_replaced_at_the_top_level_only(tmp_path):
    file = write(
        tmp_path,
        "parameters",
        ".param a=1 b={2*a}",
        "+ c = 3n",
        ".subckt s x y",
        ".param a=7",
        ".ends",
        ".end",
    )
    netlist = read_netlist(file)
    assert netlist.parameters == {"a": "1", "b": "{2*a}", "c": "3n"}
    changed = netlist.with_parameters({"A": 1e-7, "c": 5})
    assert changed.lines[1].text == ".param a=1e-07 b={2*a} c=5.0"
    assert changed.lines[3].text == ".param a=7"
    assert netlist.lines[1].text == ".param a=1 b={2*a} c = 3n"


def test_an_unknown_parameter_names_the_nearest(tmp_path):
    netlist = read_netlist(write(tmp_path, "t", ".param resistance=1", ".end"))
    with pytest.raises(InputError, match="no parameter 'resistence'; nearest is 'resistance'"):
        netlist.with_parameters({"resistence": 1.0})


def test_an_expression_without_braces_is_not_guessed_at(tmp_path):
    netlist = read_netlist(write(tmp_path, "t", ".param a=1 + 2", ".end"))
    with pytest.raises(InputError, match="put expressions in braces"):
        netlist.with_parameters({"a": 1.0})


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (["t", ".control", "shell ls", ".endc", ".end"], "line 2: .control is not accepted"),
        (["t", "  .CONTROL", ".end"], ".control is not accepted"),
        (["t", "*# shell ls", ".end"], "a hidden command"),
        (["t", ".lib models.lib tt", ".end"], ".lib is not accepted"),
        (["t", "A1 a b code", ".model code d_process(process_file=x)", ".end"], "plain SPICE"),
        (["t", "N1 a b osdi", ".end"], "plain SPICE"),
        (["t", "V1 a 0 dc 0 external", ".end"], "an external source"),
        (["t", "R1 a 1k", ".end"], "two nodes and a value"),
        (["t", ".include /etc/hostname", ".end"], "outside the netlist's folder"),
        (["t", ".include ../secret.lib", ".end"], "outside the netlist's folder"),
        (["t", ".inc '../secret.lib'", ".end"], "outside the netlist's folder"),
        (["t", ".include missing.lib", ".end"], "missing.lib is not a file"),
        (["t", ".include", ".end"], "an include without a file"),
        (["t", ".include circuit.cir", ".end"], "does a file include itself"),
        (["R1 a 0 1k", "V1 a 0 1", ".end"], "is not a title"),
        ([".param a=1", "V1 a 0 1", ".end"], "is not a title"),
        (["", "V1 a 0 1", ".end"], "is not a title"),
        (["t", "V1 a 0 1"], "no .end"),
    ],
)
def test_what_is_not_a_circuit_is_refused(tmp_path, lines, expected):
    (tmp_path / "secret.lib").write_text("R9 a 0 1\n")
    inner = tmp_path / "inner"
    inner.mkdir()
    with pytest.raises(InputError, match=expected) as caught:
        read_netlist(write(inner, *lines))
    assert "circuit.cir" in str(caught.value)


def test_a_link_to_the_outside_is_outside(tmp_path):
    (tmp_path / "secret.lib").write_text("R9 a 0 1\n")
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "link.lib").symlink_to(tmp_path / "secret.lib")
    with pytest.raises(InputError, match="outside"):
        read_netlist(write(inner, "t", ".include link.lib", ".end"))


def test_shipped_parts_may_be_included_from_anywhere(tmp_path):
    part = netlists.ROOT / "opamp" / "ca3140.lib"
    netlist = read_netlist(write(tmp_path, "t", f".include {part}", ".end"))
    assert "ca3140_slew_rate" in netlist.parameters


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        read_netlist(tmp_path / "no.cir")
    binary = tmp_path / "binary.cir"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="not UTF-8"):
        read_netlist(binary)


@pytest.mark.parametrize("name", ["double-differentiator-ac", "double-differentiator-transient"])
def test_shipped_values_are_those_of_the_recommended_card(name):
    # The netlists run as they are, so they repeat the values of the design file: they must agree.
    parameters = read_netlist(netlists.ROOT / "benches" / f"{name}.cir").parameters
    scale = {"t": 1e12, "meg": 1e6, "k": 1e3, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "": 1}
    for parameter, value in load_design().netlist_parameters().items():
        number, suffix = re.fullmatch(r"([\d.]+)(\w*)", parameters[parameter]).groups()
        assert float(number) * scale[suffix] == pytest.approx(value), parameter


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_shipped_netlists_avoid_the_traps(file):
    lines = file.read_text().splitlines()
    assert lines[0]
    assert "error" not in file.read_text().lower()
    for line in lines:
        # 1M is a milli in SPICE; a mega is 1meg.
        assert not re.search(r"\b\d+(\.\d+)?M\b", line), line
        # In a B source ngspice drops braces before it looks at precedence.
        if line.startswith(("B", "+ +")):
            assert all(re.fullmatch(r"\w+", inner) for inner in re.findall(r"\{(.*?)\}", line)), (
                line
            )
