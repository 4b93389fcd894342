"""What a worker is asked: how to read a scan, as JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from rangeface.errors import ScanError, ScanFault
from rangeface.io import Limits, read_scan
from rangeface.types import Camera, Orthographic, Pinhole, RangeImage


@dataclass(frozen=True)
class Order:
    """How to read a scan, and what to make of it.

    Parameters
    ----------
    limits : Limits
        Of the readers.
    camera : Pinhole or Orthographic, optional
        In place of the scan's own.
    usual_camera : Pinhole or Orthographic, optional
        Where the scan brings none.
    unit, front, up : str, optional
        As in `read_scan`.
    augment : bool
        Make the template of an enrolment.
    keep : bool
        Give the frontal image as well.
    """

    limits: Limits
    camera: Camera | None = None
    usual_camera: Camera | None = None
    unit: str | None = None
    front: str | None = None
    up: str | None = None
    augment: bool = False
    keep: bool = False

    def to_json(self) -> dict[str, Any]:
        """What `order_from` takes back."""
        return asdict(self)

    def read(self, body: bytes) -> RangeImage:
        """The image of a scan."""
        try:
            return self._read(body, self.camera)
        except ScanError as error:
            if error.fault is not ScanFault.BAD_CAMERA or self.usual_camera is None:
                raise
        return self._read(body, self.usual_camera)

    def _read(self, body: bytes, camera: Camera | None) -> RangeImage:
        return read_scan(
            body, camera=camera, unit=self.unit, front=self.front, up=self.up,
            limits=self.limits,
        )  # fmt: skip


def order_from(fields: dict[str, Any]) -> Order:
    """The order that `Order.to_json` took apart."""
    cameras = {name: _camera(fields[name]) for name in ("camera", "usual_camera")}
    return Order(**{**fields, **cameras, "limits": Limits(**fields["limits"])})


def _camera(fields: dict[str, Any] | None) -> Camera | None:
    if fields is None:
        return None
    return Orthographic(**fields) if "pitch_mm" in fields else Pinhole(**fields)
