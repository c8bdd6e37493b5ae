"""Where to look from next, on drawn floors."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.core.raycast import cast_scan
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams, Decision
from pilotage.planner.hypotheses import NEAR, likely
from pilotage.planner.situation import Hypotheses
from planner_world import NOTHING, along, belief, gaps_along, hall, plan, seen

ROOMS = plan(
    """
    ########################################
    #........##........##........##........#
    #........##........##........##........#
    #........##........##........##........#
    #........##........##........##........#
    ####..########..########..########..####
    #......................................#
    #......................................#
    #......................................#
    ########################################
    """
)
"""Rooms of 4 m x 2 m, every 5 m, off a corridor; a mark is half a metre."""

NICHE = plan(
    """
    ##############################
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #......................##....#
    #......................##....#
    ##############################
    """
)
"""A hall with something in one corner of it only: half a turn leaves all else as it is."""

IN_ROOM = np.array([2.3, 3.75, 0.3])
NEXT_ROOM = np.array([5.0, 0.0, 0.0])
NONE_TRIED = np.zeros((0, 2))


@lru_cache
def _on(which: str) -> tuple[OccupancyMap, ActiveLocalization]:
    world = {"rooms": ROOMS, "niche": NICHE, "hall": hall(10.0)}[which]
    return world, ActiveLocalization(world, ActiveParams(candidates=30))


def decide(
    which: str,
    places: Hypotheses,
    view: View | None = None,
    tried: NDArray[np.float64] = NONE_TRIED,
    seed: int = 0,
) -> Decision:
    """Decide with the view from the first of the places, if no other is given."""
    world, active = _on(which)
    around = seen(world, places.poses[0]) if view is None else view
    return active.decide(places, around, np.random.default_rng(seed), tried)


def in_rooms(*rooms: int, weights: tuple[float, ...] | None = None) -> Hypotheses:
    """Return the same place in some of the rooms, numbered from the left."""
    return belief(*(IN_ROOM + room * NEXT_ROOM for room in rooms), weights=weights)


def difference(world: OccupancyMap, places: Hypotheses, point: NDArray[np.float64]) -> float:
    """Return by how much the full turns at a displacement differ between two places, m."""
    around = np.arange(72) * 2.0 * np.pi / 72
    there = places.moved([*point, 0.0]).poses
    one, other = (np.minimum(cast_scan(world, p, around, 12.0), 12.0) for p in there[:2])
    return float(np.abs(one - other).mean())


@pytest.mark.parametrize("seed", range(4))
def test_it_leads_out_of_alike_rooms_to_where_the_corridor_tells_them_apart(seed: int) -> None:
    places = in_rooms(0, 1)
    decision = decide("rooms", places, seed=seed)
    best = decision.looks[0]
    assert decision.uncertainty == pytest.approx(1.0)
    assert decision.told_apart == (0, 1)
    assert best.gain > 0.5
    assert difference(ROOMS, places, np.zeros(2)) < 0.05
    assert difference(ROOMS, places, best.point) > 0.2
    # Through the door, which ends at y = 2.5 m, or at least to where one looks through it.
    assert se2.transform_points(places.poses[0], decision.path)[-1, 1] < 3.0


def test_where_it_stands_tells_rooms_apart_that_differ_there() -> None:
    decision = decide("niche", belief([5.0, 2.5, 0.0], [9.9, 2.4, np.pi]))
    here = next(look for look in decision.looks if look.kind == "here")
    assert here.gain == pytest.approx(1.0, abs=0.1)
    assert here.travel == 0.0
    assert decision.looks[0].travel < 1.0


def test_looks_come_by_falling_value_and_none_tells_more_than_is_unknown() -> None:
    decision = decide("rooms", in_rooms(0, 1, 2))
    cost = ActiveParams().alpha * decision.uncertainty
    values = [look.gain - cost * look.travel for look in decision.looks]
    assert values == sorted(values, reverse=True)
    assert max(look.gain for look in decision.looks) <= decision.uncertainty + 1e-6
    assert min(look.gain for look in decision.looks) > -0.01
    assert {look.kind for look in decision.looks} == {"here", "potential", "random"}


def test_who_only_wants_confirming_goes_to_where_it_looks_like_nowhere_else() -> None:
    """Not the farthest place, as when nothing tells several apart, but the rarest near by."""
    world, active = _on("rooms")
    sure = in_rooms(0)
    decision = decide("rooms", sure)
    assert decision.uncertainty == 0.0
    ends = se2.transform_points(sure.best, np.array([look.point for look in decision.looks]))
    travels = np.array([look.travel for look in decision.looks])
    worth = active.potential.bits_at(ends) - travels
    assert worth[0] == worth.max()
    assert world.geometry.contains(world.geometry.cells_of(ends)).all()


def test_a_way_is_weighed_against_what_it_tells() -> None:
    world, active = _on("rooms")
    costly = ActiveLocalization(world, replace(active.params, alpha=5.0))
    decision = costly.decide(
        in_rooms(0, 1), seen(world, IN_ROOM), np.random.default_rng(0), NONE_TRIED
    )
    assert decision.looks[0].travel < decide("rooms", in_rooms(0, 1)).looks[0].travel


def turned_in_the_hall() -> Hypotheses:
    """Return four places of the square hall that no scan tells apart."""
    turns = np.arange(4) * np.pi / 2.0
    middle = np.column_stack([np.full((4, 2), 5.0), turns])
    return Hypotheses(se2.compose(middle, [-2.0, -1.0, 0.2]), np.full(4, 0.25))


def test_in_a_symmetric_hall_nothing_is_to_be_told_so_it_goes_far() -> None:
    decision = decide("hall", turned_in_the_hall())
    assert decision.uncertainty == pytest.approx(2.0)
    assert max(look.gain for look in decision.looks) < ActiveParams().negligible
    assert decision.looks[0].travel == max(look.travel for look in decision.looks)
    assert decision.looks[0].travel > 5.0
    assert decision.heading is None


def test_who_knows_where_it_is_has_nothing_to_find_out() -> None:
    decision = decide("rooms", belief(IN_ROOM))
    assert decision.uncertainty == 0.0
    assert all(look.gain == 0.0 for look in decision.looks)
    assert decision.told_apart == (0, 0)
    assert len(decision.places.weights) == 1


def test_it_does_not_look_again_from_where_it_has_looked() -> None:
    first = decide("rooms", in_rooms(0, 1))
    tried = first.path[-1:]
    second = decide("rooms", in_rooms(0, 1), tried=tried)
    assert np.hypot(*(second.looks[0].point - first.looks[0].point)) > 0.0
    assert np.hypot(*(second.looks[0].point - tried[0])) >= NEAR


def test_with_everything_tried_it_still_goes_somewhere() -> None:
    side = np.arange(-12.0, 12.0, 0.4)
    tried = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    decision = decide("rooms", in_rooms(0, 1), tried=tried)
    assert np.isfinite(decision.path).all()
    assert len(decision.looks) > 10


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("which", "places"),
    [
        ("rooms", in_rooms(0, 1)),
        ("rooms", in_rooms(1, 3, 2, weights=(0.5, 0.3, 0.2))),
        ("rooms", belief([2.3, 1.0, 0.4], [7.3, 1.0, 0.4], [12.6, 1.4, -2.0])),
        ("niche", belief([10.0, 2.0, 1.2], [5.0, 3.0, 1.2 - np.pi])),
        ("hall", turned_in_the_hall()),
    ],
    ids=["two rooms", "three rooms", "corridor", "niche", "hall"],
)
def test_the_path_is_free_wherever_the_robot_may_be(
    which: str, places: Hypotheses, seed: int
) -> None:
    world, active = _on(which)
    # A laser that sees little: nothing but the map says what is free.
    decision = decide(which, places, NOTHING, seed=seed)
    few = likely(decision.places)
    params = active.params.ground
    away = along(decision.path)
    away = away[np.hypot(*away.T) > params.radius + params.gap + 0.1]
    if len(away) > 1:
        gaps = gaps_along(world, few, away)
        # Cells of the ground and of the map are 0.1 m wide, so the gap shrinks by their halves.
        assert gaps.min() > params.radius - 0.05


def test_the_path_keeps_off_what_is_seen_and_is_not_on_the_map() -> None:
    """A shut door, on the robot's right."""
    wall = np.column_stack([np.linspace(-2.0, 2.0, 40), np.full(40, -1.0)])
    box = View(se2.transform_points([0.0, 0.0, -IN_ROOM[2]], wall), NOTHING.bearings)
    free = decide("rooms", in_rooms(0, 1), NOTHING)
    shut = decide("rooms", in_rooms(0, 1), box)
    assert free.looks[0].gain > 0.5
    assert max(look.gain for look in shut.looks) < 0.3
    gaps = np.hypot(*(along(shut.path)[:, None, :] - box.points).transpose(2, 0, 1))
    assert gaps.min() > 0.165


