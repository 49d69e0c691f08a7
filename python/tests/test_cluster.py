"""Many matches on many machines, where Ray is installed."""

import os
import threading
import time

import pytest

import naoisis

ray = pytest.importorskip("ray")
from naoisis import cluster  # noqa: E402

OPTIONS = {"seed": 7, "duration_s": 30.0, "sweep": {"messages.loss": [0, 0.5]}}


@pytest.fixture()
def nodes():
    """A cluster of this machine: two nodes of a core each, and one of none that directs them."""
    from ray.cluster_utils import Cluster

    local = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    nodes = [local.add_node(num_cpus=1) for _ in range(2)]
    ray.init(address=local.address, log_to_driver=False)
    yield local, nodes
    ray.shutdown()
    local.shutdown()


def test_a_node_that_is_lost_costs_nothing_but_time(nodes, tmp_path):
    local, (_, second) = nodes
    expected = naoisis.batch("match3v3", 24, threads=1, **OPTIONS)
    file = tmp_path / "table.csv"

    def lose_it():
        # In the middle: some rows are there, others are not.
        while not file.exists() or len(file.read_text().splitlines()) < 6:
            time.sleep(0.05)
        local.remove_node(second, allow_graceful=False)

    loss = threading.Thread(target=lose_it)
    loss.start()
    table = cluster.batch("match3v3", 24, csv=file, in_flight=4, progress=False, **OPTIONS)
    loss.join()
    assert sum(node["Alive"] for node in ray.nodes()) == 2
    assert table.to_csv() == expected.to_csv() == file.read_text()
    assert table.summary() == expected.summary()
    # What is there already is gone on with.
    more = cluster.batch("match3v3", 26, csv=file, progress=False, **OPTIONS)
    assert more.to_csv().startswith(expected.to_csv()) and more.matches == 52


def test_a_function_is_called_for_each_scenario_and_seed(nodes):
    def ball(scenario, seed):
        match = naoisis.Match(scenario, seed=seed)
        match.run(1)
        return match.truth()["ball"]["position_m"], os.getpid()

    found = cluster.map(ball, ["kick_right_straight", "match3v3"], [1, 2], progress=False)
    assert [place for place, _ in found] == [ball(name, seed)[0] for name in ("kick_right_straight", "match3v3") for seed in (1, 2)]
    assert os.getpid() not in {process for _, process in found}

    def fails(scenario, seed):
        raise ValueError(f"no {scenario} {seed}")

    with pytest.raises(ValueError, match="no match3v3 3"):
        cluster.map(fails, ["match3v3"], [3], progress=False)
    with pytest.raises(TypeError, match="function"):
        cluster.map("match3v3", [], [])
    with pytest.raises(naoisis.ScenarioError, match="scenario"):
        cluster.batch("match9v9", 3)


def test_a_record_may_have_several_lines():
    assert cluster.records('a,b\r\n1,"x\r\ny"\r\n2,z\r\n') == ["a,b\r\n", '1,"x\r\ny"\r\n', "2,z\r\n"]
