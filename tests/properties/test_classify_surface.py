"""The surface matcher undoes small motions, tells shapes apart and pays for missing surface."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import griddata

from rangeface.classify import SurfaceMatcher
from rangeface.errors import ParameterError
from rangeface.numerics.se3 import rotation_matrix
from rangeface.numerics.surfaces import surface_losses

WIDTH, HEIGHT, PITCH = 50, 80, 2.8
FEW = settings(max_examples=8, deadline=None)


def face(seed: int = 0) -> np.ndarray:
    """Depth (H, W) of a nose on an ellipsoid, with bumps that no two seeds share."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    x, y = (u - 24.5) * PITCH, (v - 39.5) * PITCH
    depth = 90 * (1 - np.sqrt(np.maximum(1 - (x / 95) ** 2 - (y / 130) ** 2, 0.05)))
    depth += 20 - 20 * np.exp(-(x**2 + (y / 1.6) ** 2) / 250)
    for _ in range(12):
        cx, cy = rng.uniform(-55, 55), rng.uniform(-90, 5)
        depth += rng.normal(0, 4) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 300)
    return depth


def rows(*depths: np.ndarray, sigma: float = 1.0) -> np.ndarray:
    return np.stack([np.stack([d, np.full_like(d, sigma**-2)], -1).ravel() for d in depths])


def moved(depth: np.ndarray, turn_deg: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """The same surface after a rigid motion, resampled to the grid."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    points = np.stack([(u - 24.5) * PITCH, (v - 39.5) * PITCH, depth], -1).reshape(-1, 3)
    points = points @ rotation_matrix(np.deg2rad(turn_deg)).T + shift
    grid = points[:, :2] / PITCH + [24.5, 39.5]
    linear = griddata(grid, points[:, 2], (u, v), method="linear")
    return np.where(np.isnan(linear), griddata(grid, points[:, 2], (u, v), "nearest"), linear)


@given(st.integers(0, 1000))
@FEW
def test_a_small_rigid_motion_costs_little_and_another_person_much(seed):
    rng = np.random.default_rng(seed)
    one, other = face(seed), face(seed + 5000)
    probe = moved(one, rng.uniform(-4, 4, 3), rng.uniform(-3, 3, 3))
    matcher = SurfaceMatcher().fit(rows(one))
    same, different = matcher.similarity(rows(probe), rows(one, other))[0]
    assert same > -0.05
    assert different < same - 0.1


def test_without_iterations_a_motion_costs():
    pixels = np.argwhere(np.ones((HEIGHT, WIDTH), bool))
    probe = moved(face(1), np.array([3.0, 3.0, 0.0]), np.array([0.0, 2.0, 3.0]))
    P, G = (rows(d).astype(np.float32).reshape(1, HEIGHT, WIDTH, 2) for d in (probe, face(1)))
    losses = [
        surface_losses(P, G, pixels, pitch_mm=PITCH, iterations=n)[0, 0] for n in (0, 1, 2, 4)
    ]
    assert losses[0] > 5 * losses[-1]
    assert losses == sorted(losses, reverse=True)


def test_holes_in_the_gallery_are_paid_for_and_holes_in_the_probe_are_not():
    whole = rows(face(2))
    holed = whole.reshape(1, HEIGHT, WIDTH, 2).copy()
    holed[:, 10:30, :, 1] = 0.0
    holed = holed.reshape(1, -1)
    matcher = SurfaceMatcher(missing=0.9).fit(whole)
    assert matcher.similarity(whole, holed)[0, 0] < matcher.similarity(holed, whole)[0, 0] - 0.2


def test_a_noisy_pixel_says_less():
    probe = face(3).copy()
    probe[20:24, 20:30] += 25.0
    sure, unsure = rows(probe), rows(probe).reshape(1, HEIGHT, WIDTH, 2).copy()
    unsure[:, 20:24, 20:30, 1] = 1e-4
    matcher = SurfaceMatcher().fit(sure)
    gallery = rows(face(3))
    a, b = (matcher.similarity(p.reshape(1, -1), gallery)[0, 0] for p in (sure, unsure))
    assert b > a


def test_the_upper_face_does_not_see_the_mouth():
    laughing = face(4).copy()
    laughing[50:70, 10:40] += 10.0
    both = [
        SurfaceMatcher(region=region).fit(rows(laughing)).similarity(rows(laughing), rows(face(4)))
        for region in ("upper", "face")
    ]
    assert both[0][0, 0] > both[1][0, 0] + 0.02


def test_a_template_is_kept_to_half_precision():
    matcher = SurfaceMatcher().fit(rows(face(5)))
    kept = matcher.transform(rows(face(5)))
    assert np.abs(kept - rows(face(5))).max() < 0.07
    np.testing.assert_array_equal(matcher.transform(kept), kept)


BAD = {"region": "mouth", "width": 1, "pitch_mm": 0.0, "scale_mm": np.nan, "missing": 2.0}


@pytest.mark.parametrize("name", BAD)
def test_a_parameter_out_of_range_is_named(name):
    with pytest.raises(ParameterError, match=name):
        SurfaceMatcher(**{name: BAD[name]}).fit(rows(face(0)))


def test_rows_that_are_no_table_are_refused():
    with pytest.raises(ParameterError, match="expected"):
        SurfaceMatcher().similarity(rows(face(0))[0], rows(face(0)))
