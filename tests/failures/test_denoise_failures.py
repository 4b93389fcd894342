"""Every Raises line of the stage `denoise`."""

import numpy as np
import pytest

from rangeface import denoise
from rangeface.denoise import combine
from rangeface.errors import ParameterError
from rangeface.types import Orthographic, RangeImage, RigidTransform

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
        (denoise.dwt, {"wavelet": "db99"}),
        (denoise.dwt, {"levels": 0}),
        (denoise.dwt, {"shrinkage": "hard"}),
        (denoise.dwt, {"threshold_sigma": -1.0}),
        (denoise.dwt, {"threshold_mm": float("inf")}),
        (denoise.dtcwt, {"levels": 0}),
        (denoise.dtcwt, {"first": "haar"}),
        (denoise.dtcwt, {"further": "db4"}),
        (denoise.dtcwt, {"shrinkage": "hard"}),
        (denoise.dtcwt, {"threshold_sigma": float("nan")}),
        (denoise.dtcwt, {"threshold_mm": -0.1}),
        (denoise.bilateral, {"sigma_px": 0.0}),
        (denoise.bilateral, {"range_factor": -1.0}),
        (denoise.guided, {"radius_px": 0}),
        (denoise.guided, {"smoothness": 0.0}),
        (denoise.non_local_means, {"strength": 0.0}),
        (denoise.non_local_means, {"patch_px": 4}),
        (denoise.non_local_means, {"search_px": 1}),
        (denoise.total_variation, {"strength": -1.0}),
        (denoise.total_variation, {"iterations": 0}),
        (denoise.anisotropic_diffusion, {"edge_factor": 0.0}),
        (denoise.anisotropic_diffusion, {"iterations": 0}),
        (denoise.anisotropic_diffusion, {"step": 0.3}),
        (denoise.moving_least_squares, {"sigma_px": 0.0}),
        (denoise.moving_least_squares, {"max_step_mm": 0.0}),
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
    still = [RigidTransform(np.eye(3), np.zeros(3))] * 2
    with pytest.raises(ParameterError, match="camera"):
        denoise.COMBINE[name]([IMAGE, OTHER], poses=still)


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        (combine.phasor_mean, {"frequency_hz": 0.0}),
        (combine.recursive, {"gain": 0.0}),
        (combine.recursive, {"max_step_mm": 0.0}),
        (combine.space_time_convolution, {"sigma_px": 0.0}),
        (combine.space_time_convolution, {"sigma_frames": 0.0}),
        (combine.space_time_convolution, {"max_step_mm": 0.0}),
        (combine.space_time_convolution, {"confidence": "trust"}),
        (combine.motion_compensated_mean, {"max_step_mm": 0.0}),
    ],
)
def test_a_parameter_of_a_combination_outside_its_range_is_named(method, parameters):
    (name,) = parameters
    with pytest.raises(ParameterError, match=name):
        method([IMAGE], **parameters)


@pytest.mark.parametrize("poses", [None, [], [RigidTransform(np.eye(3), np.zeros(3))]])
def test_a_missing_pose_is_refused(poses):
    with pytest.raises(ParameterError, match="poses"):
        combine.motion_compensated_mean([IMAGE, IMAGE], poses=poses)