def test_with_a_narrow_view_it_turns_to_what_differs() -> None:
    """Two places of the hall, whose only difference lies to the lower right of the true one."""
    places = belief([5.0, 2.5, 0.5], [10.0, 2.5, 0.5 - np.pi])
    narrow = np.linspace(-0.9, 0.9, 61)
    decision = decide("niche", places, seen(NICHE, places.poses[0], narrow))
    end = decision.path[-1]
    along_path = decision.path[-1] - decision.path[-2]
    arriving = float(np.arctan2(along_path[1], along_path[0])) if end.any() else 0.0
    heading = arriving if decision.heading is None else decision.heading
    niche = np.array([[12.0, 1.0]])
    off = []
    for pose in places.poses:
        bearing = se2.transform_points(se2.inverse(pose), niche)[0] - end
        off.append(abs(se2.between([0, 0, heading], [0, 0, np.arctan2(bearing[1], bearing[0])])[2]))
    # Under either place: it sees the box there, or sees that it is not.
    assert min(off) < 0.6


def test_two_thousand_places_of_equal_weight_are_no_trouble() -> None:
    rng = np.random.default_rng(0)
    free = NICHE.geometry.centres_of(np.argwhere(NICHE.is_free))
    poses = np.column_stack([rng.choice(free, 2000), rng.uniform(-3.14, 3.14, 2000)])
    places = Hypotheses(poses, np.full(2000, 1.0 / 2000))
    decision = decide("niche", places, seen(NICHE, [5.0, 2.5, 0.0]))
    assert len(decision.places.weights) <= 400
    assert decision.places.weights.sum() == pytest.approx(1.0)
    assert np.isfinite([look.gain for look in decision.looks]).all()
    assert np.isfinite(decision.path).all()
    assert decision.looks[0].gain > 1.0


