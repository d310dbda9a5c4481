"""Campaigns on a cluster: two workers, one of them killed, and nothing is lost."""

import json
import os
import signal

from click.testing import CliRunner

from pneuservo.campaign.cluster import cluster
from pneuservo.campaign.run import SAMPLES, run_campaign
from pneuservo.command_line import main


def test_an_address_without_a_scheduler_is_refused(monkeypatch, arguments):
    monkeypatch.setattr("pneuservo.campaign.cluster._PATIENCE", 0.5)
    for address in ("tcp://127.0.0.1:9", "nowhere", "ftp://nowhere:1"):
        done = CliRunner().invoke(main, ["campaign", *arguments, "--cluster", address])
        assert done.exit_code == 2, done.output
        assert "no scheduler answers" in done.output


def test_a_killed_worker_loses_nothing(tmp_path, arguments, campaign, outcome):
    import dask
    from distributed import Client, LocalCluster

    killed = []
    with (
        # Who still talks to the killed one waits for no answer.
        dask.config.set({"distributed.comm.timeouts.connect": "5s"}),
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as local,
        Client(local) as client,
        cluster(local.scheduler_address) as (pool, threads),
    ):
        workers = client.run(os.getpid)
        assert threads == len(set(workers.values())) == 2

        def kill_one(what):
            if not killed:
                killed.append(next(iter(workers.values())))
                os.kill(killed[0], signal.SIGKILL)

        found = run_campaign(campaign, tmp_path, threads, kill_one, pool)
        options = ["--cluster", local.scheduler_address, "--trials", "2", "--json"]
        done = CliRunner().invoke(main, ["campaign", *arguments, *options])
    assert killed
    assert json.loads(done.stdout)["samples"] == 4
    assert found.samples == outcome.samples
    lines = [json.loads(line) for line in (tmp_path / SAMPLES).read_text().splitlines()[1:]]
    assert sorted(line["trial"] for line in lines) == list(range(len(campaign)))
