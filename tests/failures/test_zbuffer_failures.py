"""Bad parameters of the z-buffer are refused and named."""

import pytest

from rangeface.errors import ParameterError
from rangeface.numerics.zbuffer import rasterise

TRIANGLE = ([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]], [[0, 1, 2]])


@pytest.mark.parametrize("focal", [(0.0, 1.0), (1.0, float("nan")), (float("inf"), 1.0)])
def test_a_singular_camera_is_refused(focal):
    with pytest.raises(ParameterError, match="focal_px"):
        rasterise(*TRIANGLE, focal_px=focal, centre_px=(0, 0), size_px=(2, 2), perspective=True)


def test_an_empty_image_is_refused():
    with pytest.raises(ParameterError, match="size_px"):
        rasterise(*TRIANGLE, focal_px=(1, 1), centre_px=(0, 0), size_px=(0, 2), perspective=False)
