"""Laws of records: ordinary readers read them, and every message says what was so in the run."""

import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from formation.faults import PERFECT
from formation.link_ids import LinkId
from formation.metrics import pattern_errors
from formation.scenario.scenario import Scenario
from network.codec import decode as decoded
from network.messages import Command, Plan, Tick
from network.stretch import Stretch
from records.file import RecordFile
from records.record import Record, load
from records.recorder import FAULT_KEYS, Recorder
from runtime.inprocess import Simulation
from tests.exceptions import needs
from tests.records.recorded import STARTED, record, scenario
from tests.records.reflection import decode
from world.journal import Journal
from world.world import World


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Simulation, Record]:
    """A record of full detail of what says that it ran in real time, the simulation that it is of, and what we read."""
    path = tmp_path_factory.mktemp("records") / "full.mcap"
    simulation = record(path, scenario(), "full", mode="realtime")
    return path, simulation, load(path)


def messages(path: Path) -> list[tuple[str, int, dict[str, Any]]]:
    """Every message as an ordinary reader has it, decoded by the file's own schema: topic, tick, fields."""
    found = []
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            assert schema is not None
            fields = decode(schema.data.decode(), schema.name, message.data)
            found.append((channel.topic, round((message.log_time - STARTED) / 1e7), fields))
    return found


def pose_of(fields: dict[str, Any]) -> list[float]:
    place, turn = fields["position"], fields["orientation"]
    return [place["x"], place["y"], 2.0 * float(np.arctan2(turn["z"], turn["w"]))]


def test_every_message_of_a_record_says_what_was_so(run: Any) -> None:
    path, simulation, _ = run
    trace, scenario = simulation.trace, simulation.world.scenario
    slots = scenario.reference().positions(trace.times)
    seen: set[str] = set()
    for topic, tick, fields in messages(path):
        seen.add(topic)
        pose: Any = trace.poses[min(tick, len(trace.poses) - 1)]
        got: Any
        match topic.split("/")[1:]:
            case ["ticks"]:
                first, n = fields["first"], fields["robots"]
                got = np.array(fields["poses"]).reshape(-1, n, 3)
                assert got.tobytes() == trace.poses[first : first + len(got)].tobytes()
            case ["checks"]:
                rows = trace.poses[fields["first"] :].reshape(-1, 3)[: len(fields["sums"])]
                assert fields["sums"] == [zlib.crc32(row.astype("<f8").tobytes()) for row in rows]
            case [robot, "odom"]:
                i = int(robot[5:]) - 1
                assert (fields["header"]["frame_id"], fields["child_frame_id"]) == ("map", robot)
                got = np.array(pose_of(fields["pose"]["pose"]))
                assert got[:2].tobytes() == pose[i, :2].tobytes()
                assert abs(np.angle(np.exp(1j * (got[2] - pose[i, 2])))) < 1e-12
                moved = [fields["twist"]["twist"]["linear"]["x"], fields["twist"]["twist"]["angular"]["z"]]
                assert moved == (trace.inputs[tick - 1, i].tolist() if tick else [0.0, 0.0])
            case [robot, "cmd_vel"] if tick:
                i = int(robot[5:]) - 1
                got = [fields["twist"]["linear"]["x"], fields["twist"]["angular"]["z"]]
                assert got == trace.inputs[tick - 1, i].tolist()
            case ["metrics"]:
                distance, angle = pattern_errors(pose, slots[tick])
                np.testing.assert_allclose(fields["distance_error"], distance, atol=1e-12)
                np.testing.assert_allclose(fields["angle_error"], angle, atol=1e-12)
            case ["contacts"]:
                apart = np.linalg.norm(pose[[0, 0, 1], :2] - pose[[1, 2, 2], :2], axis=1)
                np.testing.assert_allclose(fields["clearance"], apart.min(), atol=1e-12)
                np.testing.assert_allclose(fields["gap"], apart.min() - 2.0 * scenario.bodies.radius, atol=1e-12)
            case ["faults"]:
                table = next(f for at, f in reversed(simulation.world.faults.since(0)) if round(at / 0.01) <= tick)
                known = table.get(LinkId.parse(fields["link"]), PERFECT)
                assert all(fields[key] == float(getattr(known, key)) for key in FAULT_KEYS)
            case ["tf"]:
                placed = {one["child_frame_id"]: one["transform"]["translation"] for one in fields["transforms"]}
                for i in range(scenario.size):
                    for frame, where in ((f"robot{i + 1}", pose[i]), (f"slot{i + 1}", slots[tick, i])):
                        got = [placed[frame]["x"], placed[frame]["y"]]
                        np.testing.assert_allclose(got, where[:2], atol=2.0**-17 + 1e-12)
            case ["markers"]:
                assert [marker["ns"] for marker in fields["markers"]] == ["edges", "slots", "links"]
                for marker in fields["markers"][:2]:
                    starts = [[point["x"], point["y"]] for point in marker["points"][::2]]
                    np.testing.assert_allclose(starts, pose[:, :2], atol=2.0**-17)
    assert {f"/robot{i}/{what}" for i in (1, 2, 3) for what in ("odom", "cmd_vel", "plan", "belief", "link")} <= seen
    assert {
        "/faults",
        "/contacts",
        "/tf",
        "/markers",
        "/metrics",
        "/log",
        "/orders",
        "/ticks",
        "/checks",
        "/wire/tick",
    } <= seen


