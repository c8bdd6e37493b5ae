"""The page's pure modules, run in the browser that will run them."""

from typing import Any

import pytest
from playwright.sync_api import Page

pytestmark = pytest.mark.browser

MODES = "const mode = (mass, x, theta = 0) => ({ mass, pose: { x, y: 0, theta } });"


def run(page: Page, module: str, body: str) -> Any:  # noqa: ANN401 - what JavaScript returns
    """Return what `body` returns; `m` is the module."""
    return page.evaluate(f"import('/static/{module}').then((m) => {{ {body} }})")


def test_percents_sum_to_a_hundred(modules: Page) -> None:
    shares = "[1/3, 1/3, 1/3], [0.585, 0.275, 0.085, 0.055], [1, 0], [0.996, 0.004]"
    sums = f"return [{shares}].map((s) => m.percentsOf(s).reduce((a, b) => a + b, 0))"
    assert run(modules, "format.js", sums) == [100, 100, 100, 100]


def test_numbers_have_fixed_decimals_and_a_true_minus(modules: Page) -> None:
    texts = run(modules, "format.js", "return [m.number(-1.25, 1), m.number(-0.01, 1)]")
    assert texts == ["\u22121.3", "0.0"]
    assert run(modules, "format.js", "return m.withUnit(2.345, 1, 'Hz')") == "2.3\u202fHz"


def test_a_place_keeps_its_number_while_two_change_ranks(modules: Page) -> None:
    numbers = run(
        modules,
        "places.js",
        MODES
        + """const places = new m.Places();
        const seen = () => places.list.map((p) => [p.number, p.pose.x]);
        places.update([mode(0.5, 1), mode(0.4, 5)], 10000);
        places.update([mode(0.5, 5.1), mode(0.4, 1.1)], 10400);
        const held = seen();
        places.update([mode(0.5, 5.1), mode(0.4, 1.1)], 12500);
        return [held, seen(), places.best.pose.x];""",
    )
    assert numbers == [[[1, 1.1], [2, 5.1]], [[1, 5.1], [2, 1.1]], 5.1]


def test_light_places_are_summed_as_elsewhere(modules: Page) -> None:
    told = run(
        modules,
        "places.js",
        MODES
        + """const places = new m.Places();
        places.update([mode(0.58, 1), mode(0.27, 5), mode(0.09, 9), mode(0.02, 12)], 5000);
        return [places.list.map((p) => p.percent), places.elsewhere];""",
    )
    assert told == [[58, 27, 9], 6]


def test_the_best_place_is_shown_however_light(modules: Page) -> None:
    body = MODES + "const p = new m.Places(); p.update([mode(0.01, 1)], 0); return p.list.length"
    assert run(modules, "places.js", body) == 1


def test_screen_and_map_are_each_others_inverse(modules: Page) -> None:
    away = run(
        modules,
        "view.js",
        """const view = new m.View();
        Object.assign(view, { size: { width: 800, height: 600 }, angle: 0.7, scale: 33 });
        view.centre = { x: 4, y: -2 };
        const back = view.toMap(view.toScreen({ x: 7.5, y: 1.25 }));
        return Math.hypot(back.x - 7.5, back.y - 1.25);""",
    )
    assert away < 1e-9


def test_zoom_keeps_what_is_under_the_pointer(modules: Page) -> None:
    away = run(
        modules,
        "view.js",
        """let now = 0;
        const view = new m.View(() => now);
        view.size = { width: 800, height: 600 };
        const at = { x: 700, y: 100 };
        const before = view.toMap(at);
        view.zoomBy(4, at, Math.PI / 2);
        const worst = [];
        for (; now <= 130; now += 10) {
          view.step();
          const there = view.toMap(at);
          worst.push(Math.hypot(there.x - before.x, there.y - before.y));
        }
        return [Math.max(...worst), view.scale, view.angle];""",
    )
    assert away[0] < 1e-9
    assert away[1:] == pytest.approx([80.0, 1.5707963])


