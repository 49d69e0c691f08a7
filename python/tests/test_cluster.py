"""Many matches on many machines, where Ray is installed."""

import importlib.util
import json
import os
import threading
import time
from pathlib import Path

import pytest

import naoisis

ray = pytest.importorskip("ray")
from naoisis import cluster

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
    assert [place for place, _ in found] == [
        ball(name, seed)[0] for name in ("kick_right_straight", "match3v3") for seed in (1, 2)
    ]
    assert os.getpid() not in {process for _, process in found}

    def fails(scenario, seed):
        raise ValueError(f"no {scenario} {seed}")

    with pytest.raises(ValueError, match="no match3v3 3"):
        cluster.map(fails, ["match3v3"], [3], progress=False)
    with pytest.raises(TypeError, match="function"):
        cluster.map("match3v3", [], [])
    with pytest.raises(naoisis.ScenarioError, match="scenario"):
        cluster.batch("match9v9", 3)


def test_a_scenarios_files_are_found_from_where_others_work(nodes, tmp_path, monkeypatch):
    """The processes that play work in other folders than this one."""
    match = naoisis.Match("match3v3", seed=3)
    match.run(2)
    (tmp_path / "moment.naoisis").write_bytes(match.snapshot())
    (tmp_path / "on.json").write_text(json.dumps({"from": "moment.naoisis"}))
    monkeypatch.chdir(tmp_path)
    for scenario in ("on.json", {"from": "moment.naoisis"}):
        table = cluster.batch(scenario, 3, seed=1, duration_s=1.0, progress=False)
        assert table.to_csv() == naoisis.batch(scenario, 3, seed=1, duration_s=1.0, threads=1).to_csv()


def _example(name):
    path = Path(__file__).parent.parent / "examples" / "ray" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_sweep_of_the_examples_is_that_of_one_machine(nodes):
    found = _example("sweep").main(2, duration_s=5.0)
    assert [row["settings"]["messages.loss"] for row in found] == ["0.0", "0.5", "1.0"]
    assert all(row["matches"] == 2 and row["failed"] == 0 for row in found)


def test_ray_tune_finds_parameters_that_score(tmp_path):
    pytest.importorskip("ray.tune")
    try:
        parameters, others = _example("tune").main(2, episodes=8, out=str(tmp_path))
    finally:
        ray.shutdown()
    # The second of the two scores in four of ten episodes, the first in hardly any.
    assert others > 0.1 and parameters["goal_m"] == pytest.approx(0.3455, abs=1e-3)


def test_a_record_may_have_several_lines():
    assert cluster.records('a,b\r\n1,"x\r\ny"\r\n2,z\r\n') == ["a,b\r\n", '1,"x\r\ny"\r\n', "2,z\r\n"]
