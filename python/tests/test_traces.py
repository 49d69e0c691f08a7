"""Traces as columns."""

import subprocess

import numpy as np
import pytest

import naoisis


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A recorded match: its trace, the table of its beliefs, and its truth cycle by cycle."""
    folder = tmp_path_factory.mktemp("recorded")
    trace, beliefs = folder / "match.jsonl.zst", folder / "beliefs.csv"
    match = naoisis.Match("match3v3", seed=2, set={"duration_s": 3})
    match.record(trace=trace, beliefs=beliefs)
    truth = [match.truth()]
    while not match.finished:
        match.step()
        truth.append(match.truth())
    said = match.close()
    assert any("blue1" in words for words in said)
    return trace, beliefs, truth


def test_a_trace_is_columns(recorded):
    path, _, truth = recorded
    trace = naoisis.read_trace(path)
    assert trace.ending == "duration" and trace.robots == [robot["id"] for robot in truth[0]["robots"]]
    assert list(trace["cycle"]) == [line["cycle"] for line in truth]
    assert trace["ball.position_m"] == pytest.approx(np.array([line["ball"]["position_m"] for line in truth]))
    for index, robot in enumerate(trace.robots):
        for name in ("pose", "velocity", "head_deg", "odometry"):
            expected = np.array([line["robots"][index][name] for line in truth])
            assert trace[f"{robot}.{name}"] == pytest.approx(expected, abs=2e-5), name
        seen = [line["robots"][index]["percepts"]["ball"] for line in truth]
        assert list(np.isnan(trace[f"{robot}.seen_ball_m"][:, 0])) == [ball is None for ball in seen]
    assert set(trace["state"]) == {line["game"]["state"] for line in truth}
    assert [event["kind"] for event in trace.events] == [event["kind"] for line in truth for event in line["events"]]
    assert naoisis.Match(trace.scenario).scenario == trace.scenario
    assert list(naoisis.trace_lines(path)) == truth
    pytest.importorskip("pandas")
    assert len(trace.to_pandas()) == len(truth)


def test_beliefs_are_beside_the_truth_in_both_halves(tmp_path):
    path = tmp_path / "match.jsonl.zst"
    match = naoisis.Match("match3v3", seed=3, set={"rules.half_s": 20, "duration_s": 45})
    match.record(trace=path)
    match.run()
    match.close()
    trace = naoisis.read_trace(path)
    for robot in trace.robots:
        off = np.hypot(*(trace[f"{robot}.pitch_belief_pose"] - trace[f"{robot}.pose"])[:, :2].T)
        end = trace[f"{robot}.own_end"]
        assert set(end) == {-1, 1} and end[0] == (-1 if robot.startswith("blue") else 1)
        # The team's frame is turned where its goal is at +x.
        turned = trace[f"{robot}.belief_pose"][:, :2] * -end[:, None]
        assert np.nanmax(np.abs(turned - trace[f"{robot}.pitch_belief_pose"][:, :2])) < 1e-6
        balls = trace[f"{robot}.belief_ball_m"] * -end[:, None]
        assert np.nanmax(np.abs(balls - trace[f"{robot}.pitch_belief_ball_m"])) < 1e-6
        for half in (-1, 1):
            assert np.nanmedian(off[end == half]) < 0.5, (robot, half)


def test_parts_that_a_trace_lacks_have_no_column(tmp_path):
    path = tmp_path / "lean.jsonl"
    command = ["naoisis", "run", "match3v3", "--duration", "1", "--trace", path, "--trace-every", "10", "--quiet"]
    subprocess.run([*command, "--trace-fields", "ball,robots.pose"], check=True)
    trace = naoisis.read_trace(path)
    assert list(trace["cycle"]) == [0, 10, 20, 30]
    assert "blue1.pose" in trace and "ball.velocity_mps" in trace
    assert not {"blue1.odometry", "blue1.belief_pose", "score"} & set(trace)


def test_beliefs_are_columns(recorded):
    beliefs = naoisis.read_beliefs(recorded[1])
    assert set(beliefs["robot"]) == {"blue1", "blue2", "blue3", "pink1", "pink2", "pink3"}
    assert beliefs["position_error_m"].dtype == np.float64 and (beliefs["position_error_m"] < 1).all()


def test_what_is_no_trace_is_refused_with_its_place(tmp_path):
    path = tmp_path / "no.jsonl"
    with pytest.raises(naoisis.TraceError, match="expected a trace"):
        naoisis.read_trace(path)
    path.write_text('{"type":"header"}\n')
    with pytest.raises(naoisis.TraceError, match="missing field") as error:
        naoisis.read_trace(path)
    assert (error.value.file, error.value.line) == (str(path), 1) and error.value.column > 0


def test_a_trace_is_tables_for_pandas_polars_and_duckdb(recorded, tmp_path):
    path, _, truth = recorded
    tables = naoisis.read_tables(path)
    assert list(tables) == ["cycles", "robots", "percepts", "beliefs", "events", "messages"]
    robots = [robot for line in truth for robot in line["robots"]]
    assert list(tables["robots"]["robot"]) == [robot["id"] for robot in robots]
    assert tables["robots"]["x_m"] == pytest.approx(np.array([robot["pose"][0] for robot in robots]), abs=2e-5)
    balls = [robot["percepts"]["ball"] for robot in robots if robot["percepts"]["ball"]]
    seen = tables["percepts"]["kind"] == "ball"
    assert tables["percepts"]["x_m"][seen] == pytest.approx(
        np.array([ball["position_m"][0] for ball in balls]), abs=2e-5
    )
    assert list(tables["events"]["kind"]) == [event["kind"] for line in truth for event in line["events"]]
    subprocess.run(["naoisis", "convert", path, "--parquet", tmp_path / "p", "--csv", tmp_path / "c"], check=True)
    pandas, polars, duckdb = (pytest.importorskip(name) for name in ("pandas", "polars", "duckdb"))
    pytest.importorskip("pyarrow")
    for name, columns in tables.items():
        frame = pandas.read_parquet(tmp_path / "p" / f"{name}.parquet")
        assert list(frame) == list(columns) == list(pandas.read_csv(tmp_path / "c" / f"{name}.csv"))
        assert list(polars.read_parquet(tmp_path / "p" / f"{name}.parquet").columns) == list(columns)
        ((rows,),) = duckdb.sql(f"select count(*) from '{tmp_path}/p/{name}.parquet'").fetchall()
        assert rows == len(frame) == len(columns["cycle"])
        for column, values in columns.items():
            if values.dtype == object:
                assert [None if pandas.isna(cell) else cell for cell in frame[column]] == list(values), column
            else:
                assert frame[column].to_numpy(dtype=np.float64) == pytest.approx(values.astype(np.float64), nan_ok=True)
