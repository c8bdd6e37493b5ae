"""Keyframes drawn together: what different passes saw of the same walls is laid on one another."""

from dataclasses import replace

import numpy as np

from pilotage.mapper.keyframes import KeyframeGraph
from pilotage.mapper.pose_edges import inverted
from pilotage.mapper.smoother import Chain, SmootherParams, smoothed, views_of


def refine_graph(graph: KeyframeGraph, params: SmootherParams, recent: int) -> None:
    """Move the poses so that points lie on walls seen at least `recent` keyframes before or after.

    What a keyframe and its neighbours saw is in the edges between them already. The graph must have
    been relaxed: only small moves are found.
    """
    numbers = list(graph.keyframes)
    if len(numbers) < 2:
        return
    edges = {edge.first: edge for edge in graph.edges if not edge.is_closure}
    way = [edges[number] for number in numbers[:-1]]
    chain = Chain(
        np.array([graph.poses[number] for number in numbers]),
        np.array([edge.relative for edge in way]),
        np.array([inverted(edge.covariance) for edge in way]),
    )
    views = views_of([graph.keyframes[number].points for number in numbers])
    poses, _ = smoothed(chain, views, replace(params, nearest=recent))
    graph.poses = dict(zip(numbers, poses, strict=True))
