"""C-III, an opening of 0.40 m (Li 2008, 5.2): who closes it, who leaves it open, and how wide."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.opening import (
    ON_SURFACE,
    placing_times,
    share_blocked,
    share_on_surface,
    width_of_opening,
)
from pilotage.experiments.opening_plots import opening_figure, width_figure
from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.sonar_drive import RIM, Morcs2, SonarDrive, drive
from pilotage.experiments.sonar_halls import OPENING, Hall, narrow_opening
from pilotage.experiments.sonar_maps import drawn, grid_params, reckon, ring_of
from pilotage.experiments.sonar_report import with_spread
from pilotage.experiments.wall_segments import Floats
from pilotage.mapper.sonar_arcs import ArcCrossings
from pilotage.mapper.sonar_models import SonarModel
from pilotage.mapper.sonar_news import SonarNews, SonarNewsParams

MODELS: tuple[SonarModel, ...] = ("centre_line", "bayes", "atm", "improved_atm")
CELL = 0.025
"""m; smaller than elsewhere, or an opening of 0.40 m were a matter of 8 cells."""

READINGS = SonarNewsParams(use_up_to=2.0)
"""Half the sonar's range: at 1.2 m from the wall the thesis's 1.0 m would leave nothing."""

MEANINGS = {
    "valid_ratio": f"crossings within {ON_SURFACE} m of a true surface, over all crossings that "
    "the method lets place an obstacle; the mean of the runs",
    "width_m": "widest gap in the wall within 0.4 m of the opening's middle; the opening has 0.40",
    "blocked": "share of the true opening's columns that hold an occupied cell",
    "open": "share of runs in which the gap is at least as wide as the robot, 0.33 m",
    "ms_per_scan": "processor time of a round of eight sonars, drawing included",
    "placing_ms_per_scan": "of eight arcs placed among all of the run; _twin: in plain numpy",
}


@dataclass(frozen=True, eq=False)
class Passage:
    """A drive past the opening: maps, crossings (of the methods that have any), times in ms."""

    maps: dict[str, OccupancyMap]
    crossings: dict[str, ArcCrossings]
    ms_per_scan: dict[str, float]
    placing_ms: dict[str, float]


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Pass the opening as often as asked."""
    hall, robot = narrow_opening(), Morcs2()
    passages: list[Passage] = []
    pass_by(hall, robot, np.random.default_rng([request.seed, request.runs]))  # compiles
    for run in range(request.runs):
        passages.append(pass_by(hall, robot, np.random.default_rng([request.seed, run])))
        advance(1.0 / request.runs)
    widths: list[dict[str, float]] = [
        {name: width_of_opening(one.maps[name]) for name in MODELS} for one in passages
    ]
    blocked: list[dict[str, float]] = [
        {name: share_blocked(one.maps[name]) for name in MODELS} for one in passages
    ]
    plots = {
        "narrow-opening": opening_figure(hall, passages[0].maps, passages[0].crossings),
        "narrow-opening-widths": width_figure(widths),
    }
    return Outcome(
        {"meanings": MEANINGS}
        | crossing_report(passages, hall)
        | width_report(widths)
        | with_spread("blocked", blocked)
        | with_spread("ms_per_scan", [one.ms_per_scan for one in passages])
        | with_spread("placing_ms_per_scan", [one.placing_ms for one in passages]),
        plots,
    )


def pass_by(hall: Hall, robot: Morcs2, rng: np.random.Generator) -> Passage:
    """Drive past the opening once, and map it by every model at corrected poses."""
    run = drive(hall.walls, hall.start, hall.orders, robot, rng)
    poses = reckon(run, robot).corrected
    maps: dict[str, OccupancyMap] = {}
    crossings: dict[str, ArcCrossings] = {}
    spent: dict[str, float] = {}
    for model in MODELS:
        begun = time.process_time()
        grid = drawn(run, poses, robot, model, grid_params(READINGS, CELL))
        spent[model] = (time.process_time() - begun) * 1e3 / len(run.rounds)
        maps[model] = grid.map()
        if model in {"atm", "improved_atm"}:
            crossings[model] = grid.crossings()
    arcs = arcs_of(run, poses, robot)
    placing = {name: 8.0 * ms for name, ms in placing_times(arcs, ring_of(robot).cone).items()}
    return Passage(maps, crossings, spent, placing)


def arcs_of(run: SonarDrive, poses: Floats, robot: Morcs2) -> Floats:
    """Return the arcs (n, 4) of all readings used."""
    ring = ring_of(robot)
    news = SonarNews(READINGS, ring)
    heard = zip(run.rounds, run.ranges, strict=True)
    return np.concatenate([news.of(ring.readings(poses[tick + 1], one)) for tick, one in heard])


def crossing_report(passages: Sequence[Passage], hall: Hall) -> dict[str, object]:
    """Return which share of the crossings is valid, and how many there are."""
    counts = [
        {name: share_on_surface(found, hall.walls) for name, found in one.crossings.items()}
        for one in passages
    ]
    ratios = [{name: valid / used for name, (valid, used) in one.items()} for one in counts]
    return with_spread("valid_ratio", ratios) | with_spread(
        "crossings", [{name: used for name, (_, used) in one.items()} for one in counts]
    )


def width_report(widths: Sequence[dict[str, float]]) -> dict[str, object]:
    """Return the widths found, how far they are from the true one, and how often one may pass."""
    errors = [{name: abs(width - OPENING) for name, width in one.items()} for one in widths]
    passable = {name: [one[name] >= 2.0 * RIM - 1e-9 for one in widths] for name in widths[0]}
    return (
        with_spread("width_m", widths)
        | with_spread("width_error_m", errors)
        | {"open": {name: sum(yes) / len(yes) for name, yes in passable.items()}}
    )
