"""Sidecars: what they say ends up in SI, and what they cannot say is refused."""

from pathlib import Path

import pytest

from pneuservo.recordings import read_recording
from pneuservo.rigs import BUILT_IN_RIGS

ROWS = "".join(f"{10 * i},{i}.5,{0.1 * (i % 3):.1f}\n" for i in range(20))
TABLE = "t,x,p\n" + ROWS
TIME = '[time]\ncolumn = "t"\nunit = "ms"\n'
CHANNELS = '[channels]\ndisplacement = { column = "x", unit = "mm" }\n'
# 1.013 bar is not a whole number of units in the last place: one rounding is allowed for.
AMBIENT = pytest.approx(1.013e5, rel=1e-15)
CARD = {
    "rc_velocity": '"82 ms"',
    "rc_acceleration": '"4.7e-3 s"',
    "break_frequency": '"5 kHz"',
    "weight_displacement": "1.2585",
    "weight_velocity": "0.5372",
    "weight_acceleration": "1",
    "surface_limit": '"13 V"',
    "output_gain": "2.0",
    "level": '"5 V"',
}


def sidecar(text: str = "", time: str = TIME, channels: str = CHANNELS) -> str:
    return f"{text}\n{time}\n{channels}\n"


def channel(entry: str) -> str:
    return f"[channels]\n{entry}\n"


def card(**changes: str | None) -> str:
    figures = {**CARD, **changes}
    return "[card]\n" + "".join(f"{k} = {v}\n" for k, v in figures.items() if v is not None)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("velocity", "m/s"),
        ("acceleration", "m/s2"),
        ("temperature_a", "K"),
        ("valve_voltage", "V"),
        ("spool", "1"),
        ("force", "N"),
    ],
)
def test_canonical_units_may_be_written_out(save, name, unit):
    entry = f'{CHANNELS}{name} = {{ column = "p", unit = "{unit}" }}\n'
    recording = read_recording(save(TABLE, sidecar(channels=entry)))
    assert recording.channels[name][:3].tolist() == [0.0, 0.1, 0.2]


def test_everything_in_a_sidecar_arrives_in_si(save):
    recording = read_recording(
        save(
            TABLE,
            """
            [recording]
            title = "step 15 to 24 mm"
            rig = "single-axis"
            taken = 1998-05-12
            notes = "warm"
            [conditions]
            supply_pressure = "6.1 bar gauge"
            ambient_pressure = "1.02 bar"
            temperature = "21 degC"
            load_mass = "6.82 kg"
            [controller]
            kind = "analogue-card"
            settling_time = "70 ms"
            [time]
            column = "t"
            unit = "ms"
            [channels]
            displacement = { column = "x", unit = "mm", scale = -1, offset = 9, noise_rms = "3 um" }
            pressure_a = { column = "p", unit = "bar", gauge = true, noise_rms = "0.1 mbar" }
            temperature_a = { column = "x", unit = "degC", noise_rms = "0.5 degC" }
            spool = { column = "p" }
            """,
        )
    )
    assert (recording.title, recording.taken, recording.notes) == (
        "step 15 to 24 mm",
        "1998-05-12",
        "warm",
    )
    assert recording.conditions == pytest.approx(
        {
            "supply_pressure": 6.1e5 + 1.02e5,
            "ambient_pressure": 1.02e5,
            "temperature": 294.15,
            "load_mass": 6.82,
        },
        rel=1e-14,
    )
    assert recording.controller == {"kind": "analogue-card", "settling_time": 0.07}
    assert recording["displacement"][3] == pytest.approx(0.001 * (9 - 3.5), rel=1e-14)
    assert recording["pressure_a"][1] == pytest.approx(0.1e5 + 1.02e5, rel=1e-14)
    assert recording["temperature_a"][0] == pytest.approx(273.65, rel=1e-14)
    assert recording["spool"][2] == 0.2
    # A noise is a difference: a temperature's zero point and a gauge's ambient stay out of it.
    assert recording.noise_rms == pytest.approx(
        {"displacement": 3e-6, "pressure_a": 10.0, "temperature_a": 0.5}, rel=1e-12
    )
    assert recording.source.name == "run.csv"
    assert recording.name == "run"


