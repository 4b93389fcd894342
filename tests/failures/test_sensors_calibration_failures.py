"""A calibration refuses what it cannot use."""

import numpy as np
import pytest

from rangeface import sensors
from rangeface.errors import DegenerateError, ParameterError, ScanError, ScanFault
from rangeface.sensors import Calibration
from rangeface.types import Pinhole, RangeImage

CAMERA = Pinhole(50.0, 50.0, 3.5, 2.5, 8, 6)


def plane(depth):
    return RangeImage(np.full((6, 8), depth), CAMERA)


def test_distances_must_match_the_frames():
    with pytest.raises(ParameterError, match="distances_mm"):
        sensors.calibrate([plane(400.0), plane(500.0)], [400.0])


def test_knots_need_a_spacing():
    with pytest.raises(ParameterError, match="knot_mm"):
        sensors.calibrate([plane(400.0), plane(500.0)], [400.0, 500.0], knot_mm=0.0)


def test_one_distance_is_not_enough():
    with pytest.raises(DegenerateError, match="two distances"):
        sensors.calibrate([plane(400.0)], [400.0])


def test_empty_frames_determine_nothing():
    with pytest.raises(DegenerateError, match="no pixel"):
        sensors.calibrate([plane(np.nan), plane(np.nan)], [400.0, 500.0])


def test_an_image_of_another_size_is_refused():
    made = sensors.calibrate([plane(402.0), plane(503.0)], [400.0, 500.0])
    small = RangeImage(np.full((2, 2), 400.0), Pinhole(50.0, 50.0, 0.5, 0.5, 2, 2))
    with pytest.raises(ParameterError, match="image"):
        made.apply(small)


def test_a_missing_file_and_one_that_is_no_calibration(tmp_path):
    with pytest.raises(ScanError) as caught:
        Calibration.load(tmp_path / "none.npz")
    assert caught.value.fault is ScanFault.MISSING
    (tmp_path / "text.npz").write_text("not an archive")
    np.savez(tmp_path / "other.npz", a=1)
    for name in ("text.npz", "other.npz"):
        with pytest.raises(ScanError) as caught:
            Calibration.load(tmp_path / name)
        assert caught.value.fault is ScanFault.MALFORMED
