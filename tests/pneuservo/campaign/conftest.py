"""What the tests of campaigns share."""

import pytest

from pneuservo.campaign.plan_file import campaign_of
from pneuservo.campaign.run import run_campaign


@pytest.fixture(scope="session")
def arguments():
    """Return the options of a campaign of 40 samples, some 20 ms of computing each."""
    return [
        *("--controller", "sliding-mode", "--demand", "15,24 mm", "--hold", "0.3 s"),
        *("--trials", "20", "--vary", "supply.pressure=6.5, 7.7 bar"),
        *("--vary", "load.mass=normal(1.825 kg, 10 %)"),
    ]


@pytest.fixture(scope="session")
def campaign():
    """Return the same campaign."""
    vary = {"supply.pressure": "6.5, 7.7 bar", "load.mass": "normal(1.825 kg, 10 %)"}
    loop = {"controller": "sliding-mode", "demand": "15,24 mm", "hold": 0.3}
    return campaign_of({**loop, "trials": 20, "vary": vary})


@pytest.fixture(scope="session")
def outcome(campaign):
    """Return what it gives in one process, nothing kept."""
    return run_campaign(campaign)
