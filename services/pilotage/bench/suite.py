"""All cases in order: first those whose peak of memory is measured, from small to large."""

from collections.abc import Callable, Iterator

from pilotage.bench.building_cases import AREAS, growth_cases, office_cases
from pilotage.bench.ekf_cases import ekf_cases
from pilotage.bench.entry import Entry, Stopwatch
from pilotage.bench.grid_cases import exact_posterior_case, hall_case
from pilotage.bench.line_cases import line_cases
from pilotage.bench.mapping_cases import mapping_cases
from pilotage.bench.particle_cases import COUNTS, particle_cases
from pilotage.bench.planner_cases import planner_cases

ENTRIES = 1 + 3 * len(AREAS) + 4 + 2 * len(COUNTS) + 3 + 2 + 2 + 1
"""How many entries there are, for a progress bar."""


def run_suite(watch: Stopwatch, peak_mb: Callable[[], float]) -> Iterator[Entry]:
    """Yield every entry as it is measured.

    Args:
        watch: of processor time.
        peak_mb: the most memory that the process has had so far.
    """
    yield from growth_cases(watch, peak_mb)
    yield from hall_case(watch)
    yield from office_cases(watch)
    yield from particle_cases(watch)
    yield from mapping_cases(watch)
    yield from planner_cases(watch)
    yield from line_cases(watch)
    yield from ekf_cases(watch)
    yield from exact_posterior_case(watch)
