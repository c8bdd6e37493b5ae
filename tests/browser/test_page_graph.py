"""The page's pure modules of the topological map, run in the browser that will run them."""

from typing import Any

import pytest
from playwright.sync_api import Page

pytestmark = pytest.mark.browser

WORLD = """
  const pose = (x, y, theta = 0) => ({ x, y, theta });
  const node = (id, x, y, more = {}) => {
    return { id, kind: "node", name: `N${id}`, pose: pose(x, y), features: [], ...more };
  };
  const edge = (start, end, cost, points) => {
    const way = points && { shape: [points.length, 2], data: Float32Array.from(points.flat()) };
    return { id: 100 + start, start, end, cost, way };
  };
  const graph = (nodes, edges) => new g.Graph({ map_id: "m", nodes, edges });
  const view = (scale, width = 400, height = 400) => {
    const toScreen = ({ x, y }) => ({ x: width / 2 + x * scale, y: height / 2 - y * scale });
    const toMap = ({ x, y }) => ({ x: (x - width / 2) / scale, y: (height / 2 - y) / scale });
    return { scale, toScreen, toMap, size: { width, height }, screenAngle: (theta) => -theta };
  };
  const stateOf = (messages, ages = {}) => ({
    entry: (topic) => {
      const message = messages[topic];
      return message && { topic, message, stampMs: message.at ?? 0 };
    },
    message: (topic) => messages[topic],
    age: (topic) => (messages[topic] ? (ages[topic] ?? 0) : null),
    isLinked: () => true,
  });
"""
MODULES = {"g": "graph.js", "t": "topology.js", "d": "layers/graph.js", "e": "events.js"}


def run(page: Page, body: str) -> Any:  # noqa: ANN401 - what JavaScript returns
    """Return what `body` returns; g, t, d and e are the modules, WORLD makes small graphs."""
    imports = ", ".join(f"import('/static/{name}')" for name in MODULES.values())
    names = ", ".join(MODULES)
    return page.evaluate(f"Promise.all([{imports}]).then(([{names}]) => {{ {WORLD} {body} }})")


def test_a_way_is_as_drawn_by_its_points_and_straight_without(modules: Page) -> None:
    body = """
      const nodes = [node(1, 0, 0), node(2, 4, 0), node(3, 4, 3)];
      const bent = edge(1, 3, 7, [[0, 0], [4, 0], [4, 3]]);
      return graph(nodes, [bent, edge(1, 2, 4), edge(1, 9, 1)]).edges.map((one) => one.way);
    """
    bent, straight = run(modules, body)
    assert bent == [[0, 0], [4, 0], [4, 3]]
    assert straight == [[0, 0], [4, 0]]


def test_a_way_is_as_long_as_its_pieces(modules: Page) -> None:
    assert run(modules, "return g.lengthOf([[0, 0], [3, 4], [3, 6]])") == 7
    assert run(modules, "return g.lengthOf([])") == 0


def test_a_way_from_afar_keeps_its_corners_and_strays_no_farther_than_told(modules: Page) -> None:
    body = """
      const line = Array.from({ length: 9 }, (_, i) => [i, i === 4 ? 1 : 0.05 * (i % 2)]);
      const two = [[0, 0], [1, 1]];
      return [g.simplified(line, 0.1), g.simplified(two, 0.1), g.simplified(line, 0.01)];
    """
    few, two, all_of_them = run(modules, body)
    assert few[0] == [0, 0]
    assert [4, 1] in few
    assert few[-1] == [8, 0]
    assert len(few) < 8
    assert two == [[0, 0], [1, 1]]
    assert len(all_of_them) == 9


def test_a_door_that_many_places_see_is_one_door(modules: Page) -> None:
    body = """
      const feature = (kind, x, theta, y = 0) => ({ kind, pose: pose(x, y, theta), width: 0.9 });
      const found = g.distinct([
        feature("door", 1, 0), feature("door", 1.1, 0.1), feature("door", 1, Math.PI - 0.05),
        feature("passage", 1, 0), feature("door", 1, 1.5), feature("door", 2, 0),
        feature("corner", 5, 0), feature("corner", 5, Math.PI), feature("corner", 5.05, 0.1),
      ]);
      return found.map(({ kind, pose }) => `${kind} ${pose.x} ${pose.theta.toFixed(1)}`);
    """
    expected = ["door 1 0.0", "passage 1 0.0", "door 1 1.5", "door 2 0.0"]
    assert run(modules, body) == [*expected, "corner 5 0.0", "corner 5 3.1"]