def test_gauge_adds_the_rigs_ambient_pressure_where_the_sidecar_has_none(save):
    text = sidecar(
        '[recording]\nrig = "dead-volume"\n',
        channels=channel('dead_volume_pressure = { column = "p", unit = "bar", gauge = true }'),
    )
    assert read_recording(save(TABLE, text))["dead_volume_pressure"][0] == AMBIENT


@pytest.mark.parametrize("unit", ["bar gauge", "barg", "bar(g)"])
def test_a_unit_may_say_gauge_itself(save, unit):
    text = sidecar(channels=channel(f'pressure_a = {{ column = "p", unit = "{unit}" }}'))
    assert read_recording(save(TABLE, text))["pressure_a"][0] == AMBIENT


@pytest.mark.parametrize("unit", ["m/s2", "m/s^2", "m/s**2", "m/s²"])
def test_powers_are_written_in_many_ways(save, unit):
    text = sidecar(channels=channel(f'acceleration = {{ column = "x", unit = "{unit}" }}'))
    assert read_recording(save(TABLE, text))["acceleration"][3] == 3.5


@pytest.mark.parametrize("rig", BUILT_IN_RIGS)
def test_every_built_in_rig_is_known(save, rig):
    assert read_recording(save(TABLE, sidecar(f'[recording]\nrig = "{rig}"\n'))).rig == rig


def test_a_rig_file_in_the_folder_is_used_and_the_caller_overrules_it(save, tmp_path):
    (tmp_path / "mine.toml").write_text(
        '[rig]\nkind = "single-axis"\n[parameters]\n"ambient.pressure" = { value = "0.9 bar" }\n'
    )
    text = sidecar(
        '[recording]\nrig = "mine.toml"\n',
        channels=channel('pressure_a = { column = "p", unit = "bar", gauge = true }'),
    )
    path = save(TABLE, text)
    recording = read_recording(path)
    assert Path(recording.rig) == tmp_path / "mine.toml"
    assert recording["pressure_a"][0] == pytest.approx(0.9e5)
    assert read_recording(path, rig="single-axis").rig == "single-axis"
    assert read_recording(path, rig="single-axis")["pressure_a"][0] == AMBIENT


def test_card_figures_and_design_files_are_kept(save, tmp_path):
    recording = read_recording(save(TABLE, sidecar(card())))
    assert recording.card == {
        "rc_velocity": pytest.approx(0.082),
        "rc_acceleration": 4.7e-3,
        "break_frequency": 5000.0,
        "weight_displacement": 1.2585,
        "weight_velocity": 0.5372,
        "weight_acceleration": 1.0,
        "surface_limit": 13.0,
        "output_gain": 2.0,
        "level": 5.0,
    }
    assert recording.warnings == ()
    (tmp_path / "cards").mkdir()
    (tmp_path / "cards" / "mine.toml").write_text("")
    path = save(TABLE, sidecar('[card]\ndesign = "cards/mine.toml"\n'))
    assert read_recording(path).card == {"design": str(tmp_path / "cards" / "mine.toml")}


def test_a_card_figure_that_is_not_given_is_told(save):
    recording = read_recording(save(TABLE, sidecar(card(level=None))))
    assert "level" not in recording.card
    assert any("[card] does not give level" in text for text in recording.warnings)


def test_a_condition_that_the_rig_has_no_parameter_for_is_told(save):
    text = sidecar('[recording]\nrig = "circuit"\n[conditions]\ntemperature = "20 degC"\n')
    recording = read_recording(save(TABLE, text))
    assert recording.conditions == {}
    assert any("condition temperature" in text for text in recording.warnings)


def test_a_sidecar_without_channels_leaves_the_canonical_names(save):
    path = save(TABLE.replace("t,x,p", "time,force,note"), '[recording]\nrig = "seal-tester"\n')
    recording = read_recording(path)
    assert recording.rig == "seal-tester"
    assert set(recording.channels) == {"force"}
    assert any("left out: 'note'" in text for text in recording.warnings)


