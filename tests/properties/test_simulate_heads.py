"""The population: seeded, plausible, different."""

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from rangeface import simulate
from rangeface.simulate import Tissue
from rangeface.simulate._identity import ASYMMETRY, FACTORS
from rangeface.types import Orthographic

CAMERA = Orthographic(2.0, 39.5, 54.5, 80, 110)


def points(*args, **kwargs):
    return simulate.head(*args, **kwargs).surface.points


def test_the_same_number_is_the_same_head():
    first = simulate.head(12, expression="random", session=3, glasses=True, beard=True)
    again = simulate.head(12, expression="random", session=3, glasses=True, beard=True)
    np.testing.assert_array_equal(first.surface.points, again.surface.points)
    np.testing.assert_array_equal(first.reflectivity, again.reflectivity)


def test_no_two_are_alike():
    stack = np.stack([points(seed) for seed in range(12)])
    for i in range(12):
        others = np.sqrt(((stack - stack[i]) ** 2).sum(-1).mean(-1))
        assert np.sort(others)[1] > 2.0


def test_there_are_at_least_forty_independent_factors():
    assert len(FACTORS) >= 40
    assert len({f.name for f in (*FACTORS, *ASYMMETRY)}) == len(FACTORS) + len(ASYMMETRY)
    from rangeface.simulate._identity import basis

    flat = basis().reshape(len(FACTORS) + len(ASYMMETRY), -1).astype(float)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.linalg.matrix_rank(flat, tol=0.05) == len(flat)


# means and deviations over women and men of Farkas (1994) and Zhuang et al. (2010), mm
SURVEY = {
    "face height": (118.0, 6.5),
    "nose height": (52.5, 3.6),
    "nose width": (34.0, 3.2),
    "nose protrusion": (19.5, 2.2),
    "mouth width": (51.0, 4.0),
    "inner eye distance": (32.5, 2.8),
    "outer eye distance": (90.0, 5.0),
}


def measure(head):
    m = head.landmarks

    def apart(a, b):
        return np.linalg.norm(m[a] - m[b])

    return {
        "face height": apart("nose_root", "gnathion"),
        "nose height": apart("nose_root", "subnasale"),
        "nose width": apart("left_alare", "right_alare"),
        "nose protrusion": apart("nose_tip", "subnasale"),
        "mouth width": apart("left_mouth_corner", "right_mouth_corner"),
        "inner eye distance": apart("left_eye_inner", "right_eye_inner"),
        "outer eye distance": apart("left_eye_outer", "right_eye_outer"),
    }


@pytest.mark.parametrize("size", sorted(SURVEY))
def test_the_mean_head_has_the_sizes_of_the_surveys(size):
    mean, deviation = SURVEY[size]
    assert measure(simulate.mean_head())[size] == pytest.approx(mean, abs=0.8 * deviation)


def test_people_vary_as_much_as_the_surveys_say():
    people = [measure(simulate.head(seed)) for seed in range(80)]
    for size, (mean, deviation) in SURVEY.items():
        values = np.array([person[size] for person in people])
        assert values.mean() == pytest.approx(mean, abs=1.2 * deviation), size
        assert 0.4 * deviation < values.std() < 1.9 * deviation, size


def test_the_nose_tip_is_the_origin_and_the_most_forward_point_of_the_nose():
    for seed in range(10):
        p = points(seed)
        nose = p[(np.abs(p[:, 0]) < 9) & (np.abs(p[:, 1]) < 9)]
        assert nose[:, 2].min() == pytest.approx(0.0, abs=0.05)


def test_the_mean_head_is_symmetric():
    depth = simulate.render(simulate.mean_head(), Orthographic(2.0, 40, 54, 81, 110)).image.depth
    difference = depth - depth[:, ::-1]
    assert np.nanquantile(np.abs(difference), 0.99) < 0.5


def test_people_are_not_quite_symmetric():
    camera = Orthographic(2.0, 40, 54, 81, 110)
    depth = simulate.render(simulate.head(4), camera).image.depth
    face = (slice(20, 90), slice(20, 61))
    assert np.nanmean(np.abs(depth - depth[:, ::-1])[face]) > 0.5


def test_men_differ_from_women_as_the_surveys_say():
    women, men = (
        [measure(simulate.head(seed, sex=sex)) for seed in range(30)] for sex in ("female", "male")
    )
    for size in ("face height", "nose width", "nose height"):
        assert np.mean([m[size] for m in men]) > np.mean([w[size] for w in women])