def test_the_nearest_place_is_found_within_reach_only(modules: Page) -> None:
    body = """
      const one = graph([node(1, 0, 0), node(2, 4, 0)], []);
      return [one.nearest({ x: 3, y: 0 }).id, one.nearest({ x: 2, y: 5 }, 1) ?? null];
    """
    assert run(modules, body) == [2, None]


def test_neighbours_come_by_either_end_the_nearest_first(modules: Page) -> None:
    body = """
      const nodes = [node(1, 0, 0), node(2, 4, 0), node(3, 0, 2)];
      const edges = [edge(1, 2, 4), edge(3, 1, 2), edge(2, 1, 9), edge(1, 1, 0)];
      return graph(nodes, edges).neighbours(1).map(({ node, cost }) => [node.id, cost]);
    """
    assert run(modules, body) == [[3, 2], [2, 4]]


def test_kinds_are_counted_in_words(modules: Page) -> None:
    assert run(modules, "return g.countText(['line', 'door', 'line'])") == "2 lines, 1 door"
    assert run(modules, "return g.countText([])") == ""


def test_of_places_that_would_lie_on_each_other_the_opening_is_drawn(modules: Page) -> None:
    body = """
      const opening = node(2, 0.1, 0, { kind: "door" });
      const nodes = [node(1, 0, 0), opening, node(3, 5, 5), node(4, 99, 0)];
      const drawn = (scale) => d.placedOf(nodes, view(scale), ({ x }) => x < 400);
      return [5, 100].map((scale) => drawn(scale).map((place) => place.node.id));
    """
    far, near = run(modules, body)
    assert far == [2, 3]
    assert near == [2, 1]


def test_thousands_of_places_afar_are_as_many_as_have_room(modules: Page) -> None:
    body = """
      const at = (i) => node(i, (i % 100) / 10, Math.floor(i / 100) / 10);
      const nodes = Array.from({ length: 10000 }, (_, i) => at(i));
      return d.placedOf(nodes, view(20), () => true).length;
    """
    assert 100 < run(modules, body) < 350


def test_names_come_from_24_pixels_a_metre_up(modules: Page) -> None:
    body = """
      const layer = new d.GraphLayer();
      layer.take(graph([node(1, 0, 0), node(2, 1, 1)], []));
      return [23.9, 24].map((scale) => {
        layer.placed = d.placedOf(layer.graph.nodes, view(scale), () => true);
        const written = [];
        const labels = { keepFree: () => {}, writePlain: (text) => written.push(text) };
        layer.label(labels, view(scale), { free: "", "text-2": "" }, [2]);
        return written;
      });
    """
    assert run(modules, body) == [[], ["N2", "N1"]]


def test_the_graph_is_drawn_anew_only_when_view_or_colour_change(modules: Page) -> None:
    body = """
      const layer = new d.GraphLayer();
      layer.take(graph([node(1, 0, 0), node(2, 1, 1)], [edge(1, 2, 1.4)]));
      const context = new OffscreenCanvas(400, 400).getContext("2d");
      const shown = { ...view(20), centre: pose(0, 0), focus: pose(200, 200), angle: 0 };
      shown.applyTo = () => {};
      const ink = { graph: "rgb(0, 255, 0)", panel: "rgb(0, 0, 0)", free: "rgb(9, 9, 9)" };
      let times = 0;
      const bake = layer.bake.bind(layer);
      layer.bake = (...values) => { times++; bake(...values); };
      const draw = (colours) => layer.draw(context, shown, 1, colours, {});
      const after = [];
      draw(ink); draw(ink); after.push(times);
      shown.scale = 21; draw(ink); after.push(times);
      draw({ ...ink, graph: "rgb(1, 1, 1)" }); after.push(times);
      layer.take(null); draw(ink); after.push(times);
      return after;
    """
    assert run(modules, body) == [1, 2, 3, 3]


