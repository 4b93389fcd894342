"""Every parameter of describe that can be wrong is refused by name."""

import numpy as np
import pytest

from rangeface import describe
from rangeface.errors import DegenerateError, ParameterError
from rangeface.numerics import (
    batches,
    curvature,
    gabor,
    gaussian,
    histograms,
    localfit,
    patterns,
    phase,
    regions,
)
from rangeface.types import Orthographic, RangeImage

IMAGE = RangeImage(
    np.zeros((40, 26)), Orthographic(4.0, 13, 20, 26, 40), amplitude=np.ones((40, 26))
)

BAD = [
    ("depth_levels", {"levels_per_mm": 0.0}, "levels_per_mm"),
    ("normals", {"components": "abc"}, "components"),
    ("normals", {"method": "spline"}, "method"),
    ("normals", {"radius_px": 0}, "radius_px"),
    ("normals", {"radius_px": float("nan")}, "radius_px"),
    ("n3", {"radius_px": 16}, "radius_px"),
    ("normal_angle", {"method": "spline"}, "method"),
    ("curvature", {"kind": "wavy"}, "kind"),
    ("curvature", {"method": "spline"}, "method"),
    ("curvature", {"radius_mm": 3.0}, "radius_mm"),
    ("curvature", {"radius_mm": 100.0}, "radius_mm"),
    ("lbp", {"points": 12}, "points"),
    ("lbp", {"radius_px": 0.0}, "radius_px"),
    ("lbp", {"radius_px": 13.0}, "smaller than the neighbourhood"),
    ("lbp", {"method": "u3"}, "method"),
    ("lbp", {"sigma_px": -1.0}, "sigma_px"),
    ("lbp_histogram", {"scales": ()}, "scales"),
    ("lbp_histogram", {"scales": ((16, 1.0),), "method": "ri"}, "method"),
    ("lbp_histogram", {"regions": (0, 4)}, "regions"),
    ("lbp_histogram", {"regions": (50, 4)}, "regions"),
    ("tdlbp", {"layers": (5,)}, "layers"),
    ("tdlbp", {"layers": ()}, "layers"),
    ("tdlbp", {"unit_mm": 0.0}, "unit_mm"),
    ("tdlbp", {"radius_px": -1.0}, "radius_px"),
    ("tdlbp_histogram", {"unit_mm": -1.0}, "unit_mm"),
    ("tdlbp_histogram", {"regions": (0, 1)}, "regions"),
    ("local_normal_patterns", {"points": 7}, "points"),
    ("local_normal_patterns", {"label": "x"}, "method"),
    ("hso", {"sigma_px": float("nan")}, "sigma_px"),
    ("lhg", {"sigma_px": 1e9}, "sigma_px"),
    ("vertical_profile", {"by": "eye"}, "by"),
    ("vertical_profile", {"points": 10}, "points"),
    ("vertical_profile", {"reach_mm": 0.0}, "reach_mm"),
    ("vertical_profile", {"half_width_mm": -1.0}, "half_width_mm"),
    ("vertical_profile", {"smooth_mm": -1.0}, "smooth_mm"),
    ("horizontal_profile", {"at": "ear"}, "at"),
    ("profiles", {"by": "eye"}, "by"),
    ("radial_curves", {"curves": 7}, "curves"),
    ("radial_curves", {"points": 0}, "points"),
    ("dtcwt", {"levels": ()}, "levels"),
    ("dtcwt", {"levels": (0,)}, "levels"),
    ("gabor", {"scales": 0}, "scales"),
    ("gabor", {"orientations": 17}, "orientations"),
    ("hog", {"cell_px": 1}, "cell_px"),
    ("hog", {"cell_px": 30}, "cell_px"),
    ("hog", {"block_cells": 0}, "block_cells"),
    ("hog", {"bins": 1}, "bins"),
    ("block_covariance", {"blocks": (40, 26)}, "blocks"),
    ("block_covariance", {"blocks": (0, 1)}, "blocks"),
    ("block_covariance", {"length_mm": 0.0}, "length_mm"),
    ("albedo", {"distance_mm": -1.0}, "distance_mm"),
    ("albedo", {"limit": 1.0}, "limit"),
    ("albedo_lbp", {"points": 9}, "points"),
]


