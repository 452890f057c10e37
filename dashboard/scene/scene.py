"""The scene in the middle of the page: robots, trails, plans, links, ghost."""

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from dashboard.scene import geometry, layers, nodes
from dashboard.scene.ghost_layer import GhostLayer
from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.feed import View
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme import colours
from dashboard.theme.palette import DARK, Palette
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.messages import State
from network.values import NO_WAY

SLOW = 3
"""Trails, which are the most bytes, plans, which come ten times a second, and colours: in every third frame."""
MANY = 8
"""With more robots, links and edges are drawn in every other frame."""
GHOST = "Ghost"
LAYERS = {
    "Trails": ("/trails",),
    "Horizons": ("/horizons",),
    "Beliefs": ("/beliefs", "/believed", "/off"),
    "Slots": ("/slots", "/desired"),
    "Links": ("/links", "/heads"),
    GHOST: (),
}
"""The layers that can be hidden, and their nodes; the ghost hides its own."""


class Scene:
    """Draws a snapshot."""

    def __init__(
        self,
        server: viser.ViserServer,
        on_robot: Callable[[viser.ClientHandle, int], None],
        on_link: Callable[[int], None],
        on_drag: Callable[[int, viser.SceneNodeDragEvent[Any]], None],
    ) -> None:
        """An empty scene.

        Args:
            server: whose scene is used.
            on_robot: a user clicked this robot.
            on_link: a user clicked the link with this sender.
            on_drag: a user drags this robot.
        """
        self._server, self._on_robot, self._on_link, self._on_drag = server, on_robot, on_link, on_drag
        self._nodes: dict[str, Any] = {}
        self._hidden: set[str] = set()
        self._scenario: Scenario | None = None
        self._frame = 0
        self.focus: int | None = None
        """The robot with a bright outline."""
        self._focus_drawn: int | None = None
        self._state: State | None = None
        self._robots_key: object = None
        self._ghost: GhostLayer | None = None
        self._ghost_shown = True
        self._palette = DARK
        self._sizes = layers.Sizes(1.0)
        scene = server.scene
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False)
        scene.add_light_ambient("/light", intensity=np.pi)
        self._lay_grid()

    def _lay_grid(self) -> None:
        self._server.scene.add_grid(
            "/grid",
            cell_size=0.1,
            section_size=0.5,
            cell_color=_bytes(self._palette.cell),
            section_color=_bytes(self._palette.section),
            infinite_grid=True,
            fade_distance=400.0,
            fade_strength=0.5,
            shadow_opacity=0.0,
            position=(0.0, 0.0, -0.001),
        )

    def set_palette(self, palette: Palette) -> None:
        """Draw in another theme from now on; call within server.atomic()."""
        if palette != self._palette:
            self._palette = palette
            self._lay_grid()
            if self._scenario is not None:
                self._build(self._scenario)

    def show_layer(self, name: str, shown: bool) -> None:
        """Show or hide one of LAYERS."""
        if name == GHOST:
            self._ghost_shown = shown
        for node in LAYERS[name]:
            self._hidden.discard(node) if shown else self._hidden.add(node)
            if node in self._nodes:
                self._nodes[node].visible = shown

    @property
    def sizes(self) -> layers.Sizes:
        """Of what is drawn."""
        return self._sizes

    def draw(self, view: View, *, whole: bool) -> None:
        """Bring the scene up to date; call within server.atomic().

        Args:
            view: the moment that is shown.
            whole: also the layers that otherwise take turns from frame to frame.
        """
        snapshot, links = view.snapshot, view.links
        state, scenario = snapshot.state, snapshot.scenario
        if state is None or scenario is None or scenario.size != len(state.poses):
            return
        if scenario is not self._scenario:
            if self._scenario is None or scenario.model_dump() != self._scenario.model_dump():
                self._build(scenario)
            self._scenario = scenario
        self._frame += 1
        whole |= self._frame == 1
        self._move(snapshot.poses)
        if whole or scenario.size <= MANY or self._frame % 2:
            self._connect(snapshot.poses, links, state.away)
        trails = whole or self._frame % SLOW == 1
        if trails:
            drawn = self._sizes.detail.thinned(view.trails(snapshot.poses))
            self._nodes["/trails"].points = geometry.segments(drawn, self._sizes.z(2))
        if self._ghost is not None:
            self._ghost.allow(self._ghost_shown)
            self._ghost.draw(view.ghosts, snapshot.stamp, trails=trails)
        if state is not self._state:
            self._state = state
            slots = state.slots[:, :2].copy()
            slots[[robot - 1 for robot in state.away]] = layers.AWAY  # nobody's
            self._nodes["/slots"].batched_positions = geometry.lifted(slots, self._sizes.z(3))
            self._nodes["/desired"].points = layers.desired(
                state.slots, self._sizes.detail.pattern_dashes, self._sizes.z(3), state.away
            )
        if whole or self._frame % SLOW == 2:
            self._plan(snapshot, state, scenario.controller.horizon)
            self._believe(snapshot, view.beliefs, scenario.controller.horizon)
        if whole or self._frame % SLOW == 0 or self._focus_drawn != self.focus:
            self._focus_drawn = self.focus
            self._recolour(state, links)

    def _move(self, poses: FloatArray) -> None:
        """Move the robots."""
        drawn, sizes = self._nodes, self._sizes
        turned = geometry.turns(poses[:, 2])
        for name, layer in (("/outlines", 9), ("/bodies", 10)):
            drawn[name].batched_positions = geometry.lifted(poses[:, :2], sizes.z(layer))
            drawn[name].batched_wxyzs = turned

    def _connect(self, poses: FloatArray, links: list[LinkView], away: list[int]) -> None:
        """Move edges and links."""
        drawn, sizes = self._nodes, self._sizes
        drawn["/edges"].points = layers.edges(poses, sizes.z(6), away)
        arrows = layers.arrows(poses, links, sizes, 7)
        drawn["/links"].points = arrows.shafts
        drawn["/heads"].batched_positions = arrows.tips
        drawn["/heads"].batched_wxyzs = geometry.turns(arrows.directions)

    def _recolour(self, state: State, links: list[LinkView]) -> None:
        """Set the colours of health."""
        drawn, n = self._nodes, len(state.poses)
        drawn["/edges"].colors = layers.edge_colours(state.distance_errors, self._palette)
        drawn["/links"].colors, drawn["/heads"].batched_colors = layers.arrow_colours(
            links, n, self._sizes.detail.dashes, self._palette
        )
        lost, stopped = set(range(1, n + 1)) - set(state.live), set(state.stopped)
        key = (n, lost, stopped, self.focus)
        if key != self._robots_key:
            self._robots_key = key
            drawn["/bodies"].batched_colors = colours.encode(layers.body_colours(n, lost, self._palette))
            outlines = layers.outline_colours(n, lost, stopped, self.focus, self._palette)
            drawn["/outlines"].batched_colors = colours.encode(outlines)

    def _plan(self, snapshot: Snapshot, state: State, steps: int) -> None:
        """Draw the robots' plans, and those that their neighbours hold."""
        n, z = len(state.poses), self._sizes.z
        own = layers.horizons(
            layers.own_plans(snapshot.statuses, n, state.episode), snapshot.poses, steps, snapshot.stamp
        )
        self._nodes["/horizons"].points = geometry.segments(self._sizes.detail.thinned(own), z(5))
        if "/preview" in self._nodes:
            said = snapshot.statuses.get(snapshot.leader)
            way = said.way if said is not None and said.episode == state.episode else NO_WAY
            line = self._nodes["/preview"].points = layers.preview(way, steps, z(1))
            if "/ribbon" in self._nodes:
                self._nodes["/ribbon"].points = layers.ribbon(line, self._sizes.ribbon, z(2))
            self._nodes["/goal"].points = layers.goal(state.driving.goal, 0.03 * self._sizes.unit, z(8))

    def _believe(self, snapshot: Snapshot, beliefs: list[BeliefView], steps: int) -> None:
        """Draw where each robot believes its upstream neighbour to be, and to drive."""
        drawn, z, detail, n = self._nodes, self._sizes.z, self._sizes.detail, len(snapshot.poses)
        places, lines = layers.believed(beliefs, snapshot.poses, steps)
        dashes = geometry.segments(detail.thinned(lines), z(4)).reshape(n, -1, 2, 3)[:, ::2]
        drawn["/beliefs"].points = dashes.reshape(-1, 2, 3)
        drawn["/believed"].batched_positions = geometry.lifted(places[:, :2], z(8))
        drawn["/believed"].batched_wxyzs = geometry.turns(places[:, 2])
        drawn["/off"].points = geometry.lifted(layers.off(beliefs, snapshot.poses, detail.dashes), z(7))
        if "/told" in drawn:
            drawn["/told"].batched_positions = geometry.lifted(layers.told_ends(snapshot, n), z(5))

    # ------------------------------------------------------------------ nodes

    def _build(self, scenario: Scenario) -> None:
        """Make the nodes of another scenario."""
        self._scenario = None  # until all nodes exist: else an error in between would leave half a scene for good
        while self._nodes:
            self._nodes.popitem()[1].remove()
        self._frame, self._state, self._robots_key = 0, None, None
        n = scenario.size
        self._sizes = sizes = layers.Sizes.of(scenario)
        scene = self._server.scene
        self._nodes = nodes.scenario_nodes(scene, scenario, sizes, self._palette)
        self._ghost = GhostLayer(scene, n, sizes, self._palette)
        self._nodes.update(self._ghost.nodes)
        for name in self._hidden:
            self._nodes[name].visible = False
        self._nodes["/bodies"].on_click(self._clicked_robot)
        self._nodes["/bodies"].on_drag(self._dragged_robot)
        self._nodes["/heads"].on_click(self._clicked_link)

    def _clicked_robot(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        if event.instance_index is not None:
            self._on_robot(event.client, event.instance_index + 1)

    async def _dragged_robot(self, event: viser.SceneNodeDragEvent[Any]) -> None:
        """Asynchronous, because viser then keeps the order of a drag's events."""
        if event.instance_index is not None:
            self._on_drag(event.instance_index + 1, event)

    def _clicked_link(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        if event.instance_index is not None:
            self._on_link(event.instance_index + 1)


def _bytes(text: str) -> tuple[int, int, int]:
    red, green, blue = (int(text[i : i + 2], 16) for i in (0, 2, 4))
    return red, green, blue
