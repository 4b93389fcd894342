"""The scan of a request: a raw body, and in the query what its format leaves open."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import Query, Request
from pydantic import BaseModel, Field

from rangeface.app.server import bodies
from rangeface.app.server.orders import Order
from rangeface.app.server.problems import Cause, RefusalError
from rangeface.app.server.service import Service
from rangeface.types import Camera, Orthographic, Pinhole

Length = Annotated[float, Field(gt=1e-3, lt=1e6)]
Place = Annotated[float, Field(gt=-1e6, lt=1e6)]
Pixels = Annotated[int, Field(ge=1, le=8192)]
Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


class ScanQuery(BaseModel):
    """What a scan's format leaves open; a camera is given whole or not at all."""

    unit: Literal["um", "0.1mm", "mm", "cm", "m", "in"] | None = Field(
        default=None, description="Unit of the lengths, where the format states none."
    )
    front: Axis | None = Field(default=None, description="Axis of a mesh towards the viewer.")
    up: Axis | None = Field(default=None, description="Axis of a mesh towards the crown.")
    width: Pixels | None = Field(default=None, description="Width of the image, px.")
    height: Pixels | None = Field(default=None, description="Height of the image, px.")
    fx: Length | None = Field(default=None, description="Focal length, px.")
    fy: Length | None = Field(default=None, description="Focal length, px.")
    cx: Place | None = Field(default=None, description="Principal point, px.")
    cy: Place | None = Field(default=None, description="Principal point, px.")
    pitch_mm: Length | None = Field(
        default=None, description="Pixel of an orthographic image, mm, in place of fx and fy."
    )

    def camera(self) -> Camera | None:
        """The camera, if one is given.

        Raises
        ------
        RefusalError
            A part of it is missing.
        """
        names = ["cx", "cy", "width", "height"]
        names[:0] = ["fx", "fy"] if self.pitch_mm is None else ["pitch_mm"]
        values: dict[str, Any] = {name: getattr(self, name) for name in names}
        if all(value is None for value in values.values()):
            return None
        missing = [name for name, value in values.items() if value is None]
        if missing:
            raise RefusalError(Cause.BAD_PARAMETER, f"a camera needs {', '.join(missing)}, too")
        return Pinhole(**values) if self.pitch_mm is None else Orthographic(**values)


Scan = Annotated[ScanQuery, Query()]

#: The OpenAPI entry of a route that takes a scan.
BODY = {
    "requestBody": {
        "required": True,
        "description": "The scan file's bytes, in any format that `rangeface info` reads.",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}

#: Why a scan may be refused.
CAUSES = (
    Cause.BAD_PARAMETER,
    Cause.BODY_TOO_LARGE,
    Cause.BODY_TOO_SLOW,
    Cause.SCAN_REFUSED,
    Cause.SCAN_TOO_SLOW,
    Cause.BUSY,
)


async def receive(
    request: Request, service: Service, query: ScanQuery, *, augment: bool = False
) -> tuple[bytes, Order]:
    """The request's body, and how a worker is to read it.

    Raises
    ------
    RefusalError
        The body is too large or too slow, or the camera is not whole.
    """
    settings = service.settings
    order = Order(
        settings.limits, query.camera(), settings.camera, query.unit or settings.unit,
        query.front, query.up, augment, augment and settings.keep_frontal,
    )  # fmt: skip
    most, seconds = settings.max_body_bytes, settings.body_s
    return await bodies.read(request, most=most, seconds=seconds), order
