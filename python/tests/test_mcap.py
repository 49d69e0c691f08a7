"""MCAP files, read by the packages of MCAP and Protocol Buffers."""

import json
from collections import defaultdict
from math import dist

import pytest

import naoisis

exceptions, readers = pytest.importorskip("mcap.exceptions"), pytest.importorskip("mcap.reader")
DecoderFactory = pytest.importorskip("mcap_protobuf.decoder").DecoderFactory


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A match with images as an MCAP file and as a trace."""
    folder = tmp_path_factory.mktemp("recorded")
    path, trace = folder / "match.mcap", folder / "match.jsonl"
    settings = {"duration_s": 4, "cameras.render": "software", "cameras.width": 32, "cameras.height": 24}
    match = naoisis.Match("match3v3", seed=2, set=settings)
    match.record(mcap=path, trace=trace)
    match.run()
    match.close()
    return path, trace


@pytest.fixture(scope="module")
def channels(recorded):
    """All messages by topic: the time in seconds, and the decoded message."""
    messages = defaultdict(list)
    with open(recorded[0], "rb") as file:
        reader = readers.make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert reader.get_header().library == "naoisis"
        for schema, channel, message in reader.iter_messages():
            if channel.message_encoding == "json":
                assert json.loads(schema.data)["type"] == "object"
                decoded = json.loads(message.data)
            else:
                decoded = DecoderFactory().decoder_for("protobuf", schema)(message.data)
            messages[channel.topic].append((message.log_time / 1e9, decoded))
    return messages


def test_the_trace_is_in_the_file(recorded, channels):
    path, trace = recorded
    lines = trace.read_text().splitlines()
    with open(path, "rb") as file:
        metadata = {entry.name: entry.metadata["line"] for entry in readers.make_reader(file).iter_metadata()}
    assert metadata == {"naoisis-trace": lines[0], "naoisis-trace-end": lines[-1]}
    assert [line for _, line in channels["/trace"]] == [json.loads(line) for line in lines[1:-1]]


def test_python_reads_it_like_a_trace(recorded):
    path, trace = recorded
    one, other = naoisis.read_trace(path), naoisis.read_trace(trace)
    assert one.scenario == other.scenario and one.events == other.events and one.ending == other.ending
    assert set(one) == set(other)
    for name in one:
        assert list(map(str, one[name])) == list(map(str, other[name])), name
    assert list(naoisis.trace_lines(path)) == list(naoisis.trace_lines(trace))
    assert naoisis.show(path).html == naoisis.show(trace).html


def robot(line, name):
    return next(robot for robot in line["robots"] if robot["id"] == name)


def test_channels_say_what_the_trace_says(channels):
    lines = {line["time_s"]: line for _, line in channels["/trace"]}
    cycles = [line for _, line in channels["/trace"]]

    def line_at(time_s):
        return lines[min(lines, key=lambda other: abs(other - time_s))]

    assert len(channels["/tf"]) == len(lines)
    for time_s, message in channels["/tf"]:
        frames = {frame.child_frame_id: frame for frame in message.transforms}
        line = line_at(time_s)
        ball = frames["ball"].translation
        assert (ball.x, ball.y, ball.z) == pytest.approx(line["ball"]["position_m"], abs=2e-4)
        for there in line["robots"]:
            place = frames[there["id"]].translation
            assert (place.x, place.y) == pytest.approx(there["pose"][:2], abs=2e-4)
            turned = frames[there["id"]].rotation
            assert sum(part**2 for part in (turned.x, turned.y, turned.z, turned.w)) == pytest.approx(1, abs=2e-3)
    for time_s, game in channels["/game"]:
        assert game == line_at(time_s)["game"]
    for name in (there["id"] for there in line_at(0)["robots"]):
        for time_s, command in channels[f"/{name}/command"]:
            assert command == robot(line_at(time_s), name)["command"]
        kicks = [line["cycle"] for line in cycles if "kick" in robot(line, name).get("command", {})]
        assert set(kicks) <= {line_at(time_s)["cycle"] for time_s, _ in channels[f"/{name}/command"]}
        assert {message["from"] for _, message in channels[f"/{name}/inbox"]} == {
            message["from"] for line in cycles for message in robot(line, name)["inbox"]
        }
        for time_s, message in channels[f"/{name}/inbox"]:
            assert message in robot(line_at(time_s), name)["inbox"]
        for time_s, scene in channels[f"/{name}/percepts"]:
            percepts = robot(line_at(time_s), name)["percepts"]
            (entity,) = scene.entities
            assert entity.frame_id == name and len(entity.spheres) == (percepts["ball"] is not None)
            assert len(entity.cylinders) == len(percepts["goal_posts"]) + len(percepts["robots"])
        assert len(channels[f"/{name}/body"][0][1].entities) == 2
        calibration = channels[f"/{name}/top/calibration"][0][1]
        assert (calibration.width, calibration.height, len(calibration.K), len(calibration.P)) == (32, 24, 9, 12)
        for _, image in channels[f"/{name}/top/image"]:
            assert image.format == "png" and image.data.startswith(b"\x89PNG")
        assert len(channels[f"/{name}/top/annotations"]) == len(channels[f"/{name}/top/image"]) > 100
        errors = dict(channels[f"/{name}/belief_error"])
        assert len(errors) == len(channels[f"/{name}/belief"]) > 30
        for time_s, belief in channels[f"/{name}/belief"]:
            believed = robot(line_at(time_s), name)["belief"]
            sign = 1 if name.startswith("blue") else -1
            place = belief.entities[0].cylinders[0].pose.position
            assert (sign * place.x, sign * place.y) == pytest.approx(believed["pose"][:2], abs=2e-4)
            # Robots sensed at the end of the cycle before.
            sensed = cycles[max(line_at(time_s)["cycle"] - 1, 0)]
            error_m = dist(robot(sensed, name)["pose"][:2], (place.x, place.y))
            assert errors[time_s]["position_m"] == pytest.approx(error_m, abs=1e-3)
    statics = {frame.child_frame_id: frame for frame in channels["/tf_static"][0][1].transforms}
    # A camera looks along its z axis: ahead, which is the head's x axis.
    turned = statics["blue1/top"].rotation
    assert 2 * (turned.x * turned.z + turned.w * turned.y) == pytest.approx(1, abs=1e-3)
    assert len(channels["/pitch"]) == len(channels["/ball"]) == 1
    assert all(event.message and event.name for _, event in channels["/events"])


def test_what_a_killed_program_leaves_is_read(recorded, tmp_path):
    whole = recorded[0].read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: len(whole) // 2])
    trace = naoisis.read_trace(path)
    assert trace.ending is None and 40 < len(trace["cycle"]) < 80
    count = 0
    with open(path, "rb") as file, pytest.raises(exceptions.EndOfFile):
        for _ in readers.NonSeekingReader(file).iter_messages(topics="/trace", log_time_order=False):
            count += 1
    # Others read whole chunks.
    assert 40 < count <= len(trace["cycle"])
