"""Face → Alignment: turn a face frontal, or refuse."""

from collections.abc import Callable

from rangeface.register import frontal
from rangeface.register._cloud import cloud
from rangeface.register._icp import icp
from rangeface.register._landmarks import landmarks
from rangeface.register._mirror import mirror
from rangeface.register._none import none
from rangeface.register._symmetric import symmetric
from rangeface.register.bootstrap import bootstrap
from rangeface.types import Alignment

#: name → method: Face → Alignment.
METHODS: dict[str, Callable[..., Alignment]] = {
    "icp": icp,
    "landmarks": landmarks,
    "mirror": mirror,
    "none": none,
    "symmetric": symmetric,
}

#: name → resampling: (Face, Alignment) → frontal image.
FRONTAL = {"resample": frontal.resample}

__all__ = [
    "FRONTAL",
    "METHODS",
    "bootstrap",
    "cloud",
    "frontal",
    "icp",
    "landmarks",
    "mirror",
    "none",
    "symmetric",
]
