"""Adds up the JUnit reports of several pytest runs and ends with one line like pytest's own.

    python tests/total.py REPORT.xml ...

Exit code 1 when anything failed, or when a report holds no test at all.
"""

import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree as ET

WORDS = {"failures": "failed", "errors": "errors", "skipped": "skipped"}


def counted(report: Path) -> tuple[Counter[str], float]:
    """Return the outcomes of one run, by pytest's words, and its duration in seconds."""
    suite = ET.parse(report).getroot().find("testsuite")  # noqa: S314 - our own file
    if suite is None:
        return Counter(), 0.0
    outcomes = Counter({word: int(suite.get(name, 0)) for name, word in WORDS.items()})
    outcomes["passed"] = int(suite.get("tests", 0)) - outcomes.total()
    return outcomes, float(suite.get("time", 0.0))


def total_line(outcomes: Counter[str], seconds: float) -> str:
    """Return the summary as pytest words it."""
    order = ("failed", "errors", "passed", "skipped")
    parts = [f"{outcomes[word]} {word}" for word in order if outcomes[word]]
    return f"===== {', '.join(parts) or 'no tests ran'} in {seconds:.2f}s ====="


def main(reports: list[Path]) -> int:
    """Print the sum of all runs; return the exit code."""
    runs = [counted(report) for report in reports]
    outcomes = sum((outcome for outcome, _ in runs), Counter[str]())
    sys.stdout.write(total_line(outcomes, sum(seconds for _, seconds in runs)) + "\n")
    complete = bool(runs) and all(outcome.total() for outcome, _ in runs)
    return 0 if complete and not outcomes["failed"] and not outcomes["errors"] else 1


if __name__ == "__main__":
    sys.exit(main([Path(name) for name in sys.argv[1:]]))
