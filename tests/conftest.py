"""What several tests share: simulated captures, and the folder of real ones where there is one."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from rangeface import sensors, simulate
from rangeface.types import RangeImage, RigidTransform

# A change is judged by the same cases before and after; new ones: --hypothesis-profile=default.
settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")

#: They write the golden values, and need the libraries that these come from.
collect_ignore_glob = ["cross/make_*.py"]


@lru_cache(maxsize=32)
def sr3000_face(
    person: int = 3, *, yaw: float = 0.0, pitch: float = 0.0, session: int = 0, noise: int = 0
) -> tuple[RangeImage, RigidTransform]:
    """A head before a calibrated SR-3000 at 40 cm (random noise only), and its true pose."""
    sensor = sensors.preset("sr3000").without(
        "wiggling", "multipath", "scattering", "fixed pattern", "compression"
    )
    pose = simulate.pose(yaw_deg=yaw, pitch_deg=pitch, nose_tip_mm=(4.0, -6.0, 400.0))
    scene = simulate.render(simulate.head(person, session=session), sensor.camera, pose)
    return simulate.tof(scene, sensor, rng=np.random.default_rng(noise)), pose


@pytest.fixture(scope="session")
def face() -> tuple[RangeImage, RigidTransform]:
    return sr3000_face()


@pytest.fixture(scope="session")
def data_folder() -> Path:
    folder = Path(os.environ.get("RANGEFACE_DATA", Path(__file__).parents[1] / "../shared/data"))
    if not folder.is_dir():
        pytest.skip(f"no data at {folder}; set RANGEFACE_DATA")
    return folder.resolve()