def test_time_counts_from_the_start_of_the_recording(save):
    later = "t,x,p\n" + "".join(f"{5000 + 10 * i},{i}.5,0\n" for i in range(20))
    assert read_recording(save(later, sidecar())).time[0] == 0.0
    # A column `time` in s says of itself that it counts from the start, as a part of a
    # recording does.
    part = "time,force\n" + "".join(f"{5 + i},{i}.5\n" for i in range(20))
    assert read_recording(save(part, name="part.csv")).time[0] == 5.0


X = '"x", unit = "mm"'
REFUSED = [
    # What the sidecar says, and what the message has to say about it.
    pytest.param(sidecar("[recording\n"), ["not valid TOML", "line 1"], id="no TOML"),
    pytest.param(sidecar("a = " + "[" * 5000), ["not valid TOML"], id="lists within lists"),
    pytest.param(sidecar("a = 1" + "0" * 5000), ["not valid TOML"], id="a number without end"),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, scale = 1{'0' * 400} }}")),
        ["not valid TOML", "64 bits"],
        id="an integer longer than TOML's",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, scale = 1e400 }}")),
        ["finite number"],
        id="a scale beyond range",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "10 mm" }')),
        ["10 mm", "is not known"],
        id="a unit with a number",
    ),
    pytest.param(sidecar("[chanels]\n"), ["'chanels'", "'channels'?"], id="table"),
    pytest.param(sidecar("recording = 3\n"), ["recording is 3", "[recording]"], id="no table"),
    pytest.param(sidecar('[recording]\ntitel = ""\n'), ["'titel'", "'title'?"], id="key"),
    pytest.param(sidecar("[recording]\ntitle = 3\n"), ["title is 3", "text"], id="type"),
    pytest.param(sidecar("[recording]\ntaken = 3\n"), ["taken is 3", "date"], id="date"),
    pytest.param(
        sidecar('[recording]\nrig = "singel-axis"\n'), ["'singel-axis'", "'single-axis'?"], id="rig"
    ),
    pytest.param(
        sidecar('[conditions]\nload_mas = "3 kg"\n'), ["'load_mas'", "'load_mass'?"], id="condition"
    ),
    pytest.param(
        sidecar('[conditions]\nload_mass = "3 bar"\n'),
        ["load_mass", "'bar'", "wrong dimension", "a mass"],
        id="condition of another dimension",
    ),
    pytest.param(sidecar("[conditions]\nload_mass = 3.0\n"), ["no unit", "kg"], id="bare number"),
    pytest.param(
        sidecar('[conditions]\nload_mass = "3,5 kg"\n'), ["'3,5 kg'", "point"], id="decimal comma"
    ),
    pytest.param(sidecar('[conditions]\nload_mass = "kg"\n'), ["begin with a number"], id="unit"),
    pytest.param(sidecar("[conditions]\nload_mass = true\n"), ["not a quantity"], id="boolean"),
    pytest.param(
        sidecar('[conditions]\nload_mass = "1e999 kg"\n'), ["not a finite number"], id="huge"
    ),
    pytest.param(
        sidecar('[conditions]\nambient_pressure = "1 bar gauge"\n'),
        ["gauge pressure", "absolute"],
        id="gauge ambient",
    ),
    pytest.param(
        sidecar('[conditions]\nsupply_pressure = "-2 bar"\n'), ["-200000 Pa"], id="pressure below 0"
    ),
    pytest.param(
        sidecar('[conditions]\ntemperature = "-300 degC"\n'), ["absolute zero"], id="temperature"
    ),
    pytest.param(sidecar("[controller]\nsettling_time = '1 s'\n"), ["kind"], id="no kind"),
    pytest.param(
        sidecar('[controller]\nkind = "analog-card"\n'), ["'analogue-card'?"], id="controller kind"
    ),
    pytest.param(
        sidecar('[controller]\nkind = "none"\nsettling_time = "0 s"\n'),
        ["settling_time", "greater than 0"],
        id="settling time",
    ),
    pytest.param(
        sidecar('[controller]\nkind = "none"\nsetling_time = "1 s"\n'),
        ["'settling_time'?"],
        id="controller key",
    ),
    pytest.param(sidecar(card(level='"5 bar"')), ["level", "a voltage"], id="card unit"),
    pytest.param(sidecar(card(level='"-5 V"')), ["level", "greater than 0"], id="card sign"),
    pytest.param(sidecar(card(levle='"5 V"')), ["'level'?"], id="card key"),
    pytest.param(sidecar(card(design='"a.toml"')), ["not both"], id="card twice"),
    pytest.param(sidecar("[card]\ndesign = 3\n"), ["design is 3"], id="design"),
    pytest.param(sidecar('[card]\ndesign = "no.toml"\n'), ["no file 'no.toml'"], id="no design"),
    pytest.param(sidecar("[table]\nheader = 0\n"), ["true or false"], id="header"),
    pytest.param(sidecar("[table]\nheader = false\n"), ["needs names"], id="no names"),
    pytest.param(sidecar('[table]\nnames = ["a"]\n'), ["header = false"], id="names"),
    pytest.param(sidecar("[table]\nheader = false\nnames = 3\n"), ["a list"], id="names type"),
    pytest.param(
        sidecar('[table]\nheader = false\nnames = ["a", "a"]\n'), ["'a' more than once"], id="same"
    ),
    pytest.param(
        sidecar('[table]\nheader = false\nnames = ["t", "x", "p"]\n'),
        ["line 1, column 't'", "'t' is not a number"],
        id="there is a header",
    ),
    pytest.param(
        sidecar('[table]\nheader = false\nnames = ["t", "x"]\n'),
        ["line 1", "3 fields", "names has 2"],
        id="too few names",
    ),
    pytest.param(sidecar(time='[time]\nrate = "0 Hz"\n'), ["rate", "greater than 0"], id="rate 0"),
    pytest.param(sidecar(time='[time]\nrate = "-5 Hz"\n'), ["greater than 0"], id="rate below 0"),
    pytest.param(sidecar(time='[time]\nrate = "5 s"\n'), ["'s'", "a frequency"], id="rate unit"),
    pytest.param(sidecar(time='[time]\nrate = "5 Hz"\ncolumn = "t"\n'), ["not both"], id="both"),
    pytest.param(sidecar(time='[time]\nunit = "s"\n'), ["column", "rate"], id="neither"),
    pytest.param(sidecar(time='[time]\ncolumn = "t"\n'), ["no unit", "ms"], id="no time unit"),
    pytest.param(
        sidecar(time='[time]\ncolumn = "t"\nunit = "mm"\n'), ["'mm'", "a time"], id="time unit"
    ),
    pytest.param(
        sidecar(time='[time]\ncolumn = "T"\nunit = "s"\n'),
        ["no column 'T'", "'t', 'x', 'p'", "'t'?"],
        id="no such time column",
    ),
    pytest.param(sidecar(channels="[channels]\n"), ["is empty"], id="no channels"),
    pytest.param(
        sidecar(channels=channel(f"displacment = {{ column = {X} }}")),
        ["'displacment'", "'displacement'?"],
        id="channel",
    ),
    pytest.param(
        sidecar(channels=channel('time = { column = "t", unit = "s" }')), ["[time]"], id="time"
    ),
    pytest.param(
        sidecar(channels=channel('force = { column = "F", unit = "N" }')),
        ["no column 'F'", "'t', 'x', 'p'", "[channels] force"],
        id="no such column",
    ),
    pytest.param(sidecar(channels=channel('force = "x"')), ["say the column"], id="no mapping"),
    pytest.param(
        sidecar(channels=channel('force = { unit = "N" }')), ["say the column"], id="none"
    ),
    pytest.param(sidecar(channels=channel('force = { column = "x" }')), ["no unit"], id="no unit"),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, ofset = 1 }}")),
        ["'ofset'", "'offset'?"],
        id="channel key",
    ),
    pytest.param(
        sidecar(channels=channel(f'displacement = {{ column = {X}, scale = "2" }}')),
        ["scale is '2'", "finite number"],
        id="scale type",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, offset = inf }}")),
        ["offset is inf", "finite number"],
        id="offset",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, scale = 0 }}")),
        ["scale is 0"],
        id="scale 0",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "furlongs_per_ox" }')),
        ["[channels] displacement", "'furlongs_per_ox' is not known", "mm"],
        id="unknown unit",
    ),
    pytest.param(
        sidecar(channels=channel('pressure_a = { column = "x", unit = "Bar" }')),
        ["'Bar' is not known", "'bar'?"],
        id="nearly a unit",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "bar" }')),
        ["[channels] displacement", "'bar'", "wrong dimension", "a length"],
        id="unit of another dimension",
    ),
    pytest.param(
        sidecar(
            channels=channel('pressure_a = { column = "x", unit = "bar gauge", gauge = false }')
        ),
        ["the unit says gauge, and gauge = false"],
        id="gauge and not",
    ),
    pytest.param(
        sidecar('[card]\nbreak_frequency = "31416 rad/s"\n'),
        ["break_frequency", "'rad/s'", "a frequency"],
        id="an angular frequency",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "dimensionless" }')),
        ["wrong dimension", "a length"],
        id="a pure number for a length",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "" }')),
        ["'' is not known"],
        id="empty unit",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "m**9**9**9**9" }')),
        ["is not known"],
        id="a tower of powers",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "10**9**9 * m" }')),
        ["is not known"],
        id="a number in a unit",
    ),
    pytest.param(
        sidecar(channels=channel('displacement = { column = "x", unit = "__import__(\'os\')" }')),
        ["is not known"],
        id="code in a unit",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, gauge = true }}")),
        ["only for pressures"],
        id="a gauge length",
    ),
    pytest.param(
        sidecar(channels=channel('pressure_a = { column = "p", unit = "bara", gauge = true }')),
        ["absolute", "gauge = true"],
        id="gauge and absolute",
    ),
    pytest.param(
        sidecar(
            '[recording]\nrig = "circuit"\n',
            channels=channel('pressure_a = { column = "p", unit = "bar", gauge = true }'),
        ),
        ["circuit", "no ambient pressure", "ambient_pressure"],
        id="gauge without ambient",
    ),
    pytest.param(
        sidecar(channels=channel(f'displacement = {{ column = {X}, noise_rms = "-1 mm" }}')),
        ["noise_rms", "negative"],
        id="noise below 0",
    ),
    pytest.param(
        sidecar(channels=channel(f'displacement = {{ column = {X}, noise_rms = "1 bar" }}')),
        ["noise_rms", "a length"],
        id="noise unit",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, noise_rms = 0.1 }}")),
        ["noise_rms", "no unit"],
        id="noise without unit",
    ),
    pytest.param(
        sidecar(channels=channel(f"displacement = {{ column = {X}, noise_rms = [1] }}")),
        ["noise_rms is [1]"],
        id="noise type",
    ),
]


