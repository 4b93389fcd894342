"""LBP codes against scikit-image's, pixel by pixel, through bit and label maps.

scikit-image counts its neighbours from the right **counter-clockwise**, ours go clockwise:

- bit k of our code is bit (P − k) mod P of its "default" code;
- its "ror" is the smallest rotation of our "ri" read in the opposite direction;
- its "uniform" is our "riu2";
- its "nri_uniform" label 1 + (n − 1) P + r' of a run of n ones has r' = (r + n − 1) mod P, r being
  the rotation of our "u2".

Its images are integers: it interpolates before it subtracts, so ties of floats round either way.
"""

from pathlib import Path

import numpy as np
import pytest

from rangeface.numerics import patterns

GOLDEN = np.load(Path(__file__).parent / "data" / "lbp_scikit_image.npz")
CASES = [(8, 1.0), (8, 2.0), (16, 1.0), (16, 2.0), (24, 3.0), (8, 1.5)]


def codes(name, points, radius, ours, theirs):
    """Both codes on the interior, where every neighbour is inside the image."""
    image = GOLDEN[name].astype(np.float32)
    found = patterns.lbp(image, points=points, radius_px=radius, method=ours).astype(np.int64)
    golden = GOLDEN[f"{name}_{points}_{radius}_{theirs}"].astype(np.int64)
    edge = int(np.ceil(radius))
    inner = (slice(edge, -edge), slice(edge, -edge))
    return found[inner], golden[inner]


def reversed_bits(code, points):
    return sum(((code >> k) & 1) << ((points - k) % points) for k in range(points))


def smallest_rotation(code, points):
    full = (1 << points) - 1
    turned = [((code >> k) | (code << (points - k))) & full for k in range(points)]
    return np.min(turned, axis=0)


@pytest.mark.parametrize("name", ["noise", "face"])
@pytest.mark.parametrize(("points", "radius"), CASES)
def test_every_interior_code_is_scikit_images(name, points, radius):
    ours, theirs = codes(name, points, radius, "basic", "default")
    np.testing.assert_array_equal(reversed_bits(ours, points), theirs)
    ours, theirs = codes(name, points, radius, "riu2", "uniform")
    np.testing.assert_array_equal(ours, theirs)
    ours, theirs = codes(name, points, radius, "ri", "ror")
    np.testing.assert_array_equal(smallest_rotation(reversed_bits(ours, points), points), theirs)


@pytest.mark.parametrize("name", ["noise", "face"])
@pytest.mark.parametrize(("points", "radius"), CASES)
def test_every_uniform_label_is_scikit_images(name, points, radius):
    ours, theirs = codes(name, points, radius, "u2", "nri_uniform")
    last = points * (points - 1)
    ones, rotation = (ours - 1) // points + 1, (ours - 1) % points
    mapped = 1 + (ones - 1) * points + (rotation + ones - 1) % points
    mapped = np.where((ours == 0) | (ours > last), ours, mapped)
    np.testing.assert_array_equal(mapped, theirs)
