"""D-III, unknown start in a corridor with alike doors (Zhuang et al. 2005, section 3.2)."""

from collections.abc import Callable, Sequence

import numpy as np

from pilotage.experiments.corridor_doors import Spacing
from pilotage.experiments.node_chain_plots import nodes_figure, start_figure
from pilotage.experiments.node_chain_trial import (
    LENGTH,
    MOST_NODES,
    PEOPLE,
    ChainPlace,
    Start,
    start_anywhere,
)
from pilotage.experiments.outcome import Outcome, Request

SPACINGS: tuple[Spacing, ...] = ("irregular", "modular", "regular")
"""Doors at any distance; at multiples of 1.2 m; all alike, where nothing can be known."""

BUILDINGS = 5
"""Corridors of each spacing, which the starts take in turns."""

FEWER = 5
"""So many times fewer starts where the corridor is regular: each is driven to its end."""


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Put the robot down anywhere, as often as asked, in each corridor."""
    places = {spacing: _buildings(spacing, request) for spacing in SPACINGS}
    starts = {
        spacing: _starts(places[spacing], request, lambda share: advance(share / len(SPACINGS)))
        for spacing in SPACINGS
    }
    report = {
        "length_m": LENGTH,
        "buildings": BUILDINGS,
        "most_nodes": MOST_NODES,
        "people": PEOPLE,
    }
    others = {spacing: start_figures(starts[spacing]) for spacing in SPACINGS[1:]}
    modular = starts["modular"]
    longest = max(range(len(modular)), key=lambda run: len(modular[run].steps))
    return Outcome(
        report | start_figures(starts["irregular"]) | others,
        {
            "node-chain": nodes_figure(starts),
            "node-chain-irregular": start_figure(
                places["irregular"][0], starts["irregular"][0], "irregular doors: the first start"
            ),
            "node-chain-modular": start_figure(
                places["modular"][longest % BUILDINGS],
                modular[longest],
                "doors in modules: the start that took most nodes",
            ),
        },
    )


def _buildings(spacing: Spacing, request: Request) -> list[ChainPlace]:
    return [ChainPlace.of(spacing, BUILDINGS * request.seed + k) for k in range(BUILDINGS)]


def _starts(
    places: Sequence[ChainPlace], request: Request, advance: Callable[[float], None]
) -> list[Start]:
    is_regular = places[0].spacing == "regular"
    runs = max(request.runs // FEWER, 1) if is_regular else request.runs
    starts = []
    for run in range(runs):
        rng = np.random.default_rng([request.seed, SPACINGS.index(places[0].spacing), run])
        starts.append(start_anywhere(places[run % BUILDINGS], rng))
        advance(1.0 / runs)
    return starts


def start_figures(starts: Sequence[Start]) -> dict[str, object]:
    """Return how many starts ended on the right node, and after how many nodes."""
    by_verdict = {
        verdict: [start for start in starts if start.verdict == verdict]
        for verdict in ("right", "wrong", "unknown")
    }
    nodes = [len(start.steps) for start in by_verdict["right"]]
    ways = [start.way for start in by_verdict["right"]]
    return {
        "starts": len(starts),
        "correct_node": len(by_verdict["right"]),
        "wrong_node": len(by_verdict["wrong"]),
        "still_unknown": len(by_verdict["unknown"]),
        "success_rate": len(by_verdict["right"]) / len(starts),
        "nodes_needed": nodes,
        "nodes_needed_median": float(np.median(nodes)) if nodes else None,
        "nodes_needed_p95": float(np.percentile(nodes, 95.0)) if nodes else None,
        "way_needed_m_median": round(float(np.median(ways)), 2) if ways else None,
    }
