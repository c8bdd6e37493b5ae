"""The state of all services in Prometheus' text format."""

from collections.abc import Iterator

from pilotage.gateway.service import GatewayService
from pilotage_schemas.health import Deployment, Health
from pilotage_schemas.planning import PlanningStatus

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"

Labels = dict[str, str]
Samples = list[tuple[Labels, float]]


def exposition(service: GatewayService) -> str:
    """Return every metric with its help line."""
    return "".join(_lines(service))


def _lines(service: GatewayService) -> Iterator[str]:
    yield _metric("up", "gauge", "the gateway runs", [({}, 1.0)])
    yield _metric("link_up", "gauge", "the bus is connected", [({}, float(service.is_linked))])
    yield _metric("streams", "gauge", "open live streams", [({}, float(service.hub.count))])
    yield from _of_services(service)
    yield from _of_topics(service)
    yield from _of_processes(service)
    yield from _of_planning(service)
    yield from _of_latency(service)


def _healths(service: GatewayService) -> list[tuple[str, Health]]:
    sources = service.state.sources("health")
    return [(n, r.message) for n, r in sources.items() if isinstance(r.message, Health)]


def _of_services(service: GatewayService) -> Iterator[str]:
    healths = _healths(service)
    for name, kind, text, value in (
        ("service_uptime_seconds", "gauge", "since the service started", lambda h: h.uptime),
        ("service_cpu_percent", "gauge", "of one core", lambda h: h.cpu_percent),
        ("service_resident_bytes", "gauge", "peak memory", lambda h: h.rss_mb * 1024.0 * 1024.0),
        ("service_dropped_total", "counter", "messages refused", lambda h: float(h.dropped)),
    ):
        yield _metric(name, kind, text, [({"service": s}, value(h)) for s, h in healths])


def _of_topics(service: GatewayService) -> Iterator[str]:
    lines = [
        ({"service": name, "topic": line.topic, "direction": line.direction}, line)
        for name, health in _healths(service)
        for line in health.topics
    ]
    for name, kind, text, value in (
        ("messages_total", "counter", "messages of a topic", lambda t: float(t.count)),
        ("messages_dropped_total", "counter", "refused ones", lambda t: float(t.dropped)),
        ("message_rate_hertz", "gauge", "over the last second", lambda t: t.rate_hz),
    ):
        yield _metric(name, kind, text, [(labels, value(line)) for labels, line in lines])


def _of_processes(service: GatewayService) -> Iterator[str]:
    received = service.state.newest("deployment")
    if received is None or not isinstance(received.message, Deployment):
        return
    processes = received.message.processes
    for name, kind, text, value in (
        ("process_up", "gauge", "ready or late", lambda p: float(p.state in ("ready", "late"))),
        ("process_restarts_total", "counter", "restarts by the launcher", lambda p: p.restarts),
    ):
        yield _metric(name, kind, text, [({"service": p.name}, float(value(p))) for p in processes])


def _of_planning(service: GatewayService) -> Iterator[str]:
    received = service.state.newest("planning_status")
    if received is None or not isinstance(received.message, PlanningStatus):
        return
    status = received.message
    is_driving = status.mode in ("going", "localizing")
    yield _metric("planner_drives", "gauge", "the planner drives", [({}, float(is_driving))])
    if status.decision_ms is not None:
        seconds = status.decision_ms / 1e3
        yield _metric("planner_decision_seconds", "gauge", "of the last one", [({}, seconds)])


def _of_latency(service: GatewayService) -> Iterator[str]:
    samples: Samples = []
    for topic, latency in service.state.latency.all().items():
        samples.append(({"topic": topic, "quantile": "0.5"}, latency.p50_ms / 1e3))
        samples.append(({"topic": topic, "quantile": "0.99"}, latency.p99_ms / 1e3))
    yield _metric("latency_seconds", "gauge", "from measurement to gateway", samples)


def _metric(name: str, kind: str, text: str, samples: Samples) -> str:
    full = f"pilotage_{name}"
    head = f"# HELP {full} {text}\n# TYPE {full} {kind}\n"
    return head + "".join(f"{full}{_labels(labels)} {value:.10g}\n" for labels, value in samples)


def _labels(labels: Labels) -> str:
    inside = ",".join(f'{name}="{_escaped(value)}"' for name, value in labels.items())
    return f"{{{inside}}}" if inside else ""


def _escaped(value: str) -> str:
    return value.replace("\\", r"\\").replace("\n", r"\n").replace('"', r"\"")
