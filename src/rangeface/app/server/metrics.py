"""Counters and times in the text format of Prometheus."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping
from threading import Lock

MEDIA_TYPE = "text/plain; version=0.0.4; charset=utf-8"

_BOUNDS_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)


class Metrics:
    """What happened since the start; labels are routes, never names."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._requests: Counter[tuple[str, str, int]] = Counter()
        self._decisions: Counter[tuple[str, str]] = Counter()
        self._buckets: dict[str, list[int]] = {}
        self._sums: Counter[str] = Counter()

    def request(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count an answered request."""
        with self._lock:
            self._requests[method, route, status] += 1
            counts = self._buckets.setdefault(route, [0] * (len(_BOUNDS_S) + 1))
            counts[bisect_left(_BOUNDS_S, seconds)] += 1
            self._sums[route] += seconds  # type: ignore[assignment]

    def decision(self, kind: str, verdict: str) -> None:
        """Count a decision."""
        with self._lock:
            self._decisions[kind, verdict] += 1

    def text(self, gauges: Mapping[str, float]) -> str:
        """Everything, and the gauges."""
        with self._lock:
            return "\n".join(self._lines(gauges)) + "\n"

    def _lines(self, gauges: Mapping[str, float]) -> Iterator[str]:
        yield "# TYPE rangeface_requests_total counter"
        for (method, route, status), count in sorted(self._requests.items()):
            labels = f'method="{method}",route="{route}",status="{status}"'
            yield f"rangeface_requests_total{{{labels}}} {count}"
        yield "# TYPE rangeface_decisions_total counter"
        for (kind, verdict), count in sorted(self._decisions.items()):
            yield f'rangeface_decisions_total{{kind="{kind}",verdict="{verdict}"}} {count}'
        yield "# TYPE rangeface_request_seconds histogram"
        for route, counts in sorted(self._buckets.items()):
            below = 0
            for bound, count in zip((*map(str, _BOUNDS_S), "+Inf"), counts, strict=True):
                below += count
                yield f'rangeface_request_seconds_bucket{{route="{route}",le="{bound}"}} {below}'
            yield f'rangeface_request_seconds_sum{{route="{route}"}} {self._sums[route]:.6f}'
            yield f'rangeface_request_seconds_count{{route="{route}"}} {below}'
        for name, value in gauges.items():
            yield f"# TYPE rangeface_{name} gauge"
            yield f"rangeface_{name} {value:g}"