def test_sex_and_age_change_only_what_they_tend_to_change():
    young, old = points(5, age=25), points(5, age=75)
    assert 0.3 < np.abs(young - old).max() < 15.0
    assert np.abs(points(5, age=25) - young).max() == 0.0


@pytest.mark.parametrize("expression", ["smile", "laugh", "frown", "surprise"])
def test_an_expression_grows_with_its_strength(expression):
    neutral = points(3)
    change = [
        np.sqrt(((points(3, expression=expression, strength=s) - neutral) ** 2).mean())
        for s in (0.0, 0.5, 1.0)
    ]
    assert change[0] == 0.0
    assert change[0] < change[1] < change[2]


def test_a_laugh_opens_the_mouth_and_leaves_the_forehead():
    neutral, laugh = simulate.head(3), simulate.head(3, expression="laugh")
    assert laugh.landmarks["chin"][1] - neutral.landmarks["chin"][1] > 6.0
    before, after = (simulate.render(h, CAMERA).image.depth for h in (neutral, laugh))
    assert np.nanmax((after - before)[66:76, 34:46]) > 15.0  # between the lips
    assert np.nanmean(np.abs((after - before)[5:20, 25:55])) < 3.5


def test_a_random_gesture_changes_with_the_session():
    first, second = (points(3, expression="random", session=s) for s in (1, 2))
    assert np.abs(first - second).max() > 1.0


def test_a_second_session_is_the_same_person_nearly():
    first, second, other = points(8), points(8, session=1), points(9)
    face = np.linalg.norm(first, axis=1) < 90
    same = np.sqrt(((first - second)[face] ** 2).sum(-1).mean())
    different = np.sqrt(((first - other)[face] ** 2).sum(-1).mean())
    assert 0.05 < same < 0.4 * different


def test_glasses_add_a_frame_before_the_eyes():
    bare, worn = simulate.head(2), simulate.head(2, glasses=True)
    assert (worn.tissue == Tissue.FRAME).sum() > 50
    n = len(bare.surface.points)
    np.testing.assert_array_equal(worn.surface.points[:n], bare.surface.points)
    depth_bare, depth_worn = (simulate.render(h, CAMERA).image.depth for h in (bare, worn))
    nearer = depth_bare - depth_worn
    assert np.nanmax(nearer[28:44]) > 3.0
    assert np.nanmax(np.abs(nearer[60:])) == 0.0


@pytest.mark.parametrize(("worn", "rows"), [("beard", (70, 90)), ("fringe", (5, 18))])
def test_beard_and_fringe_are_hair_in_front_of_the_skin(worn, rows):
    bare, hairy = simulate.head(2), simulate.head(2, **{worn: True})
    assert (hairy.tissue == Tissue.HAIR).sum() > (bare.tissue == Tissue.HAIR).sum() + 50
    depth_bare, depth_hairy = (simulate.render(h, CAMERA).image.depth for h in (bare, hairy))
    assert np.nanmax((depth_bare - depth_hairy)[slice(*rows)]) > 2.0


def test_the_population_is_seen_from_the_side_without_holes():
    camera = Orthographic(2.0, 59.5, 64.5, 120, 130)
    view = simulate.render(simulate.mean_head(), camera, simulate.pose(yaw_deg=60.0))
    depth = view.image.depth
    inner = np.isfinite(depth[:, 1:-1]).sum(axis=1)
    for row in range(5, 110):
        seen = np.flatnonzero(np.isfinite(depth[row]))
        if inner[row] > 3:
            assert np.isfinite(depth[row, seen[0] : seen[-1] + 1]).all()


def test_the_triangles_of_the_head_close_the_head():
    head = simulate.mean_head()
    edges = np.sort(head.surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    columns = 135
    assert (counts == 1).sum() == 2 * columns  # the crown and the shoulders only
    assert counts.max() == 2


def test_a_head_does_not_depend_on_the_number_of_threads():
    from rangeface.simulate import _head

    def laughing(threads):
        for cached in (_head._person, _head._stoutness, _head._hair):
            cached.cache_clear()
        with threadpool_limits(threads):
            return simulate.head(5, expression="laugh", session=1).surface.points

    np.testing.assert_array_equal(laughing(1), laughing(2))