@pytest.mark.parametrize(("text", "told"), REFUSED)
def test_what_a_sidecar_cannot_say_is_refused(save, refusal, text, told):
    message = refusal(save(TABLE, text))
    for part in [*told, "run."]:
        assert part in message


def test_a_channel_given_twice_is_refused(save, refusal):
    text = sidecar(channels=CHANNELS + 'displacement = { column = "p", unit = "mm" }\n')
    message = refusal(save(TABLE, text))
    assert "not valid TOML" in message
    assert "line " in message


def test_a_sidecar_that_is_not_utf8_is_refused(save, refusal):
    path = save(TABLE)
    path.with_suffix(".toml").write_bytes('[recording]\ntitle = "Größe"\n'.encode("latin-1"))
    assert "not UTF-8" in refusal(path)


@pytest.mark.parametrize("table", ['[recording]\nrig = "{}"\n', '[card]\ndesign = "{}"\n'])
def test_a_path_that_leaves_the_folder_is_refused(tmp_path, refusal, table):
    outside = tmp_path / "outside.toml"
    outside.write_text('[rig]\nkind = "single-axis"\n')
    folder = tmp_path / "runs"
    folder.mkdir()
    (folder / "link.toml").symlink_to(outside)
    path = folder / "run.csv"
    path.write_text(TABLE)
    for text in ("../outside.toml", str(outside), "link.toml", "../runs/../outside.toml"):
        path.with_suffix(".toml").write_text(sidecar(table.format(text)))
        message = refusal(path)
        assert f"{text!r} leaves the recording's folder" in message
        assert "copy the file into that folder" in message
