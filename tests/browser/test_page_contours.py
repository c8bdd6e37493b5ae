"""The planner's pure modules: lines of a field, and what it does in words."""

from itertools import pairwise
from typing import Any

import pytest
from playwright.sync_api import Page

pytestmark = pytest.mark.browser

FIELD = """const field = (rows, cols, value) => {
  const data = new Float32Array(rows * cols);
  for (let r = 0; r < rows; r++)
    for (let c = 0; c < cols; c++) data[r * cols + c] = value(c + 0.5, r + 0.5);
  return { rows, cols, data };
};"""


def run(page: Page, module: str, body: str, given: object = None) -> Any:  # noqa: ANN401 - JS
    """Return what `body` returns; `m` is the module, `given` what is handed over."""
    script = f"async (given) => {{ const m = await import('/static/{module}'); {FIELD} {body} }}"
    return page.evaluate(script, given)


def contours(page: Page, body: str) -> Any:  # noqa: ANN401 - what JavaScript returns
    return run(page, "layers/contours.js", body)


def test_levels_are_even_and_no_peak_takes_them_all(modules: Page) -> None:
    levels = contours(
        modules,
        "return m.levelsOf(field(100, 100, (x, y) => (x > 99 && y > 99 ? 1e9 : x)), 8)",
    )
    assert len(levels) == 8
    steps = [b - a for a, b in pairwise(levels)]
    assert steps == pytest.approx([steps[0]] * 7, rel=1e-4)
    assert 0.0 < levels[0] < levels[-1] < 100.0


def test_a_flat_or_empty_field_has_no_levels(modules: Page) -> None:
    body = "return [() => 3, () => NaN].map((f) => m.levelsOf(field(5, 5, f), 8))"
    assert contours(modules, body) == [[], []]


def test_a_cone_has_circles_that_close(modules: Page) -> None:
    worst, closed, counts = contours(
        modules,
        """const cone = field(60, 80, (x, y) => Math.hypot(x - 40, y - 30));
        const lines = m.contoursOf(cone, [10, 20]);
        const off = lines.flatMap((level, i) => level.flat()
          .map(([x, y]) => Math.abs(Math.hypot(x - 40, y - 30) - [10, 20][i])));
        const closed = lines.flat().every((l) => String(l[0]) === String(l.at(-1)));
        return [Math.max(...off), closed, lines.map((level) => level.length)];""",
    )
    assert worst < 0.05
    assert closed
    assert counts == [1, 1]


def test_a_plane_has_straight_lines_of_two_points(modules: Page) -> None:
    lines = contours(modules, "return m.contoursOf(field(40, 40, (x) => x), [10, 25.25])")
    assert [len(level) for level in lines] == [1, 1]
    assert sorted(lines[1][0]) == [[25.25, 0.5], [25.25, 39.5]]


def test_lines_stop_where_nothing_is_known(modules: Page) -> None:
    lines = contours(
        modules,
        "return m.contoursOf(field(40, 40, (x, y) => (y > 15 && y < 25 ? NaN : x)), [20])",
    )
    assert len(lines[0]) == 2
    assert all(y < 15 or y > 25 for line in lines[0] for _, y in line)


def test_at_a_saddle_the_middle_decides(modules: Page) -> None:
    saddles = contours(
        modules,
        """const at = (data, level) => m.contoursOf({ rows: 2, cols: 2, data }, [level])[0];
        return [at([1, 0, 0, 1], 0.4), at([1, 0, 0, 1], 0.6)]
          .map((lines) => lines.map(([[a, b], [c, d]]) => (a + b < 2) === (c + d < 2)));""",
    )
    together, apart = saddles
    assert together == [False, False], "the high corners are joined: lines cross their diagonal"
    assert apart == [True, True], "each high corner is cut off by itself"


def test_a_gap_of_one_cell_takes_the_mean_beside_it(modules: Page) -> None:
    wide = contours(
        modules,
        "return [...m.widened({ rows: 1, cols: 5, data: [1, NaN, 3, NaN, NaN] }).data].map(String)",
    )
    assert wide == ["1", "2", "3", "3", "NaN"]


def test_the_slope_points_where_the_field_rises(modules: Page) -> None:
    slopes = contours(
        modules,
        """const plane = field(10, 10, (x, y) => 2 * x - y);
        return [m.gradientAt(plane, [4.2, 5.7]), m.gradientAt(plane, [0.1, 5])];""",
    )
    assert slopes == [{"x": pytest.approx(2.0), "y": pytest.approx(-1.0)}, None]


def test_a_coarse_field_is_refined_without_shifting_it(modules: Page) -> None:
    factors, away = run(
        modules,
        "layers/smoothing.js",
        """const coarse = field(20, 30, (x, y) => 3 * x + y);
        const fine = m.refined(coarse, 4);
        let away = 0;
        for (let r = 16; r < fine.rows - 16; r++)
          for (let c = 16; c < fine.cols - 16; c++) {
            const true_ = (3 * (c + 0.5) + (r + 0.5)) / 4;
            away = Math.max(away, Math.abs(fine.data[r * fine.cols + c] - true_));
          }
        return [[coarse, { rows: 400, cols: 600 }].map(m.finerBy), away];""",
    )
    assert factors == [4, 1]
    assert away < 0.02, "of values up to 110"


