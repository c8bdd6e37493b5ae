"""Pose tracking on walls: one cycle, from a scan of 361 beams to the corrected pose."""

from collections.abc import Iterator

import numpy as np

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_line_ekf import plain_match
from pilotage.bench.reference_lines import plain_lines
from pilotage.core.grid import OccupancyMap
from pilotage.core.line_extraction import LineParams
from pilotage.core.lines import Lines
from pilotage.core.raycast import cast_scan
from pilotage.localizer.ekf_sight import seen_walls, walls_of_map
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import GATE, GaussianPose, LineEkfParams, track
from pilotage.localizer.line_ekf_kernels import Pieces
from pilotage.localizer.measurement import Beams
from pilotage.robot.simulator.floor_plans import office_floor

BEAMS, VIEW, REACH, SIGMA = 361, np.pi, 30.0, 0.01
"""A laser as on the robots of the recorded logs: beams, rad, m, m."""

CYCLES = 40
SURE = np.diag([0.05**2, 0.05**2, np.deg2rad(2.0) ** 2])
"""Covariance before each cycle, of a robot that is being followed."""

Sight = tuple[GaussianPose, Beams]


def ekf_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield one cycle along the corridor of the office."""
    world, params = office_floor(), LineEkfParams()
    known, sights = walls_of_map(world), corridor_sights(world)
    standing = np.zeros(3)

    def all_cycles() -> None:
        for belief, beams in sights:
            track(belief, standing, seen_walls(beams), known, params)

    def plainly() -> None:
        for belief, beams in sights:
            plain_cycle(belief, beams, known, params)

    yield Entry(
        "office: a cycle of the filter of lines",
        Size(len(known.lines), BEAMS, "lines"),
        watch.median_ms(all_cycles, 5) / CYCLES,
        watch.median_ms(plainly, 1) / CYCLES,
        1.0,
        {"pairs": _pairs(sights, known, params)},
    )


def plain_cycle(
    belief: GaussianPose, beams: Beams, known: Walls, params: LineEkfParams
) -> GaussianPose:
    """Return the pose after one cycle of the twin: lines only, corrected one by one."""
    angles = float(beams.bearings[0]), float(beams.bearings[1] - beams.bearings[0])
    lines = plain_lines(beams.ranges, angles, LineParams()).moved(beams.base_from_laser)
    longest_first = lines.chosen(np.argsort(-lines.lengths, kind="stable"))
    near = known.near(belief.mean, params.reach).lines
    found = plain_match(belief.mean, belief.covariance, _pieces(longest_first), _pieces(near), GATE)
    return GaussianPose(*found[2:])


def corridor_sights(world: OccupancyMap) -> list[Sight]:
    """Return beliefs a little beside the truth, along the corridor, and the scans taken there."""
    low, high, y = OFFICE_CORRIDOR
    rng = np.random.default_rng(7)
    bearings = np.linspace(-VIEW / 2.0, VIEW / 2.0, BEAMS)
    sights = []
    for x in np.linspace(low, high, CYCLES):
        pose = np.array([x, y, rng.uniform(-np.pi, np.pi)])
        ranges = cast_scan(world, pose, bearings, REACH) + SIGMA * rng.standard_normal(BEAMS)
        belief = GaussianPose(rng.multivariate_normal(pose, SURE), SURE)
        sights.append((belief, Beams(bearings, ranges, np.zeros(3), REACH)))
    return sights


def _pairs(sights: list[Sight], known: Walls, params: LineEkfParams) -> float:
    standing = np.zeros(3)
    steps = [track(belief, standing, seen_walls(beams), known, params) for belief, beams in sights]
    return float(np.mean([len(step.pairs) for step in steps]))


def _pieces(lines: Lines) -> Pieces:
    return Pieces(lines.ends, lines.polar, lines.covariances)
