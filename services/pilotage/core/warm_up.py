"""Compiles every kernel once, so that no service pays for it while a robot waits.

Run by deploy/setup as `python -m pilotage.core.warm_up`. Each module with kernels has a function
that calls them on the smallest input of the types they meet in service; here is the list.
"""

from importlib import import_module

WARM_UPS = [
    "pilotage.core.cell_traversal:warm_up",
    "pilotage.core.range_table:warm_up",
    "pilotage.core.distance_field:warm_up",
    "pilotage.core.line_extraction:warm_up",
    "pilotage.core.map_lines:warm_up",
    "pilotage.robot.simulator.picture_kernels:warm_up",
    "pilotage.localizer.kernels:warm_up",
    "pilotage.localizer.particle_kernels:warm_up",
    "pilotage.localizer.landmark_kernels:warm_up",
    "pilotage.localizer.landmark_tile_kernels:warm_up",
    "pilotage.localizer.evidence_kernels:warm_up",
    "pilotage.localizer.line_ekf_kernels:warm_up",
    "pilotage.localizer.peaks:warm_up",
    "pilotage.mapper.warm_up:warm_up",
    "pilotage.planner.information:warm_up",
    "pilotage.planner.hypotheses:warm_up",
    "pilotage.planner.expected_scans:warm_up",
    "pilotage.planner.common_ground:warm_up",
    "pilotage.planner.map_potential:warm_up",
    "pilotage.planner.landmark_sight:warm_up",
    "pilotage.planner.path_kernels:warm_up",
    "pilotage.topology.warm_up:warm_up",
]
"""`module:function`, by name because core lies below the services and may not import them."""


def main() -> None:
    """Call them all."""
    for entry in WARM_UPS:
        module, function = entry.split(":")
        getattr(import_module(module), function)()


if __name__ == "__main__":
    main()
