"""Ages of messages at the page, and the load of every process, in the running demo.

    .venv/bin/python tests/benchmarks/page_and_load.py [SECONDS]

Starts deploy/config/demo.yaml, waits until the robot is localized, and measures for SECONDS (60)
while it wanders, for half as long after it was carried off, and for SECONDS while it stands. An
age is the time from a message's stamp (of the measurement that it speaks of) to its arrival at
a WebSocket client of the gateway, by the same clock. Load is processor time, as a share of one
core.
"""

import os
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import cbor2
import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from websockets.sync.client import connect  # noqa: E402 - after the path

import processes  # noqa: E402 - after the path
from pages import Page  # noqa: E402 - after the path
from runs import Run  # noqa: E402 - after the path
from waiting import eventually  # noqa: E402 - after the path

TOPICS = ("pose", "belief", "scan", "odometry")
START_S = 120.0
SETTLE_S = 1.0
TICKS_A_SECOND = os.sysconf("SC_CLK_TCK")


def processor_time(pid: int) -> float:
    """Return the processor time [s] that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_A_SECOND


def pids(run: Run, page: Page) -> dict[str, int]:
    """Return the process id of the launcher and of everything that it runs."""
    deployment = page.get("deployment")
    assert deployment is not None
    return {one["name"]: one["pid"] for one in deployment["processes"]} | {"launcher": run.pid}


def ages_at_page(port: int, seconds: float) -> dict[str, list[float]]:
    """Follow the live stream for some time; return the ages [ms] of each topic's messages."""
    ages: dict[str, list[float]] = defaultdict(list)
    address = f"ws://127.0.0.1:{port}/api/v1/robots/demo/stream?topics={','.join(TOPICS)}"
    with connect(address, max_size=None) as stream:
        began = time.monotonic()
        while time.monotonic() - began < seconds + SETTLE_S:
            message = cbor2.loads(stream.recv(decode=False))
            now_ns = time.time_ns()
            # What the gateway held when the stream began is older than the stream.
            if message["topic"] in TOPICS and time.monotonic() - began > SETTLE_S:
                stamp_ns = cbor2.loads(message["payload"])["stamp_ns"]
                ages[message["topic"]].append((now_ns - stamp_ns) / 1e6)
    return ages


def measure(case: str, run: Run, page: Page, port: int, seconds: float) -> None:
    """Print ages and load over some time."""
    names = pids(run, page)
    before, began = {n: processor_time(pid) for n, pid in names.items()}, time.monotonic()
    ages = ages_at_page(port, seconds)
    lasted = time.monotonic() - began
    load = {n: 100.0 * (processor_time(pid) - before[n]) / lasted for n, pid in names.items()}
    print(f"\n{case}, {seconds:.0f} s, load of the machine {os.getloadavg()[0]:.1f}")
    print("| topic | messages | p50 ms | p90 ms | p99 ms | max ms |")
    print("| --- | --- | --- | --- | --- | --- |")
    for topic in TOPICS:
        if ages[topic]:
            figures = np.percentile(ages[topic], (50, 90, 99, 100))
            told = " | ".join(f"{figure:.1f}" for figure in figures)
            print(f"| {topic} | {len(ages[topic])} | {told} |")
    told = ", ".join(f"{n} {share:.1f} %" for n, share in sorted(load.items(), key=lambda x: -x[1]))
    print(f"share of one core: {told}; {sum(load.values()):.0f} % in all")


def main(seconds: float) -> None:
    """Measure wandering, carried off, standing."""
    port = processes.free_port()
    demo = str(REPOSITORY / "deploy" / "config" / "demo.yaml")
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["up", demo, "--no-browser", "--port", str(port)]
        with Run("pilotage", arguments, Path(folder)) as run, Page(port) as page:
            eventually(lambda: page.answers("/healthz"), START_S, "/healthz")
            began = time.monotonic()
            page.localized(START_S)
            print(*(line for line in run.lines if "ready after" in line), sep="\n")
            print(f"localized after {time.monotonic() - began:.1f} s")
            measure("wandering", run, page, port, seconds)
            page.command("kidnap")
            measure("carried off, searching at first", run, page, port, seconds / 2.0)
            page.command("stop")
            measure("standing", run, page, port, seconds)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
