"""The reference face that ships is the one that `make reference` builds, and survives its file."""

from __future__ import annotations

import numpy as np
import pytest

from rangeface.app import reference as builder
from rangeface.errors import DegenerateError, ScanError
from rangeface.io.reference import default_reference, load_reference, save_reference
from rangeface.register.bootstrap import MIN_FACES, bootstrap
from rangeface.types import Orthographic, RangeImage, ReferenceFace


def test_the_shipped_reference_is_rebuilt_from_the_embedded_population() -> None:
    shipped = default_reference()
    built = builder.build(people=30)
    both = shipped.image.mask & built.image.mask
    assert both.sum() > 0.98 * shipped.image.mask.sum()
    assert np.abs(shipped.image.depth - built.image.depth)[both].max() < 0.02
    assert set(built.landmarks) == set(shipped.landmarks)


def test_its_nose_tip_is_the_origin_and_its_most_forward_point() -> None:
    image = default_reference().image
    tip = image.points[np.unravel_index(np.nanargmin(image.depth), image.shape)]
    assert np.abs(tip).max() < 4.0


def test_a_reference_survives_its_file(tmp_path) -> None:
    path = tmp_path / "r.npz"
    save_reference(path, default_reference())
    again = load_reference(path)
    assert np.allclose(
        again.image.depth, default_reference().image.depth, atol=0.01, equal_nan=True
    )
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(ScanError, match=r"r\.npz"):
        load_reference(path)
    with pytest.raises(ScanError, match="file not found"):
        load_reference(tmp_path / "none.npz")


def test_surfaces_are_spread_evenly_and_about_as_many_as_asked() -> None:
    for count in (100, 400, 1500):
        points, normals, weights = default_reference().surface(count)
        assert 0.7 * count < len(points) < 1.4 * count
        assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
        assert (weights > 0).all()
        assert weights.max() <= 1.0


def _frontals(count: int, camera: Orthographic) -> list[RangeImage]:
    rows, cols = np.indices((camera.height, camera.width))
    rng = np.random.default_rng(0)
    shape = ((rows - camera.cy) ** 2 + (cols - camera.cx) ** 2) / 20.0
    return [RangeImage(shape + rng.normal(0, 1.0), camera) for _ in range(count)]


def test_a_bootstrapped_reference_is_the_symmetric_median() -> None:
    camera = Orthographic(2.8, 24.5, 39.5, 50, 80)
    learned = bootstrap(_frontals(MIN_FACES, camera), default_reference())
    depth = learned.image.depth
    assert isinstance(learned, ReferenceFace)
    assert np.allclose(depth, depth[:, ::-1], equal_nan=True)
    assert np.nanmax(depth) < 105.0


def test_too_few_faces_or_different_grids_make_no_reference() -> None:
    camera = Orthographic(2.8, 24.5, 39.5, 50, 80)
    with pytest.raises(DegenerateError, match="at least 10"):
        bootstrap(_frontals(MIN_FACES - 1, camera), default_reference())
    mixed = _frontals(MIN_FACES, camera) + _frontals(1, Orthographic(2.0, 24.5, 39.5, 50, 80))
    with pytest.raises(DegenerateError, match="different grids"):
        bootstrap(mixed, default_reference())
