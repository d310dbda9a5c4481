import re
import time

import pytest

import netlists
from analog_card import netlist_elements
from analog_card.analyses import (
    FrequencySweep,
    Noise,
    OperatingPoint,
    SourceSweep,
    Transient,
    analysis_in,
)
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.netlist_elements import elements
from analog_card.netlist_text import ASSIGNMENT, read_netlist, spice_number

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
        (["t", ".if (0)", "q=5", ".endif", ".end"], "an assignment in place of an element"),
        (["t", "V1 a 0 pwl(", *["+ 0 0 1 1" * 999] * 12, ".end"], "longer than 100000 characters"),
        (["t", ".subckt s a b", "v#shell touch ran", ".ends", ".end"], "a hidden command"),
        (["t", "R# shell touch ran", ".end"], "a hidden command"),
        (["t", ".model m d(is=1e-14) \\\\", "output rootfile=x", ".end"], r"ends in \\"),
        (["t", ".model m numd level=1", ".end"], "a model of type 'numd'"),
        (["t", ".MODEL m file_source(file=x)", ".end"], "a model of type 'file_source'"),
        (["t", ".model m", ".end"], "a model of type ''"),
        (["t", "D1 a 0 m ic.file=x", ".end"], "read from a file"),
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


def test_links_in_a_circle_are_no_file(tmp_path):
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(InputError, match="Too many levels of symbolic links"):
        read_netlist(loop)
    with pytest.raises(InputError, match="loop is not a file"):
        read_netlist(write(tmp_path, "t", ".include loop", ".end"))


def test_a_link_to_a_netlist_includes_what_lies_beside_its_target(tmp_path):
    real = tmp_path / "real"
    real.mkdir()
    write(real, "R1 a 0 1k", name="part.lib")
    write(tmp_path, "R9 a 0 1", name="secret.lib")
    link = tmp_path / "link.cir"
    link.symlink_to(write(real, "t", ".include part.lib", ".end"))
    assert [line.text for line in read_netlist(link).lines] == ["t", "R1 a 0 1k", ".end"]
    # Beside the link, but not beside the file that it leads to.
    link.unlink()
    link.symlink_to(write(real, "t", f".include {tmp_path}/secret.lib", ".end"))
    with pytest.raises(InputError, match="outside the netlist's folder"):
        read_netlist(link)


@pytest.mark.parametrize("path", ["a//b/x.lib", "a;b.lib", '"a/b/x.lib"', "a/b/x.lib ; c // d $ e"])
def test_a_path_may_hold_the_signs_of_a_comment(tmp_path, path):
    (tmp_path / "a" / "b").mkdir(parents=True)
    for name in ("a/b/x.lib", "a;b.lib"):
        write(tmp_path, "R1 a 0 1k", name=name)
    netlist = read_netlist(write(tmp_path, "t", f".include {path}", ".end"))
    assert [line.text for line in netlist.lines] == ["t", "R1 a 0 1k", ".end"]


def test_a_byte_order_mark_is_no_part_of_an_included_file(tmp_path):
    (tmp_path / "part.lib").write_text("* comment\nR1 a 0 1k\n", encoding="utf-8-sig")
    netlist = read_netlist(write(tmp_path, "t", ".include part.lib", ".end"))
    assert [line.text for line in netlist.lines] == ["t", "R1 a 0 1k", ".end"]


def test_every_file_read_is_known(tmp_path):
    # Also one of comments only, and one that only includes.
    write(tmp_path, "* nothing", name="empty.lib")
    write(tmp_path, ".include empty.lib", name="all.lib")
    netlist = read_netlist(write(tmp_path, "t", ".include all.lib", ".end"))
    assert [file.name for file in netlist.files] == ["circuit.cir", "all.lib", "empty.lib"]


def test_the_search_for_assignments_grows_no_faster_than_the_line():
    before = time.process_time()
    assert ASSIGNMENT.findall(".param " + "a" * 50_000) == []
    with pytest.raises(ValueError, match="not a number"):
        spice_number("1" * 50_000 + "!")
    # Some milliseconds; 20 s and more when every letter could begin a name.
    assert time.process_time() - before < 2


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


@pytest.mark.parametrize("name", ["card", "card-ac", "double-differentiator-transient"])
def test_shipped_values_are_those_of_the_recommended_card(name):
    # The netlists run as they are, so they repeat the values of the design file: they must agree.
    parameters = read_netlist(netlists.shipped()[name]).parameters
    for parameter, value in load_design().netlist_parameters().items():
        assert spice_number(parameters[parameter]) == pytest.approx(value, rel=1e-9), parameter


