"""The feature experiments run on a small case and say what they should."""

import numpy as np
import pytest

from rangeface.errors import ParameterError
from rangeface.evaluation.experiments import feature_noise, figures_features, figures_way
from rangeface.simulate import head
from rangeface.types import Pinhole, RangeImage


def test_d_prime_of_known_distances():
    """Within 1 ± 1, between 4 ± 1: d′ = 3."""
    owner = np.array([0, 0, 1, 1])
    D = np.array([[0.0, 3.0], [2.0, 5.0], [3.0, 0.0], [5.0, 2.0]])
    assert feature_noise.d_prime(D, owner) == pytest.approx(3.0)


def test_interval_holds_its_estimate():
    rng = np.random.default_rng(0)
    people = 20
    owner = np.repeat(np.arange(people), 2)
    D = rng.normal(5.0, 1.0, (2 * people, people))
    D[np.arange(2 * people), owner] -= 3.0
    low, high = feature_noise.interval(D, owner, rng)
    assert low < feature_noise.d_prime(D, owner) < high
    assert high - low < 2.0


def test_figures_are_drawn(tmp_path):
    image = feature_noise.frontal(head(0).surface, 4.0)
    paths = figures_features.draw(image, tmp_path)
    assert [p.name for p in paths] == ["figure5.png", "figure6.png", "figure7.png", "figure9.png"]
    assert all(p.stat().st_size > 10_000 for p in paths)


def test_figures_refuse_what_is_not_frontal(tmp_path):
    with pytest.raises(ParameterError, match="frontal"):
        figures_features.draw(RangeImage(np.ones((9, 9)), Pinhole(9, 9, 4, 4, 9, 9)), tmp_path)


def test_figures_of_the_way_are_drawn(tmp_path):
    for path in figures_way.draw(tmp_path, seed=11):
        assert path.stat().st_size > 10_000
