"""What the pages of the documentation show is as the program has it."""

import re
import tomllib
from pathlib import Path

import pytest

from analog_card.design_file import load_design
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models import required_channels
from pneuservo.examples.leaking_volume import leaking_volume
from pneuservo.recordings import read_recording
from pneuservo.recordings.conditions import CARD_UNITS, CONTROLLER_KINDS
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, load_rig

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def text_of(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def toml_in(name: str) -> list[str]:
    return re.findall(r"```toml\n(.*?)```", text_of(name), re.DOTALL)


def first_column(name: str, head: str) -> list[str]:
    """Return the code words in the first column of the table whose first heading is given."""
    rows = text_of(name).partition(f"| {head} |")[2].partition("\n\n")[0].splitlines()[2:]
    return [word for row in rows for word in re.findall(r"`([^`]+)`", row.split("|")[1])]


def headings(page: Path) -> set[str]:
    lines = page.read_text(encoding="utf-8").splitlines()
    kept = (re.sub(r"[^a-z0-9 _-]", "", x.strip("# ").lower()) for x in lines if x.startswith("#"))
    return {heading.replace(" ", "-") for heading in kept}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_and_pictures_named_exist(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if target.startswith("http"):
            continue
        name, _, heading = target.partition("#")
        file = page.parent / name if name else page
        assert file.is_file(), target
        assert not heading or heading in headings(file), target


def test_rig_files_shown_can_be_read(tmp_path):
    servo, effects = toml_in("rigs.md")
    (tmp_path / "mine.toml").write_text(servo.replace('"valve.toml"', '"ddv-27a1"'))
    rig = load_rig(tmp_path / "mine.toml")
    assert rig["piston.area_a"] == pytest.approx(804.2e-6)
    assert rig["load.gravity"] == 0.0
    (tmp_path / "with.toml").write_text(f'[rig]\nkind = "single-axis"\n{effects}')
    assert load_rig(tmp_path / "with.toml").effect_values["friction.stribeck:speed"] == 8e-3


def test_every_built_in_rig_is_described_with_what_a_diagnosis_needs():
    assert set(first_column("rigs.md", "rig")) == {*BUILT_IN_RIGS, *VARIANTS}
    for row in text_of("rigs.md").splitlines():
        name = row.split("`")[1] if row.startswith("| `") else ""
        for channel in required_channels(name) or () if name in BUILT_IN_RIGS else ():
            assert f"`{channel}`" in row


def test_the_design_file_shown_can_be_read(tmp_path):
    (file,) = toml_in("card.md")
    (tmp_path / "card.toml").write_text(file)
    design = load_design(tmp_path / "card.toml")
    assert design.soldered.velocity_differentiator.series_resistance == 820.0
    assert design.turned.boundary_layer == 0.151


def test_the_sidecars_shown_can_be_read(tmp_path):
    sidecar, card = toml_in("recordings.md")
    (tmp_path / "run.toml").write_text(sidecar)
    rows = "\n".join(f"{10 * k},{15 + 0.01 * k},3.1,0.5" for k in range(50))
    sidecar = tomllib.loads(sidecar)
    assert sidecar["controller"]["kind"] in CONTROLLER_KINDS
    (tmp_path / "run.toml").write_text(
        (tmp_path / "run.toml").read_text().replace('"Pressure"]', '"Pressure", "u"]')
    )
    (tmp_path / "run.csv").write_text(rows)
    recording = read_recording(tmp_path / "run.csv")
    assert recording["displacement"][0] == pytest.approx(15e-3)
    assert set(tomllib.loads(card)["card"]) == {"design", *CARD_UNITS}


def test_every_key_of_an_answer_is_described():
    answer = document(diagnose([leaking_volume()]))
    described = set(first_column("answers.md", "key"))
    assert set(answer) <= described
    verdicts = set(first_column("answers.md", "verdict"))
    assert verdicts == {"consistent", "parameter", "missing-physics", "unexplained"}
    assert described - set(answer) == {"partial", "not_judged", "sessions"}
