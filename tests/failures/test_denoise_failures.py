"""Every Raises line of the stage `denoise`."""

import numpy as np
import pytest

from rangeface import denoise
from rangeface.denoise import combine
from rangeface.errors import ParameterError
from rangeface.types import Orthographic, RangeImage

IMAGE = RangeImage(np.full((8, 9), 500.0), Orthographic(2.0, 4, 4, 9, 8))
OTHER = RangeImage(np.full((8, 9), 500.0), Orthographic(2.5, 4, 4, 9, 8))


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        (denoise.median, {"size_px": 4}),
        (denoise.normalized_convolution, {"sigma_px": 0.0}),
        (denoise.normalized_convolution, {"sigma_px": float("nan")}),
        (denoise.normalized_convolution, {"max_step_mm": -1.0}),
        (denoise.normalized_convolution, {"min_support": 1.5}),
        (denoise.normalized_convolution, {"confidence": "trust"}),
        (denoise.flying_pixels, {"max_incidence_deg": 90.0}),
        (denoise.flying_pixels, {"min_neighbours": 9}),
        (denoise.flying_pixels, {"noise_factor": -1.0}),
    ],
)
def test_a_parameter_outside_its_range_is_named(method, parameters):
    (name,) = parameters
    with pytest.raises(ParameterError, match=name):
        method(IMAGE, **parameters)


@pytest.mark.parametrize("name", denoise.COMBINE)
def test_no_frame_at_all_is_refused(name):
    with pytest.raises(ParameterError, match="frames"):
        denoise.COMBINE[name]([], poses=[])


@pytest.mark.parametrize("name", denoise.COMBINE)
def test_frames_of_two_cameras_are_refused(name):
    from rangeface.types import RigidTransform

    still = [RigidTransform(np.eye(3), np.zeros(3))] * 2
    with pytest.raises(ParameterError, match="camera"):
        denoise.COMBINE[name]([IMAGE, OTHER], poses=still)


def test_a_frequency_that_is_not_positive_is_refused():
    with pytest.raises(ParameterError, match="frequency_hz"):
        combine.phasor_mean([IMAGE], frequency_hz=0.0)
