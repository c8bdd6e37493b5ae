"""The planner: what looks would tell a robot that could be anywhere, and a whole decision."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_active import PlainLooks, plain_merged
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.core.raycast import cast_scan
from pilotage.localizer.particle_start import free_space
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.situation import Hypotheses
from pilotage.robot.simulator.floor_plans import office_floor

SAMPLES, CANDIDATES = 3000, 30
PLAIN_CANDIDATES = 3
"""So many are weighed by the twin: one costs what another does."""
PLACES = 400
"""Most places that a decision tells apart."""
FARTHEST = 8.0
"""m to the candidates of the first case; those of a decision lie where the robot can go."""
NONE_TRIED: NDArray[np.float64] = np.zeros((0, 2))


def planner_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield the gains of all candidates, and a whole decision, from an unknown start."""
    world, rng = office_floor(), np.random.default_rng(0)
    params = ActiveParams(candidates=CANDIDATES)
    active = ActiveLocalization(world, params)
    plain = PlainLooks(world, params.sight, params.observations)
    poses = free_space(world).draw(SAMPLES, rng)
    belief = Hypotheses(poses, np.full(SAMPLES, 1.0 / SAMPLES))
    points = rng.uniform(-FARTHEST, FARTHEST, (CANDIDATES, 2))
    size = Size(SAMPLES, params.sight.beams, "particles")
    extra = {"candidates": float(CANDIDATES), "observations": float(params.observations)}
    share = PLAIN_CANDIDATES / CANDIDATES
    few = points[:PLAIN_CANDIDATES]

    yield Entry(
        "office: what each of 30 looks would tell",
        size,
        watch.median_ms(lambda: active.gains(belief, points), 5),
        watch.ms(lambda: [plain.gain(belief, point) for point in few]) / share,
        share,
        extra,
    )
    view = _view(world)
    merging = watch.ms(lambda: plain_merged(belief, PLACES))
    places = plain_merged(belief, PLACES)
    # The twin looks for no ways and no heading: that favours it.
    weighing = watch.ms(lambda: [plain.gain(places, point) for point in few]) / share
    yield Entry(
        "office: where to look from next, decided",
        size,
        watch.median_ms(lambda: active.decide(belief, view, rng, NONE_TRIED), 5),
        merging + weighing,
        share,
        extra,
    )


def _view(world: OccupancyMap) -> View:
    """Return what the laser sees at the beginning of the corridor."""
    bearings = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 271)
    here = np.array([OFFICE_CORRIDOR[0], OFFICE_CORRIDOR[2], 0.0])
    return View.of(cast_scan(world, here, bearings, 12.0), bearings, np.zeros(3))
