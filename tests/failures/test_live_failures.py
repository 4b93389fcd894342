"""Every Raises line of the live package."""

import pytest

from rangeface.errors import ParameterError
from rangeface.gallery import MemoryGallery
from rangeface.live import Doorway, LiveRecognizer, write_transfers, write_visits


class Uncalibrated:
    def threshold(self, fmr):
        raise ParameterError("fmr: this model is not calibrated")


def test_an_uncalibrated_recogniser():
    with pytest.raises(ParameterError, match="not calibrated"):
        LiveRecognizer(Uncalibrated(), MemoryGallery())


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: LiveRecognizer(None, None, look_every=0), "look_every"),
        (lambda: LiveRecognizer(None, None, meet_after=0), "meet_after"),
        (lambda: LiveRecognizer(None, None, max_age_s=0.0), "max_age_s"),
        (lambda: LiveRecognizer(None, None, fpir=0.7), "fpir"),
        (lambda: LiveRecognizer(None, None, correlation=-0.1), "correlation"),
        (lambda: Doorway("w"), "axis"),
        (lambda: Doorway(inwards=0), "inwards"),
        (lambda: write_visits("visits.xls", []), "path"),
        (lambda: write_transfers("transfers.txt", []), "path"),
    ],
)
def test_parameters_out_of_range(make, name):
    with pytest.raises(ParameterError, match=name):
        make()