def test_every_value_in_values_lib_is_known_to_the_design():
    text = (netlists.ROOT / "values.lib").read_text()
    names = set(re.findall(r"^\.param (\w+)", text, re.MULTILINE))
    # The link is open or closed: a jumper, not a part.
    assert names - load_design().netlist_parameters().keys() == {"boundary_layer_link"}


@pytest.mark.parametrize(
    ("text", "value"),
    [("4.5meg", 4.5e6), ("4.5MEG", 4.5e6), ("100nF", 1e-7), ("1M", 1e-3), ("10kohm", 1e4),
     ("-2.5e-3", -2.5e-3), ("1e3k", 1e6), (".5u", 5e-7), ("3", 3.0), ("7f", 7e-15), ("2g", 2e9)],
)  # fmt: skip
def test_numbers_as_spice_writes_them(text, value):
    assert spice_number(text) == value


@pytest.mark.parametrize("text", ["", "abc", "{2*a}", "1 k", "--1", "1k2"])
def test_what_is_not_a_number(text):
    with pytest.raises(ValueError, match="not a number"):
        spice_number(text)


def test_saved_nodes_stand_ahead_of_the_end(tmp_path):
    netlist = read_netlist(write(tmp_path, "t", "V1 a 0 1", ".end")).with_saved(["a", "v1#branch"])
    assert [line.text for line in netlist.lines[-2:]] == [".save v(a) v1#branch", ".end"]
    with pytest.raises(InputError, match="not a name"):
        netlist.with_saved(["a) shell"])


def test_elements_of_nested_subcircuits_have_paths(tmp_path):
    netlist = read_netlist(
        write(tmp_path, "t", ".subckt inner a b r=1", "R1 a b {r}", ".ends", ".subckt outer a",
              "Xone a 0 inner r = 2", "C1 a 0 1n", ".ends", "Vin n 0 1", "XA n outer", ".end")
    )  # fmt: skip
    found = elements(netlist)
    assert list(found) == ["vin", "xa.xone.r1", "xa.c1"]
    assert found["xa.xone.r1"].number == 3


@pytest.mark.parametrize("again", ["s", "t"])
def test_a_subcircuit_that_calls_itself_is_refused(tmp_path, again):
    calls = [f"X{k} a {again}" for k in range(1, 4)]
    lines = [".subckt s a", *calls, ".ends", ".subckt t a", "X1 a s", ".ends", "X9 n s", ".end"]
    netlist = read_netlist(write(tmp_path, "t", *lines))
    with pytest.raises(InputError, match=r"circuit\.cir, line \d: subcircuit 's' calls itself"):
        elements(netlist)


def test_subcircuits_that_open_into_too_many_elements_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(netlist_elements, "_MOST", 100)
    lines = ["t"]
    for k in range(20):
        lines += [f".subckt s{k} a", f"X1 a s{k + 1}", f"X2 a s{k + 1}", ".ends"]
    # The innermost is empty: what counts is what has to be looked at.
    netlist = read_netlist(write(tmp_path, *lines, ".subckt s20 a", ".ends", "X1 n s0", ".end"))
    with pytest.raises(InputError, match="more than 100 elements"):
        elements(netlist)


@pytest.mark.parametrize(
    ("line", "kind", "expected"),
    [
        (".ac dec 10 1 1meg", "ac", FrequencySweep(1.0, 1e6, 10)),
        (".tran 1u 1m", "tran", Transient(1e-3, 1e-6)),
        (".TRAN 1u 1m 0 5u uic", "tran", Transient(1e-3, 5e-6, True)),
        (".dc V1 -1 1 100m", "dc", SourceSweep("V1", -1.0, 1.0, 0.1)),
        (".noise v(out) V1 dec 5 1 1k", "noise", Noise("out", "V1", 1.0, 1e3, 5)),
        (".end", "op", OperatingPoint()),
    ],
)
def test_analyses_are_read_from_the_netlist(tmp_path, line, kind, expected):
    lines = ["t", "V1 out 0 1"] + [line] * (kind != "op") + [".end"]
    assert analysis_in(read_netlist(write(tmp_path, *lines)), kind) == expected


@pytest.mark.parametrize(
    ("line", "kind", "expected"),
    [
        (".ac lin 10 1 1k", "ac", "line 3: not understood"),
        (".tran {a} 1m", "tran", "with plain numbers"),
        (".tran 1u", "tran", "not understood"),
        (".noise v(a,b) V1 dec 5 1 1k", "noise", "not understood"),
        (".ac dec 10 1 1k", "tran", "no .tran line"),
    ],
)
def test_analyses_that_are_not_understood(tmp_path, line, kind, expected):
    with pytest.raises(InputError, match=expected):
        analysis_in(read_netlist(write(tmp_path, "t", "V1 a 0 1", line, ".end")), kind)


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