def test_what_is_unknown_stays_unknown_when_refined(modules: Page) -> None:
    shares = run(
        modules,
        "layers/smoothing.js",
        """const half = field(20, 20, (x) => (x < 10 ? 5 : NaN));
        const { data } = m.refined(half, 2);
        const known = data.filter((v) => !Number.isNaN(v));
        return [known.length / data.length, known.every((v) => Math.abs(v - 5) < 1e-5)];""",
    )
    assert shares[0] == pytest.approx(0.5, abs=0.06)
    assert shares[1] is True


def test_labels_give_way_to_the_robot_the_rim_and_each_other(modules: Page) -> None:
    boxes, has_room = run(
        modules,
        "layers/labels.js",
        """const context = new OffscreenCanvas(400, 300).getContext('2d');
        const labels = new m.Labels(context, { width: 400, height: 300 }, { x: 200, y: 150 });
        labels.block({ x: 0, y: 0, width: 400, height: 60 });
        const ink = { fill: 'black', edge: 'white', ink: 'white' };
        const room = [[200, 150], [200, 150], [60, 80], [200, 150], [200, 150], [200, 150]]
          .map(([x, y]) => labels.write('1 · 58 %', { x, y }, 28, ink));
        return [labels.taken, room];""",
    )
    assert has_room == [True] * 5 + [False], "above, below and both sides of the robot; then none"
    for i, a in enumerate(boxes):
        for b in boxes[:i]:
            is_beside = a["x"] + a["width"] <= b["x"] or b["x"] + b["width"] <= a["x"]
            is_above = a["y"] + a["height"] <= b["y"] or b["y"] + b["height"] <= a["y"]
            assert is_beside or is_above
        assert a["x"] >= 0
        assert a["x"] + a["width"] <= 400


def test_lines_are_drawn_anew_only_when_view_map_or_field_change(modules: Page) -> None:
    drawn = run(
        modules,
        "layers/potential.js",
        """const { View } = await import('/static/view.js');
        let bakes = 0;
        await new Promise((ready) => {
          globalThis.layer = new m.PotentialLayer({ grid: null }, ready);
          const bake = layer.bake.bind(layer);
          layer.bake = (...all) => { bakes++; bake(...all); };
          const { rows, cols, data } = field(400, 600, (x, y) => x * y);
          const potential = { shape: [rows, cols], data };
          layer.take({ potential, resolution: 0.1, origin: { x: 0, y: 0, theta: 0 } });
        });
        const view = Object.assign(new View(), { size: { width: 600, height: 400 } });
        const context = new OffscreenCanvas(600, 400).getContext('2d');
        const counts = [];
        const draw = () => { layer.draw(context, view, 1, 'red'); counts.push(bakes); };
        draw(); draw(); draw();
        view.panBy(3, 0); draw(); draw();
        layer.forget(); draw();
        return counts;""",
    )
    assert drawn == [1, 1, 1, 2, 2, 3]


CANDIDATE = {"travel": 4.2, "expected_gain": 1.3, "kind": "map"}
PLAN = {"candidates": [CANDIDATE], "reason": "would tell place 1 from place 2"}
DRIVE = "Drive 4.2\u202fm to A: \u22121.3\u202fbits expected."
LOOKING = {"mode": "localizing", "reason": "finding out where it is"}
GOAL = {"x": 22.0, "y": 2.5}
GOING = {"mode": "going", "reason": "going to (22.00, 2.50)", "goal": GOAL, "distance_left": 9.26}
LEFT = "9.3\u202fm left to x 22.0, y 2.5\u202fm."


@pytest.mark.parametrize(
    ("status", "plan", "told"),
    [
        (LOOKING, PLAN, f"Resolving doubt: {DRIVE} Would tell place 1 from place 2."),
        (LOOKING, None, "Resolving doubt: Finding out where it is."),
        (
            LOOKING,
            {"candidates": [CANDIDATE | {"kind": "here"}], "reason": ""},
            "Resolving doubt: Look round from here: \u22121.3\u202fbits expected.",
        ),
        (
            LOOKING | {"goal": GOAL},
            PLAN | {"reason": "a rare corner"},
            f"Resolving doubt: {DRIVE} A rare corner. Then on to the goal.",
        ),
        (GOING, None, f"Going: {LEFT}"),
        (
            GOING | {"reason": "stands before an obstacle"},
            None,
            f"Going: {LEFT} Stands before an obstacle.",
        ),
        (GOING | {"distance_left": None}, None, "Going: On the way to x 22.0, y 2.5\u202fm."),
        ({"mode": "waiting", "reason": "no pose has come"}, None, "Waiting: No pose has come."),
        ({"outcome": "failed", "reason": "blocked!"}, None, "Gave up: Blocked!"),
        ({"outcome": "interrupted", "reason": "by a person"}, None, "Interrupted: By a person."),
        ({"always_localizes": True}, None, "Idle: Waits for a doubt to resolve."),
        ({}, None, "Idle: Nothing is planned."),
    ],
)
def test_what_the_planner_does_is_said_in_a_sentence(
    modules: Page, status: dict[str, Any], plan: dict[str, Any] | None, told: str
) -> None:
    known = {
        "mode": "idle",
        "outcome": "none",
        "reason": "nothing to do",
        "always_localizes": False,
    }
    said = run(
        modules,
        "planning.js",
        """const state = { age: () => 0.1, message: (topic) => given[topic] };
        const { word, text } = m.nextLook(state);
        return `${word}: ${text}`;""",
        {"planning_status": {"goal": None, "distance_left": None} | known | status, "plan": plan},
    )
    assert said == told
