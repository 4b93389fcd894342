"""What an operator may set, each with a safe default."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rangeface.errors import ParameterError
from rangeface.io import Limits
from rangeface.types import Camera

_MIB = 1 << 20


@dataclass(frozen=True)
class Settings:
    """Limits and habits of the service.

    Parameters
    ----------
    keys : Path
        File of the keys, made with one random key of every scope where it is missing.
    fmr : float
        Accepted false match rate of one comparison.
    camera : Pinhole or Orthographic, optional
        Of depth images that bring none.
    unit : str, optional
        Of scans whose request states none, where their format does not.
    hosts : tuple of str
        Names under which browsers may address the service (against DNS rebinding).
    keep_frontal : bool
        Store the frontal image of everybody who is enrolled, sealed, so that the gallery can be
        rebuilt for another model.
    max_body_bytes : int
        Largest scan, bytes.
    body_s : float
        A body must have arrived within this time, s.
    header_s : float
        A request's head must have arrived within this time, s.
    scan_s : float
        A scan must have become a template within this time, s.
    workers : int
        Processes that read scans.
    queue : int
        Scans that may wait for a worker; more are answered "busy".
    requests_per_s, burst : float
        Rate limit of a key: a bucket of `burst` requests, refilled at this rate.
    max_connections : int
        Connections at a time.
    failures : int
        Failed attempts in a row before a pause.
    pause_s : float
        The pause, s.
    stop : int
        Failed attempts in a row after which only an operator opens the way again.
    limits : Limits
        Of the scan readers.

    Raises
    ------
    ParameterError
        A limit is not positive, or the false match rate is not between 0 and 1.
    """

    keys: Path
    fmr: float = 0.001
    camera: Camera | None = None
    unit: str | None = None
    hosts: tuple[str, ...] = ("127.0.0.1", "localhost", "[::1]")
    keep_frontal: bool = False
    max_body_bytes: int = 32 * _MIB
    body_s: float = 20.0
    header_s: float = 10.0
    scan_s: float = 10.0
    workers: int = 2
    queue: int = 32
    requests_per_s: float = 50.0
    burst: float = 100.0
    max_connections: int = 256
    failures: int = 5
    pause_s: float = 30.0
    stop: int = 50
    limits: Limits = field(default_factory=lambda: Limits(max_bytes=64 * _MIB))

    def __post_init__(self) -> None:
        if not 0 < self.fmr < 1:
            raise ParameterError(f"fmr must be between 0 and 1, got {self.fmr}")
        for name, value in vars(self).items():
            if isinstance(value, int | float) and not isinstance(value, bool) and not value > 0:
                raise ParameterError(f"{name} must be > 0, got {value}")
