"""Times of the topological map: routes among 10,000 nodes, and building a map of a real floor.

Beside networkx, which knows nothing of where nodes lie. Run as

    .venv/bin/python tests/benchmarks/topology_figures.py [../shared/datasets]
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import networkx as nx
import numpy as np

from pilotage.core.map_files import load_map
from pilotage.topology.features import Features
from pilotage.topology.from_map.building import build_topology
from pilotage.topology.routes.route import Router
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

SIDE = 100
"""Nodes along each side of the square of streets."""
ROUTES = 200


def streets(rng: np.random.Generator) -> TopologicalMap:
    """Return SIDE x SIDE nodes about 3 m apart, and ways between neighbours that bend."""
    places = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), axis=-1).reshape(-1, 2) * 3.0
    places = places + rng.normal(0.0, 0.5, places.shape)
    nodes = tuple(
        Node(i, "node", f"node {i}", np.array([x, y, 0.0]), Features.none())
        for i, (x, y) in enumerate(places)
    )
    pairs = [(i, i + 1) for i in range(SIDE * SIDE) if (i + 1) % SIDE]
    pairs += [(i, i + SIDE) for i in range(SIDE * (SIDE - 1))]
    edges = tuple(
        Edge(
            id=len(nodes) + k,
            start=i,
            end=j,
            kind="corridor",
            length=float(np.hypot(*(places[i] - places[j])) * rng.uniform(1.0, 1.3)),
            way=places[[i, j]],
        )
        for k, (i, j) in enumerate(pairs)
    )
    return TopologicalMap("streets", nodes, edges)


def cpu_ms(work: Callable[[], object]) -> float:
    """Return the CPU time of one call in ms."""
    start = time.process_time()
    work()
    return 1e3 * (time.process_time() - start)


def routes() -> None:
    """Time routes between nodes drawn at random, and check their costs."""
    rng = np.random.default_rng(0)
    world = streets(rng)
    router = Router(world)
    twin: nx.Graph[int] = nx.Graph()
    twin.add_weighted_edges_from((edge.start, edge.end, edge.length) for edge in world.edges)
    ends = rng.integers(0, len(world.nodes), (ROUTES, 2)).tolist()
    router.route(*ends[0])
    ours = [cpu_ms(partial(router.route, *pair)) for pair in ends]
    plain = [cpu_ms(partial(nx.dijkstra_path, twin, *pair)) for pair in ends[:20]]
    for start, end in ends[:20]:
        best = nx.dijkstra_path_length(twin, start, end)
        assert abs(router.route(start, end).cost - best) < 1e-6
    share = np.median(ours) / np.median(plain)
    print(f"routes among {len(world.nodes)} nodes, CPU ms: median {np.median(ours):.3f}, ", end="")
    print(f"p95 {np.percentile(ours, 95):.3f}, most {max(ours):.3f}; networkx's Dijkstra ", end="")
    print(f"{np.median(plain):.1f} (x {1.0 / share:.0f})")


def buildings(data: Path) -> None:
    """Time the building of topological maps of recorded floors."""
    for file in sorted((data / "maps").glob("*.yaml")):
        if file.stem.count("."):
            continue
        world = load_map(file)
        build_topology(world, file.stem)
        ms = cpu_ms(partial(build_topology, world, file.stem))
        size = f"{world.geometry.rows} x {world.geometry.cols}"
        print(f"build {file.stem}, {size} cells: {ms / 1e3:.2f} s CPU")


if __name__ == "__main__":
    routes()
    buildings(Path(sys.argv[1] if len(sys.argv) > 1 else "../shared/datasets"))