def test_an_independent_implementation_reads_the_same(run: Any) -> None:
    needs("rosbags")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    path, _, _ = run
    store = get_typestore(Stores.ROS2_JAZZY)
    ours, count = messages(path), 0
    with path.open("rb") as stream:
        for schema, _, message in make_reader(stream).iter_messages():
            assert schema is not None
            if schema.name.startswith("echelon_msgs") and schema.name not in store.types:
                own = schema.data.decode().split("=" * 80)[0]
                store.register(get_types_from_msg(own, schema.name))
            assert plain(store.deserialize_cdr(message.data, schema.name)) == ours[count][2]
            count += 1
    assert count == len(ours)


def plain(value: Any) -> Any:
    """A message of rosbags as nested data."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [plain(entry) for entry in value]
    if hasattr(value, "__dataclass_fields__"):
        return {
            key: plain(getattr(value, key))
            for key in value.__dataclass_fields__
            if not (key.startswith("_") or key.isupper())
        }
    return value


def test_a_plan_is_a_path_from_where_its_sender_is(run: Any) -> None:
    path, _, _ = run
    plans = {}
    for topic, _, fields in messages(path):
        if topic.startswith("/wire") and topic.endswith("plan"):
            plan = decoded(Plan, bytes(fields["payload"]))
            plans[topic.split("/")[3], plan.seq] = plan
    drawn = [
        (topic, tick, fields)
        for topic, tick, fields in messages(path)
        if topic.endswith("/plan") and "wire" not in topic
    ]
    assert len(drawn) >= 3 * 4
    for topic, tick, fields in drawn:
        plan = plans[topic[6:-5], tick]
        assert len(fields["poses"]) == len(plan.inputs) + 1
        np.testing.assert_allclose(pose_of(fields["poses"][0]["pose"])[:2], plan.pose[:2], atol=2.0**-17)


def test_a_record_of_everything_holds_every_message_of_the_wire(run: Any) -> None:
    path, simulation, _ = run
    ticks = simulation.world.k
    kinds = {"tick": Tick, "plan": Plan, "command": Command}
    seqs: dict[str, list[int]] = {}
    for topic, _, fields in messages(path):
        if topic.startswith("/wire"):
            seqs.setdefault(topic, []).append(decoded(kinds[topic.rsplit("/", 1)[-1]], bytes(fields["payload"])).seq)
    assert len(seqs) == 1 + 2 * 3
    assert all(found == list(range(ticks)) for topic, found in seqs.items() if not topic.endswith("plan"))


def test_what_can_be_simulated_again_is_not_recorded_and_the_rest_is(tmp_path: Path) -> None:
    world = World(scenario())
    journal = Journal(world, wanted=True)
    first, second = stretches(world, journal, 100), stretches(world, journal, 20, answering=(1, 3))
    with RecordFile(tmp_path / "lost.mcap") as file:
        recorder = Recorder(file, "run", STARTED, detail="full")
        for stretch in first:
            recorder.take(stretch)
            recorder.take_wire("tick", b"again")
        for stretch in second:
            recorder.take(stretch)
            recorder.take_wire("tick", b"never again")
    found = [bytes(fields["payload"]) for topic, _, fields in messages(tmp_path / "lost.mcap") if topic == "/wire/tick"]
    assert found == [b"never again"] * len(second)


def test_what_we_read_is_what_was_simulated(run: Any) -> None:
    _, simulation, read = run
    (episode,) = read.episodes
    assert read.sound
    assert episode.ticks == list(range(simulation.world.k + 1))
    assert Scenario.model_validate_json(episode.scenario) == simulation.world.scenario
    assert [order.tick for order in episode.orders if order.kind == "faults"] == [0, 100, 200]
    assert np.array([episode.poses[k] for k in episode.ticks]).tobytes() == simulation.trace.poses.tobytes()


def test_a_record_does_not_change_the_run(run: Any) -> None:
    _, simulation, _ = run
    alone = Simulation(scenario())
    assert alone.simulate().poses.tobytes() == simulation.trace.poses.tobytes()


def test_exact_poses_are_in_every_record_once_a_second(tmp_path: Path) -> None:
    simulation = record(tmp_path / "default.mcap", scenario())
    (episode,) = load(tmp_path / "default.mcap").episodes
    assert sorted(episode.poses) == [0, 100, 200]
    assert episode.ticks == list(range(simulation.world.k + 1))
    for tick, poses in episode.poses.items():
        assert poses.tobytes() == simulation.trace.poses[tick].tobytes()


# ---------------------------------------------------------------------- what the world hands over


def stretches(world: World, journal: Journal, ticks: int, answering: Iterable[int] = ()) -> list[Stretch]:
    found = []
    for _ in range(ticks):
        world.advance({})
        journal.note(answering or world.robots)
        found.append(journal.take())
    return [stretch for stretch in found if stretch is not None]


def test_stretches_follow_without_gaps_and_the_first_has_the_scenario() -> None:
    world = World(scenario())
    found = stretches(world, Journal(world, wanted=True), 37)
    n, at = world.scenario.size, 0
    for number, stretch in enumerate(found):
        assert (stretch.seq, stretch.first) == (number, at)
        assert bool(stretch.scenario) == (number == 0)
        at += len(stretch.poses) // n
    assert [order.number for stretch in found for order in stretch.orders] == [0]


def test_a_recorder_that_comes_later_gets_every_order_and_no_earlier_tick() -> None:
    world = World(scenario())
    journal = Journal(world)
    assert stretches(world, journal, 150) == []
    journal.wanted = True
    first = stretches(world, journal, 60)[0]
    assert first.first == 150
    assert first.scenario
    assert [order.tick for order in first.orders] == [0, 100]
    journal.wanted = False
    assert stretches(world, journal, 20) == []


def test_a_new_episode_begins_with_its_scenario_again() -> None:
    world = World(scenario())
    journal = Journal(world, wanted=True)
    stretches(world, journal, 30)
    world.reset()
    again = journal.take()  # as the world's node does after every operation
    assert again is not None
    assert (again.episode, again.first) == (world.episode, 0)
    assert again.scenario
    assert [order.number for stretch in stretches(world, journal, 10) for order in stretch.orders] == [0]


def test_each_episode_of_a_record_has_its_own_ticks(tmp_path: Path) -> None:
    world = World(scenario())
    journal = Journal(world, wanted=True)
    with RecordFile(tmp_path / "two.mcap") as file:
        recorder = Recorder(file, "run", STARTED)
        for ticks in (73, 40):
            for stretch in [journal.take(), *stretches(world, journal, ticks), journal.take(all_of_it=True)]:
                if stretch is not None:
                    recorder.take(stretch)
            world.reset()
    first, second = load(tmp_path / "two.mcap").episodes
    assert (first.ticks, second.ticks) == (list(range(74)), list(range(41)))
    assert first.ends < second.begins
