"""The real robots of a run: what their bodies' processes say, who of them is lost, what they are to do.

A robot that is lost has no agent until it is back: its neighbours go on as without that agent, and the new one begins
without memory, for the robot may be somewhere else.
"""

from collections.abc import Callable, Iterable

from formation.disturbances import Disturbance
from formation.errors import ScenarioError, WireError
from formation.scenario.scenario import Scenario
from network import topics
from network.bodies import BodyInput, BodyPose
from network.bus import Action, Incoming, Publish, Query, Reject, Sample
from network.codec import decode, encode
from network.control import Kill, Restart, request
from network.messages import WORLD
from world.bodies.interface import Bodies
from world.bodies.mixed import MixedBodies, RealPose
from world.bodies.registry import bodies_for
from world.bodies.wheeled import WheeledBodies
from world.world import World

LOST_SECONDS = 0.5
"""A robot whose newest pose is older is lost [s of wall clock]."""
FIRST_SECONDS = 3.0
"""The first pose of a robot is waited for so long [s]: its body's process starts with the world."""
AGAIN_SECONDS = 1.0
"""Between two attempts to end the agent of a lost robot, or to start that of one that is back [s]."""


class RealRobots:
    """Those of a run, by number."""

    def __init__(self, run: str, robots: Iterable[int]) -> None:
        """Without a pose yet.

        Args:
            run: its name.
            robots: their numbers.
        """
        self._run, self._robots = run, sorted(robots)
        self._poses: dict[int, RealPose] = {}
        self._seen_at: dict[int, float] = {}
        self._began: float | None = None
        self._lost: dict[int, bool] = {}
        self._asked: dict[int, float] = {}
        self._ended: set[int] = set()
        """Whose agent this one has had ended."""
        self._sent = -1, -1
        """Episode and tick of the newest inputs."""

    def bodies(self, scenario: Scenario) -> Bodies:
        """The bodies of an episode. Raises ScenarioError: real robots cannot stand beside such simulated ones."""
        found = bodies_for(scenario)
        real = [robot for robot in self._robots if robot <= scenario.size]
        if not real:
            return found
        if not isinstance(found, WheeledBodies) or scenario.bodies.implementation != "wheeled":
            raise ScenarioError(
                f"bodies.implementation: expected wheeled beside real robots; got {scenario.bodies.implementation}"
            )
        for disturbance in scenario.disturbances:
            self.check_simulated(disturbance)
        return MixedBodies(found, real, self, scenario.nominal.age)

    def check_simulated(self, disturbance: Disturbance) -> None:
        """Refuse to disturb a real robot. Raises ScenarioError."""
        if disturbance.robot in self._robots:
            raise ScenarioError(
                f"expected a simulated robot to be disturbed; robot {disturbance.robot} is a real one: push it by hand"
            )

    def __call__(self, robot: int) -> RealPose | None:
        """The newest that is known of a robot."""
        return self._poses.get(robot)

    def go_on(self) -> None:
        """Another process has heard of them: who is there shows within FIRST_SECONDS."""
        self._seen_at.clear()
        self._asked.clear()
        self._began = None

    @property
    def poses_from(self) -> list[str]:
        """Keys to subscribe to."""
        return [topics.body_pose(self._run, robot) for robot in self._robots]

    @property
    def inputs_to(self) -> list[str]:
        """Keys to announce."""
        return [topics.body_input(self._run, robot) for robot in self._robots]

    def lost(self, robot: int, now: float) -> bool:
        """Whether a robot's newest pose is too old, or it has not come in time."""
        if robot not in self._seen_at:
            return self._began is not None and now - self._began > FIRST_SECONDS
        return now - self._seen_at[robot] > LOST_SECONDS

    def take(self, arrivals: Iterable[Incoming], now: float) -> tuple[list[Incoming], list[Action]]:
        """Keep what bodies say; what else arrived, and what is to be done."""
        rest: list[Incoming] = []
        actions: list[Action] = []
        for item in arrivals:
            if isinstance(item, Sample) and item.key.endswith("/body_pose"):
                try:
                    self._locate(item, now)
                except WireError as error:
                    actions.append(Reject(item.key, str(error)))
            else:
                rest.append(item)
        return rest, actions

    def _locate(self, sample: Sample, now: float) -> None:
        message = decode(BodyPose, sample.payload)
        robot = message.sender
        if robot != topics.robot_of(sample.key) or robot not in self._robots:
            raise WireError(f"expected the body of a real robot, {self._robots}; got {robot}")
        before = self._poses.get(robot)
        self._poses[robot] = RealPose(before.number + 1 if before else 1, message.pose, message.velocity)
        self._seen_at[robot] = now - message.age

    def watch(self, world: World, now: float) -> list[Incoming]:
        """Note who is lost and who is back; what the world is asked to do about their agents."""
        asked: list[Incoming] = []
        self._began = now if self._began is None else self._began
        for robot in self._robots:
            if robot > world.scenario.size:
                continue
            lost = self.lost(robot, now)
            if lost != self._lost.get(robot, False):
                self._lost[robot] = lost
                self._asked.pop(robot, None)
                text = f"robot {robot} is lost: no pose for {LOST_SECONDS:g} s" if lost else f"robot {robot} is back"
                world.event("agent", text, "error" if lost else "info")
            wish: Kill | Restart | None = Kill(robot=robot) if lost and robot in world.live else None
            if not lost and robot in self._ended and robot not in world.live:
                wish = Restart(robot=robot)
            if wish is not None and now - self._asked.get(robot, -AGAIN_SECONDS) >= AGAIN_SECONDS:
                self._asked[robot] = now
                (self._ended.add if lost else self._ended.discard)(robot)
                asked.append(Query(encode(request(wish)), lambda _: None))
        return asked

    def inputs(self, world: World) -> list[Action]:
        """What the robots are to do, after each tick: nothing new while simulated time stands still."""
        now = world.episode, world.k
        if now == self._sent or world.k == 0:
            return []
        self._sent = now
        return [
            Publish(topics.body_input(self._run, robot), self._input(world, robot))
            for robot in self._robots
            if robot <= world.scenario.size
        ]

    @staticmethod
    def _input(world: World, robot: int) -> BodyInput:
        v, omega = world.inputs[robot - 1].tolist()
        return BodyInput(WORLD, world.k - 1, world.now, world.episode, v, omega)


class MixedWorld(World):
    """A world with real robots among its bodies."""

    def __init__(self, scenario: Scenario, robots: RealRobots, *, episode: int, endless: bool) -> None:
        """At the start of an episode, in real time. Raises ScenarioError as `RealRobots.bodies`."""
        self.real = robots
        super().__init__(scenario, episode=episode, endless=endless, mode="realtime")

    def bodies_for(self, scenario: Scenario) -> Bodies:
        """Simulated and real ones."""
        return self.real.bodies(scenario)

    def push(self, disturbance: Disturbance) -> None:
        """As before, of a simulated robot. Raises EchelonError."""
        self.real.check_simulated(disturbance)
        super().push(disturbance)

    def go_on(self) -> None:
        """A segment, in which the real robots are where they are now."""
        super().go_on()
        self.real.go_on()


Feed = Callable[[Iterable[Incoming], float], list[Action]]


def between(robots: RealRobots, world: World, feed: Feed) -> Feed:
    """The world's node with its real robots: feed this one instead of the node's own."""

    def both(arrivals: Iterable[Incoming], now: float) -> list[Action]:
        rest, actions = robots.take(arrivals, now)
        actions += feed([*rest, *robots.watch(world, now)], now)
        return [*robots.inputs(world), *actions]

    return both
