"""The localizer as the service runs it: in the office, and in buildings of growing size.

An update is all that `MarkovLocalizer.update` does. Its plain twin is prior, scan and sum of the
whole belief alone: it neither looks through walls nor finds modes nor judges them. What the product
takes for the same as the twin stands in entries of its own.
"""

from collections.abc import Callable, Iterator

import numpy as np

from pilotage.bench.buildings import CORRIDOR_MIDDLE, office_block
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference import PlainField, PlainGrid
from pilotage.bench.reference_ranges import plain_range_layer
from pilotage.bench.walk import BEAMS, Sight, corridor_walk
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.likelihood_field import likelihood_field
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.robot.simulator.floor_plans import office_floor

AREAS = (100.0, 300.0, 1000.0, 3000.0, 10_000.0)
"""Of the buildings [m2]."""

OFFICE_CORRIDOR = (1.5, 58.0, 7.1)
SURE = np.diag([0.2**2, 0.2**2, np.deg2rad(5.0) ** 2])
"""Covariance of the start while tracking."""

SETTLING, TRACKED = 10, 40
"""Scans before the measurement begins, and during it."""

SMALLEST = 3.0
"""Side [m] of the building that is not measured."""

SECOND_NS = 10**9


def office_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield tables, first update and tracking in the office of 60 m x 40 m."""
    world = office_floor()
    _compile()
    made: list[MarkovLocalizer] = []
    setup = watch.ms(lambda: made.append(MarkovLocalizer(world, MarkovParams())))
    yield _tables_entry(watch, world, setup)
    walk = corridor_walk(world, OFFICE_CORRIDOR, SETTLING + TRACKED)
    yield from _updates(watch, made[0], walk, ("office", {}))


def growth_cases(watch: Stopwatch, peak_mb: Callable[[], float]) -> Iterator[Entry]:
    """Yield first update and tracking in buildings of growing area.

    `peak_mb` tells the most memory the process has had; as each building needs more than the
    last, that is the building's own.
    """
    _compile()
    before = peak_mb()
    for area in AREAS:
        side = round(np.sqrt(area), 1)
        world = office_block(side)
        localizer = MarkovLocalizer(world, MarkovParams())
        walk = corridor_walk(world, (1.5, side - 1.5, CORRIDOR_MIDDLE), SETTLING + TRACKED)
        localizer.update(0, walk[0].pose, walk[0].scan)
        extra = {"area_m2": area, "memory_mb": peak_mb() - before}
        yield from _updates(watch, localizer, walk, (f"building of {area:.0f} m2", extra))


def _compile() -> None:
    """Have everything compiled, and loaded, by a localizer on next to nothing."""
    world = office_block(SMALLEST)
    localizer = MarkovLocalizer(world, MarkovParams())
    walk = corridor_walk(world, (1.0, SMALLEST - 1.0, SMALLEST / 2.0), 3)
    for count, sight in enumerate(walk):
        localizer.update(count * SECOND_NS, sight.pose, sight.scan)


def _updates(
    watch: Stopwatch,
    localizer: MarkovLocalizer,
    walk: list[Sight],
    place: tuple[str, dict[str, float]],
) -> Iterator[Entry]:
    """Yield a scan of the whole belief, the first update, and updates while tracking."""
    name, extra = place
    size = Size(int(np.prod(localizer.grid.grid.shape)), BEAMS)
    plain, fraction = _plain_update(watch, localizer, walk[0])
    whole = _whole_belief_ms(watch, localizer, walk[0])
    yield Entry(f"{name}: whole belief weighed by a scan", size, whole, plain, fraction, extra)
    first = watch.median_ms(
        lambda: localizer.update(0, walk[0].pose, walk[0].scan), 3, localizer.start_anywhere
    )
    yield Entry(f"{name}: first update, unknown start", size, first, plain, fraction, extra)
    spent = _tracking_ms(watch, localizer, walk)
    shares = {
        "p95_ms": float(np.percentile(spent, 95)),
        "localized_share": 1.0 if localizer.estimate.state == "localized" else 0.0,
    }
    yield Entry(
        f"{name}: update while tracking",
        size,
        float(np.median(spent)),
        plain,
        fraction,
        extra | shares,
    )


def _whole_belief_ms(watch: Stopwatch, localizer: MarkovLocalizer, sight: Sight) -> float:
    """Return what prior, scan and sum take when nothing may be left out."""
    grid, params, ends = localizer.grid, localizer.params, sight.scan.ends
    states = grid.grid
    field = likelihood_field(localizer.world, states.geometry, states.heading_step, params.scan)

    def weigh() -> None:
        grid.add_floor(1.0)
        if ends is not None:
            grid.weigh_scan(ends, field, params.tempering)
        grid.settle()

    return watch.median_ms(weigh, 3)


def _tracking_ms(watch: Stopwatch, localizer: MarkovLocalizer, walk: list[Sight]) -> list[float]:
    """Return what each update takes once the robot is tracked."""
    localizer.start_at(walk[0].pose, SURE)
    spent = []
    for count, sight in enumerate(walk):
        stamp, pose, scan = count * SECOND_NS, sight.pose, sight.scan
        taken = watch.ms(lambda: localizer.update(stamp, pose, scan))  # noqa: B023 - called at once
        if count >= SETTLING:
            spent.append(taken)
    return spent


def _plain_update(
    watch: Stopwatch, localizer: MarkovLocalizer, sight: Sight
) -> tuple[float, float]:
    """Return what an update of the whole belief takes the twin [ms], and the share it did."""
    states, params = localizer.grid.grid, localizer.params
    ends = sight.scan.ends
    layers = 1
    plain, field = PlainGrid(states, layers), PlainField(states, params.scan)

    def update() -> None:
        plain.add_floor(params.recovery_weight, None)
        if ends is not None:
            plain.weigh_scan(ends, field, params.tempering)
        plain.settle()

    fraction = layers / states.headings
    return watch.median_ms(update, 1) / fraction, fraction


def _tables_entry(watch: Stopwatch, world: OccupancyMap, setup: float) -> Entry:
    """Return what it takes to make a localizer on a map: states, fields, expected ranges.

    The twin makes expected ranges only, in one direction.
    """
    params = MarkovParams()
    states = pose_grid(world, PoseGridParams())
    reach = params.visibility.reach
    plain = watch.ms(lambda: plain_range_layer(world, states, 0.3, reach))
    return Entry(
        "office: tables of a new map",
        Size(int(np.prod(states.shape)), 0),
        setup,
        plain * states.headings,
        1.0 / states.headings,
    )
