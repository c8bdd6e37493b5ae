"""Keyframes, edges and the way as arrays by name, for snapshots, and back."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.keyframes import Keyframe, KeyframeGraph
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.pose_edges import Edge
from pilotage.mapper.track import Track

Arrays = dict[str, NDArray[np.generic]]
Kind = TypeVar("Kind", bound=np.generic)


@contextmanager
def refusing_misfits() -> Iterator[None]:
    """Say ValueError of arrays that are not those of laser mapping."""
    try:
        yield
    except (KeyError, IndexError, StopIteration) as error:
        raise ValueError(f"this is no memory of laser mapping: {error}") from error


def packed(graph: KeyframeGraph, track: Track) -> Arrays:
    """Return a graph and the way through it."""
    way = {f"track.{name}": array for name, array in track.state().items()}
    return way | packed_graph(graph)


def unpack(memory: Arrays, graph: KeyframeGraph, track: Track) -> None:
    """Fill an empty graph and an empty way; KeyError or ValueError if the arrays are not theirs."""
    unpack_graph(memory, graph)
    track.resume({name: memory[f"track.{name}"].astype(float) for name in ("scans", "odometry")})


def packed_graph(graph: KeyframeGraph) -> Arrays:
    """Return keyframes, poses and edges; points as 32-bit floats, good to a micrometre."""
    keyframes = list(graph.keyframes.values())
    scans = [scan for keyframe in keyframes for scan in keyframe.scans]
    edges = graph.edges
    replaced = [(key, other, *pose.tolist()) for key, (other, pose) in graph.replaced.items()]
    return {
        "numbers": np.array(list(graph.keyframes), np.int64),
        "stamps": np.array([keyframe.stamp for keyframe in keyframes]),
        "poses": np.array(list(graph.poses.values())).reshape(-1, 3),
        "points": _stacked([keyframe.points for keyframe in keyframes]),
        "point_counts": np.array([len(keyframe.points) for keyframe in keyframes], np.int64),
        "scan_counts": np.array([len(keyframe.scans) for keyframe in keyframes], np.int64),
        "scan_stamps": np.array([np.nan if s.stamp is None else s.stamp for s in scans]),
        "lasers": np.array([scan.laser for scan in scans]).reshape(-1, 2),
        "ends": _stacked([scan.ends for scan in scans]),
        "is_hit": np.concatenate([np.empty(0, np.bool_), *(scan.is_hit for scan in scans)]),
        "end_counts": np.array([len(scan.ends) for scan in scans], np.int64),
        "edge_ends": np.array([edge.ends for edge in edges], np.int64).reshape(-1, 2),
        "edge_relatives": np.array([edge.relative for edge in edges]).reshape(-1, 3),
        "edge_covariances": np.array([edge.covariance for edge in edges]).reshape(-1, 3, 3),
        "edge_closures": np.array([edge.is_closure for edge in edges], np.bool_),
        "replaced": np.array(replaced, np.float64).reshape(-1, 5),
    }


def unpack_graph(memory: Arrays, graph: KeyframeGraph) -> None:
    """Fill an empty graph; KeyError or ValueError if the arrays are not those of a graph."""
    scans = iter(_scans(memory))
    counts = zip(memory["scan_counts"].tolist(), memory["stamps"].tolist(), strict=True)
    points = _split(memory["points"], memory["point_counts"])
    numbers = memory["numbers"].tolist()
    for number, (count, stamp), seen in zip(numbers, counts, points, strict=True):
        graph.keyframes[number] = Keyframe(stamp, seen, tuple(next(scans) for _ in range(count)))
    graph.poses = dict(zip(numbers, memory["poses"].astype(float), strict=True))
    graph.edges = [
        Edge(first, second, relative, covariance, bool(is_closure))
        for (first, second), relative, covariance, is_closure in zip(
            memory["edge_ends"].tolist(),
            memory["edge_relatives"].astype(float),
            memory["edge_covariances"].astype(float),
            memory["edge_closures"].tolist(),
            strict=True,
        )
    ]
    for row in memory["replaced"].astype(float):
        graph.replaced[int(row[0])] = int(row[1]), row[2:5].copy()


def _scans(memory: Arrays) -> list[DrawnScan]:
    ends = _split(memory["ends"], memory["end_counts"])
    hits = _pieces(memory["is_hit"].astype(np.bool_), memory["end_counts"])
    stamps = memory["scan_stamps"].tolist()
    lasers = memory["lasers"].astype(float)
    return [
        DrawnScan(None if np.isnan(stamp) else stamp, laser, end, hit)
        for stamp, laser, end, hit in zip(stamps, lasers, ends, hits, strict=True)
    ]


def _stacked(parts: list[NDArray[np.float64]]) -> NDArray[np.float32]:
    return np.concatenate([np.empty((0, 2)), *parts]).astype(np.float32)


def _split(stacked: NDArray[np.generic], counts: NDArray[np.generic]) -> list[NDArray[np.float64]]:
    return _pieces(stacked.astype(np.float64), counts)


def _pieces(stacked: NDArray[Kind], counts: NDArray[np.generic]) -> list[NDArray[Kind]]:
    """Return the parts of an array, so many rows each; none if there are no counts."""
    return np.split(stacked, np.cumsum(counts)[:-1]) if len(counts) else []
