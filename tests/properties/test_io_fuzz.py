"""Twenty thousand mutated files, and a few always: nothing but images, points and ScanError."""

import fuzz
import pytest


def test_a_few_hundred_mutated_files():
    result = fuzz.run(400, seed=7)
    assert result["cases"] == 400
    assert len(result["outcomes"]) > 3


@pytest.mark.slow
def test_twenty_thousand_mutated_files():
    result = fuzz.run(20_000, seed=2)
    assert result["cases"] == 20_000
    print(result)
