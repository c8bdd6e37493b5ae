"""Machine code for what the localizer calculates, made or loaded before a robot waits for it."""

from pilotage.core import distance_field, line_extraction, map_lines, range_table
from pilotage.localizer import (
    evidence_kernels,
    kernels,
    landmark_kernels,
    landmark_tile_kernels,
    line_ekf_kernels,
    particle_kernels,
    peaks,
)


def warm_up() -> None:
    """Compile all kernels, or load them: half a minute after a change, else half a second."""
    for module in (
        distance_field,
        range_table,
        line_extraction,
        map_lines,
        line_ekf_kernels,
        kernels,
        particle_kernels,
        landmark_kernels,
        landmark_tile_kernels,
        evidence_kernels,
        peaks,
    ):
        module.warm_up()