@pytest.mark.parametrize(
    ("pose", "told"),
    [
        ("pose(0.5, 0)", "At N1: 2 of 3 features matched"),
        ("pose(4, 3)", "Last at N1, 5.0\u202fm away"),
    ],
)
def test_the_last_place_is_told_with_its_distance(modules: Page, pose: str, told: str) -> None:
    body = f"""
      const arrival = {{ node: 1, name: "N1", matched: 2, bound: 3, at: 5 }};
      const state = stateOf({{ node_arrival: arrival, pose: {{ pose: {pose} }} }});
      return t.placeText(state, graph([node(1, 0, 0)], []));
    """
    assert run(modules, body) == told


def test_a_number_that_was_given_to_another_place_says_nothing(modules: Page) -> None:
    body = """
      const state = stateOf({ node_arrival: { node: 1, name: "Kitchen", matched: 2, bound: 3 } });
      return t.lastPlace(state, graph([node(1, 0, 0)], []));
    """
    assert run(modules, body) is None


@pytest.mark.parametrize(
    ("cause", "told"),
    [
        ("corrected", "Pose corrected at N1"),
        ("recovered", "Found again at N1"),
        ("chain", "Found by a chain of places, at N1"),
    ],
)
def test_how_the_pose_was_found_is_told(modules: Page, cause: str, told: str) -> None:
    body = f"""
      const found = {{ node: 1, matched: 4, cause: "{cause}", at: 9 }};
      const before = {{ node: 1, name: "N1", matched: 2, bound: 3, at: 5 }};
      const away = {{ pose: pose(9, 9) }};
      const state = stateOf({{ node_arrival: before, relocalization: found, pose: away }});
      return t.placeText(state, graph([node(1, 0, 0)], []));
    """
    assert run(modules, body) == f"{told}: 4 features matched"


def test_pairs_are_counted_while_they_are_fresh(modules: Page) -> None:
    body = """
      const lines = { kinds: ["line", "line"] };
      const state = (age) => stateOf({ matched_lines: lines }, { matched_lines: age });
      return [0.5, 2, 5].map((age) => [t.matchCount(state(age)), t.matchText(state(age))]);
    """
    assert run(modules, body) == [[2, "2 lines"], [None, "2 lines"], [None, None]]


def test_the_pairs_of_the_node_count_where_the_localizer_tells_none(modules: Page) -> None:
    body = """
      const features = { kinds: ["door"] };
      const both = { matched_lines: { kinds: ["line", "line"] }, matched_features: features };
      return [t.matchCount(stateOf({ matched_features: features })), t.matchCount(stateOf(both)),
        t.matchCount(stateOf(both, { matched_lines: 9 }))];
    """
    assert run(modules, body) == [1, 2, 1]


def test_what_lies_far_from_any_place_has_coordinates(modules: Page) -> None:
    body = """
      const one = graph([node(1, 0, 0, { name: "Room B" })], []);
      const points = [{ x: 1, y: 1 }, { x: 9, y: 0 }];
      return [...points.map((point) => t.pointText(point, one)), t.pointText(points[0], null)];
    """
    near, far, without = run(modules, body)
    assert near == "Room\u00a0B"
    assert far == "x\u00a09.0,\u00a0y\u00a00.0\u202fm"
    assert without == "x\u00a01.0,\u00a0y\u00a01.0\u202fm"


def test_a_pose_found_again_is_marked_once_and_a_corrected_one_is_not(modules: Page) -> None:
    body = """
      const listeners = [];
      const state = {
        on: (topic, listener) => listeners.push(listener),
        clock: { unixMs: () => 200000 },
        isRealTime: () => true,
      };
      const marks = [];
      e.followRelocalizations(state, () => graph([node(1, 0, 0)], []), marks);
      const tell = (stampMs, cause) =>
        listeners[0]({ topic: "relocalization", stampMs, message: { node: 1, cause } });
      tell(1000, "recovered"); tell(150000, "recovered"); tell(150000, "recovered");
      tell(160000, "corrected"); tell(170000, "chain");
      return marks;
    """
    assert run(modules, body) == [
        {"at": 150000, "text": "Found again at N1"},
        {"at": 170000, "text": "Found by a chain of places, at N1"},
    ]