@pytest.mark.parametrize(("name", "parameters", "message"), BAD)
def test_bad_parameters_are_refused_by_name(name, parameters, message):
    with pytest.raises(ParameterError, match=message):
        describe.METHODS[name](IMAGE, **parameters)


@pytest.mark.parametrize("name", ["lbp", "tdlbp", "hso", "lhg", "local_normal_patterns"])
def test_image_smaller_than_the_neighbourhood(name):
    small = RangeImage(np.zeros((2, 2)), Orthographic(4.0, 0, 0, 2, 2))
    with pytest.raises(ParameterError, match="smaller than the neighbourhood"):
        describe.METHODS[name](small)


@pytest.mark.parametrize("name", ["normals", "n3", "normal_angle", "curvature"])
def test_lone_pixels_carry_no_normal(name):
    depth = np.full((40, 26), np.nan)
    depth[::7, ::7] = 1.0
    with pytest.raises(DegenerateError):
        describe.METHODS[name](RangeImage(depth, IMAGE.camera))


def test_uncertainty_needs_a_sigma():
    for method in describe.UNCERTAINTY.values():
        with pytest.raises(ParameterError, match="sigma_mm"):
            method(IMAGE)
        with pytest.raises(ParameterError, match="sigma_mm"):
            method(IMAGE, sigma_mm=-1.0)
    with pytest.raises(ParameterError, match="degree"):
        describe.normals_covariance(IMAGE, method="difference", sigma_mm=1.0)
    with pytest.raises(ParameterError, match="kind"):
        describe.curvature_sigma(IMAGE, kind="wavy", sigma_mm=1.0)


def test_profile_that_meets_nothing():
    depth = np.full((40, 26), np.nan)
    depth[:, 0] = 1.0
    with pytest.raises(DegenerateError):
        describe.vertical_profile(RangeImage(depth, IMAGE.camera))


@pytest.mark.parametrize("name", ["normals", "n3", "curvature", "vertical_profile", "profiles"])
def test_sigma_of_zero(name):
    certain = RangeImage(IMAGE.depth, IMAGE.camera, sigma=np.zeros(IMAGE.shape))
    with pytest.raises(ParameterError, match="sigma"):
        describe.METHODS[name](certain)


def test_amplitude_without_light():
    dark = RangeImage(IMAGE.depth, IMAGE.camera, amplitude=np.zeros((40, 26)))
    with pytest.raises(DegenerateError, match="amplitude"):
        describe.albedo(dark)


def test_kernels_refuse_what_they_cannot_use():
    square = np.zeros((5, 5))
    with pytest.raises(ParameterError, match="images"):
        batches.as_batch(np.zeros(3))
    with pytest.raises(ParameterError, match="degree"):
        localfit.fit(square, degree=3)
    with pytest.raises(ParameterError, match="sigma"):
        localfit.fit(square, sigma=np.ones((4, 4)))
    with pytest.raises(ParameterError, match="sigma"):
        localfit.fit(square, sigma=0 * square)
    with pytest.raises(ParameterError, match="unit"):
        patterns.tdlbp(square, unit=0.0)
    with pytest.raises(ParameterError, match="method"):
        patterns.label_count(8, "x")
    with pytest.raises(ParameterError, match="weight"):
        phase.unwrap(square, np.ones((4, 4)))
    with pytest.raises(ParameterError, match="weight"):
        phase.unwrap(square, 0 * square)
    with pytest.raises(ParameterError, match="kind"):
        curvature.of_kind("x", 0.0, 0.0)
    with pytest.raises(ParameterError, match="finite"):
        gabor.magnitudes(square * np.nan)
    with pytest.raises(ParameterError, match="sigma_px"):
        gaussian.smooth(square, -1.0)
    with pytest.raises(ParameterError, match="regularisation"):
        regions.block_covariance(np.zeros((9, 9, 2)), blocks=(1, 1), regularisation=0.0)
    with pytest.raises(DegenerateError):
        histograms.regional(square, square, count=2, regions=(1, 1))