def test_zoom_ends_at_its_limits(modules: Page) -> None:
    body = """const view = new m.View();
    view.zoomBy(1e6, view.focus, 0, false); const most = view.scale;
    view.zoomBy(1e-9, view.focus, 0, false); return [most, view.scale];"""
    assert run(modules, "view.js", body) == [400, 5]


def test_following_moves_only_when_the_robot_leaves_the_middle(modules: Page) -> None:
    moved = run(
        modules,
        "view.js",
        """const view = new m.View();
        view.size = { width: 800, height: 600 };
        view.keepInSight({ x: 5, y: 0 });
        const calm = view.centre.x;
        view.keepInSight({ x: 20, y: 0 });
        const followed = view.centre.x;
        view.panBy(10, 0);
        const panned = view.centre.x;
        view.keepInSight({ x: 200, y: 0 });
        return [calm, followed, view.centre.x === panned];""",
    )
    assert moved == [0, 8, True]


def test_the_trail_breaks_where_the_estimate_jumps_or_was_missing(modules: Page) -> None:
    breaks = run(
        modules,
        "history.js",
        """const trail = new m.Trail();
        const put = (at, x, is = true) => trail.add(at, { x, y: 0, theta: 0 }, is);
        put(0, 0); put(100, 0.1); put(200, 3); put(300, 3.1); put(5000, 3.2); put(5100, 3.3, false);
        return trail.points.map((p) => p.isBreak);""",
    )
    assert breaks == [False, False, True, False, True]


def test_the_trail_forgets_after_a_minute(modules: Page) -> None:
    body = """const trail = new m.Trail();
    for (let s = 0; s <= 90; s++) trail.add(s * 1000, { x: s * 0.3, y: 0, theta: 0 }, true);
    return trail.points[0].at;"""
    assert run(modules, "history.js", body) == 30000


def test_the_gateways_memory_comes_before_what_the_page_saw(modules: Page) -> None:
    body = """const trail = new m.Trail();
    trail.add(2000, { x: 2, y: 0, theta: 0 }, true);
    trail.seed({ poses: [[1, 1, 0, 0], [1.5, 1.5, 0, 0], [2.5, 9, 0, 0]], breaks: [1] });
    return trail.points.map((p) => [p.pose.x, p.isBreak]);"""
    assert run(modules, "history.js", body) == [[1, False], [1.5, True], [2, False]]


def test_missing_time_is_a_gap_in_the_line(modules: Page) -> None:
    body = """const series = new m.Series();
    for (const at of [0, 500, 6000, 6500]) series.add(at, 1);
    return series.samples.map((s) => s.value);"""
    assert run(modules, "history.js", body) == [1, 1, None, 1, 1]


def test_the_percentile_is_of_the_last_seconds(modules: Page) -> None:
    body = """const ages = new m.AgePercentile(1000);
    ages.add(0, 900); for (let i = 1; i <= 50; i++) ages.add(1000 + i, i); return ages.p99();"""
    assert run(modules, "history.js", body) == 50


def test_the_belief_has_one_fixed_scale(modules: Page) -> None:
    body = """const ramp = [[0,0,0],[50,50,50],[100,100,100],[150,150,150],[200,200,200]];
    return [0.0009, 0.001, 0.01, 0.1, 5].map((d) => m.beliefColour(ramp, d)?.map(Math.round));"""
    assert run(modules, "palette.js", body) == [
        None,
        [0, 0, 0, 64],
        [100, 100, 100, 153],
        [200, 200, 200, 242],
        [200, 200, 200, 242],
    ]


def test_an_ellipse_is_as_long_and_turned_as_its_covariance(modules: Page) -> None:
    body = """const e = m.ellipseOf({ data: [2.5, 1.5, 0, 1.5, 2.5, 0, 0, 0, 1] }, 2);
    return [e.major, e.minor, e.direction];"""
    assert run(modules, "geometry.js", body) == pytest.approx([4.0, 2.0, 0.7853982])


