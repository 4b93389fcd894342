from __future__ import annotations

from rangeface.types import RangeImage


def none(image: RangeImage) -> RangeImage:
    """Leave the image as it is: the arm that every denoiser has to beat.

    Parameters
    ----------
    image : RangeImage
        Any image.

    Returns
    -------
    RangeImage
        The same object.

    Examples
    --------
    >>> from rangeface.types import Pinhole
    >>> image = RangeImage([[400.0, 401.0]], Pinhole(200, 200, 0.5, 0, 2, 1))
    >>> none(image) is image
    True
    """
    return image
