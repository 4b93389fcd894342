"""Moving least squares reproduces planes, keeps layers apart, and propagates σ."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface.numerics.resample import mirrored, moving_least_squares

NO_VALUES = np.empty((4000, 0), np.float32)


def _resample(points: np.ndarray, weights: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    weights = np.ones(len(points), np.float32) if weights is None else weights
    values = np.empty((len(points), 0), np.float32)
    return moving_least_squares(
        points.astype(np.float32), weights, values, 20, 16, np.float32(1.0), np.float32(0.3)
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_plane_comes_back_exactly_wherever_the_points_lie(seed: int) -> None:
    rng = np.random.default_rng(seed)
    xy = rng.uniform([-2, -2], [18, 22], (4000, 2))
    slope = rng.normal(size=2) * 2.0
    depth, _, _ = _resample(np.column_stack([xy, 50 + xy @ slope]))
    rows, cols = np.indices((20, 16))
    assert np.allclose(depth, 50 + cols * slope[0] + rows * slope[1], atol=2e-3)


def test_a_surface_behind_another_does_not_pull_it_back() -> None:
    rng = np.random.default_rng(0)
    xy = rng.uniform([-2, -2], [18, 22], (4000, 2))
    front, back = np.full(4000, 10.0), np.full(4000, 80.0)
    depth, _, _ = _resample(np.r_[np.column_stack([xy, front]), np.column_stack([xy, back])])
    assert np.allclose(depth, 10.0, atol=1e-3)


def test_variance_falls_with_the_number_of_points() -> None:
    rng = np.random.default_rng(1)
    xy = rng.uniform([-2, -2], [18, 22], (8000, 2))
    weights = np.full(8000, 0.25, np.float32)  # σ = 2 mm
    points = np.column_stack([xy, np.zeros(8000)])
    _, few, _ = _resample(points[:2000], weights[:2000])
    _, many, _ = _resample(points, weights)
    assert np.nanmedian(few / many) == pytest.approx(4.0, rel=0.1)


def test_far_from_every_point_there_is_nothing() -> None:
    depth, variance, _ = _resample(np.array([[3.0, 3.0, 5.0]]))
    assert depth[3, 3] == 5.0
    assert np.isnan(depth[15, 10])
    assert np.isnan(variance[15, 10])


def test_mirroring_twice_gives_the_plane_back() -> None:
    plane = np.random.default_rng(2).normal(size=(6, 8)).astype(np.float32)
    assert np.array_equal(mirrored(mirrored(plane, 3.5), 3.5), plane)