def test_the_scale_bar_has_a_round_length(modules: Page) -> None:
    body = "return [4.7, 2, 0.09, 31].map(m.roundLength)"
    assert run(modules, "layers/ruler.js", body) == pytest.approx([2, 2, 0.05, 20])


def test_a_thin_wall_is_seen_from_afar(modules: Page) -> None:
    kinds = run(
        modules,
        "layers/walls.js",
        """const cells = new Int8Array(256 * 256);
        for (let r = 0; r < 256; r++) cells[r * 256 + 77] = 100;
        const walls = new m.Walls();
        const palette = { free: "rgb(1,1,1)", occupied: "rgb(2,2,2)" };
        const origin = { x: 0, y: 0, theta: 0 };
        const shaped = { shape: [256, 256], data: cells };
        walls.take({ cells: shaped, resolution: 0.05, origin }, palette);
        return walls.levels.map((l) => l.kinds.filter((kind) => kind === 2).length / l.rows);""",
    )
    assert kinds == [1, 1, 1]


def test_the_map_is_framed_by_its_known_cells_wherever_it_lies(modules: Page) -> None:
    bounds = run(
        modules,
        "layers/walls.js",
        """const data = new Int8Array(100).fill(-1);
        data[23] = 0; data[45] = 100;
        const walls = new m.Walls();
        const origin = { x: 10, y: 0, theta: Math.PI / 2 };
        const palette = { free: "rgb(1,1,1)", occupied: "rgb(2,2,2)" };
        walls.take({ cells: { shape: [10, 10], data }, resolution: 1, origin }, palette);
        const { x0, x1, y0, y1 } = walls.bounds();
        return [x0, x1, y0, y1];""",
    )
    assert bounds == pytest.approx([5, 8, 3, 6])


def test_the_clock_trusts_the_shortest_round_trip(modules: Page) -> None:
    body = """let now = 1000;
    const clock = new m.ServerClock(() => now);
    clock.sync(50_000, 990); now = 2000; clock.sync(50_900, 1500); now = 3000;
    return [clock.unixMs(), clock.roundTripMs];"""
    assert run(modules, "server_clock.js", body) == [52_005, 500]


@pytest.mark.parametrize(
    ("process", "told"),
    [
        ({"state": "ready"}, ["ok", "Mapper 4.9\u202fHz"]),
        ({"state": "late", "late_for": 1.23}, ["warning", "Mapper late 1.2\u202fs"]),
        ({"state": "down"}, ["fault", "Mapper down, restarting, try 2 of 5"]),
        ({"state": "starting"}, ["fault", "Mapper restarting, try 2 of 5"]),
        ({"state": "starting", "try_number": 0}, ["none", "Mapper starting"]),
        ({"state": "given_up"}, ["fault", "Mapper given up after 2 tries"]),
        ({"state": "stopped"}, ["none", "Mapper stopped"]),
    ],
)
def test_each_state_of_a_process_has_its_words(
    modules: Page, process: dict[str, Any], told: list[str]
) -> None:
    known = {"name": "mapper", "try_number": 2, "max_tries": 5} | process
    body = "async (p) => { const m = await import('/static/status.js');"
    body += "const c = m.processChip(p, 4.9); return [c.kind, c.text]; }"
    assert modules.evaluate(body, known) == told


def test_each_state_of_the_pose_has_its_word(modules: Page) -> None:
    body = """const told = (state, age = 0.1) => m.stateChip({ state }, 3, age).text;
    return ["localized", "ambiguous", "lost", "unknown"].map((s) => told(s))
      .concat(told("localized", 3.5), m.stateChip(undefined, 0, null).text);"""
    assert run(modules, "status.js", body) == [
        "Localized",
        "Ambiguous · 3 places",
        "Lost",
        "Searching",
        "No data",
        "No data",
    ]
