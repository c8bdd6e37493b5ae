"""The graph of poses and its optimisation with GTSAM (Dellaert 2012).

Why GTSAM: see the mapper's README. Only this module knows it.
"""

from dataclasses import dataclass

import gtsam
import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.pose_edges import Edge, mismatch

Poses = dict[int, NDArray[np.float64]]


@dataclass(frozen=True)
class GraphParams:
    """How the graph is relaxed."""

    doubts: tuple[float, ...] = (30.0, 8.0, 2.0)
    """Standard deviations beyond which a closure counts less and less (Geman-McClure), relaxed one
    after the other: a loop may close over a long way off, and a wrong one has no hold in the end
    (graduated non-convexity, Yang et al. 2020)."""
    wrong: float = 6.0
    """Standard deviations by which a closure that contradicts all others is wrong."""
    iterations: int = 20
    """At most so many steps of Levenberg and Marquardt each."""


def optimise(poses: Poses, edges: list[Edge], params: GraphParams) -> tuple[Poses, set[int]]:
    """Return the most probable poses, the first one held, and which edges are wrong closures."""
    settings = gtsam.LevenbergMarquardtParams()
    settings.setMaxIterations(params.iterations)
    values = gtsam.Values()
    for key, pose in poses.items():
        values.insert(key, gtsam.Pose2(*pose))
    first = min(poses)
    for doubt in params.doubts if any(edge.is_closure for edge in edges) else (1.0,):
        graph = _graph(edges, doubt)
        graph.add(gtsam.NonlinearEqualityPose2(first, gtsam.Pose2(*poses[first])))
        values = gtsam.LevenbergMarquardtOptimizer(graph, values, settings).optimize()
    solved = {key: _array(values.atPose2(key)) for key in poses}
    return solved, {k for k, edge in enumerate(edges) if _is_wrong(edge, solved, params)}


def _is_wrong(edge: Edge, poses: Poses, params: GraphParams) -> bool:
    if not edge.is_closure:
        return False
    return mismatch(edge, poses[edge.first], poses[edge.second]) > params.wrong


def _graph(edges: list[Edge], doubt: float) -> gtsam.NonlinearFactorGraph:
    graph = gtsam.NonlinearFactorGraph()
    robust = gtsam.noiseModel.mEstimator.GemanMcClure.Create(doubt)
    for edge in edges:
        certain = gtsam.noiseModel.Gaussian.Covariance(edge.covariance)
        noise = gtsam.noiseModel.Robust.Create(robust, certain) if edge.is_closure else certain
        relative = gtsam.Pose2(*edge.relative)
        graph.add(gtsam.BetweenFactorPose2(edge.first, edge.second, relative, noise))
    return graph


def _array(pose: gtsam.Pose2) -> NDArray[np.float64]:
    return np.array([pose.x(), pose.y(), pose.theta()])
