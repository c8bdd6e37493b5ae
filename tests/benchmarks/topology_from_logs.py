"""Topological maps built live from real lasers, drawn over the occupancy map to be looked at.

    .venv/bin/python tests/benchmarks/topology_from_logs.py OUT [fr079 wean]

For each log a picture OUT/NAME.png is written, and figures are printed.
"""

import os
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from pilotage.core.grid import OccupancyMap
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_drive.building import LiveBuilder
from pilotage.topology.topological_map import TopologicalMap
from topology_logs import WEAN_START, Drive, fr079, localized, mapped, wean

DATA = Path(
    os.environ.get("PILOTAGE_DATA") or Path(__file__).resolve().parents[3] / "shared" / "datasets"
)
EDGE_SHADES = {"corridor": "#2980b9", "room": "#27ae60", "door": "#c0392b", "passage": "#8e44ad"}
NODE_MARKS = {"node": "o", "door": "s", "corner": "^", "passage": "D"}
FEATURE_SHADES = {"corner": "#f39c12", "door": "#c0392b", "passage": "#8e44ad"}


def drives() -> dict[str, Callable[[], Drive]]:
    """Return the drives by name; each takes a while to make."""
    return {
        "fr079": lambda: mapped(fr079(DATA)),
        "wean": lambda: localized(wean(DATA), DATA / "wean_hall" / "wean.dat.gz", WEAN_START),
    }


def draw(drive: Drive, topology: TopologicalMap, features: Features) -> Figure:
    """Return a picture of the map, the drive, the features and the graph."""
    low, high = drive.poses[:, :2].min(axis=0) - 5.0, drive.poses[:, :2].max(axis=0) + 5.0
    width, height = high - low
    figure = Figure(figsize=(22.0, max(22.0 * height / width, 6.0)), layout="constrained")
    axes = figure.subplots()
    draw_world(axes, drive.world)
    axes.plot(*drive.poses[:, :2].T, color="#bdc3c7", linewidth=0.8)
    for edge in topology.edges:
        axes.plot(*edge.way.T, color=EDGE_SHADES[edge.kind], linewidth=1.6)
    draw_features(axes, features)
    for node in topology.nodes:
        x, y = float(node.pose[0]), float(node.pose[1])
        axes.plot(x, y, NODE_MARKS[node.kind], color="#1d2733", markersize=7, markerfacecolor="w")
        axes.annotate(f"{node.id}:{len(node.features)}", (x + 0.15, y + 0.15), fontsize=8)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    return figure


def draw_world(axes: Axes, world: OccupancyMap) -> None:
    rows, cols = np.nonzero(world.cells >= 65)
    points = world.geometry.centres_of(np.stack([rows, cols], axis=1))
    axes.plot(*points.T, "s", color="#7f8c8d", markersize=1.2)


def draw_features(axes: Axes, features: Features) -> None:
    for kind, pose, width in zip(features.kinds, features.poses, features.widths, strict=True):
        shade = FEATURE_SHADES[KINDS[kind]]
        ahead = np.array([np.cos(pose[2]), np.sin(pose[2])])
        if KINDS[kind] == "corner":
            axes.plot(*np.stack([pose[:2], pose[:2] + 0.25 * ahead]).T, color=shade, linewidth=2)
            continue
        across = np.array([-ahead[1], ahead[0]]) * width / 2.0
        axes.plot(*np.stack([pose[:2] - across, pose[:2] + across]).T, color=shade, linewidth=3)


def main(out: Path, names: list[str]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for name, make in drives().items():
        if names and name not in names:
            continue
        drive = make()
        started = time.process_time()
        seen = list(drive.seen())
        looked = time.process_time()
        builder = LiveBuilder()
        worst = 0.0
        for stamp, pose, features in seen:
            before = time.process_time()
            builder.add(stamp, pose, features)
            worst = max(worst, time.process_time() - before)
        built = time.process_time()
        builder.finish()
        finished = time.process_time()
        topology = builder.topology(name)
        draw(drive, topology, builder.features).savefig(out / f"{name}.png", dpi=80)
        print(
            f"{name}: {len(seen)} scans, {(looked - started) * 1e3 / len(seen):.2f} ms a scan to"
            f" see, {(built - looked) * 1e3 / len(seen):.2f} ms to build (worst"
            f" {worst * 1e3:.0f} ms), finish {(finished - built) * 1e3:.0f} ms\n"
            f"  nodes {dict(Counter(node.kind for node in topology.nodes))}"
            f" edges {dict(Counter(edge.kind for edge in topology.edges))}"
            f" features {dict(Counter(KINDS[k] for k in builder.features.kinds))}"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