def test_samples_without_weight_are_no_places() -> None:
    decision = decide("rooms", in_rooms(0, 1, 2, weights=(0.5, 0.0, 0.5)))
    assert len(decision.places.weights) == 2
    assert decision.uncertainty == pytest.approx(1.0)


def test_a_place_off_the_map_lets_the_robot_go_no_further_than_it_sees() -> None:
    places = belief(IN_ROOM, [-40.0, 7.0, 1.0])
    blind = decide("rooms", places, NOTHING)
    assert np.hypot(*blind.path.T).max() < 0.3
    sighted = decide("rooms", places)
    assert np.isfinite(sighted.path).all()
    assert gaps_along(ROOMS, belief(IN_ROOM), sighted.path).min() > 0.12


def test_hardly_likely_places_do_not_stop_a_robot() -> None:
    off_the_map = [-40.0, 7.0, 1.0]
    places = belief(IN_ROOM, IN_ROOM + NEXT_ROOM, off_the_map, weights=(1.0, 1.0, 0.01))
    assert decide("rooms", places, NOTHING).looks[0].gain > 0.5


def test_the_same_chances_lead_to_the_same_decision() -> None:
    one, other = (decide("rooms", in_rooms(0, 1, 3), seed=4) for _ in range(2))
    assert (one.path == other.path).all()
    assert [look.gain for look in one.looks] == [look.gain for look in other.looks]
