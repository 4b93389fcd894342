"""Write dtcwt_golden.npz: coefficients of the `dtcwt` library (0.14) for small random images.

Run by hand, with numpy 2 too: ``python tests/cross/make_dtcwt_golden.py`` (pip install dtcwt).
"""

from pathlib import Path

import numpy as np

SHAPES = [(16, 16), (18, 30), (20, 27)]
FILTERS = [("near_sym_a", "qshift_a"), ("near_sym_b", "qshift_b"), ("near_sym_a", "qshift_06")]
LEVELS = 3


def image(shape):
    return np.random.default_rng(list(shape)).normal(size=shape)


def main():
    # the library was written for numpy 1
    np.__dict__["asfarray"] = lambda a, dtype=np.float64: np.asarray(a, dtype=dtype)
    np.__dict__["issubsctype"] = np.issubdtype
    import dtcwt

    golden = {}
    for shape in SHAPES:
        for first, further in FILTERS:
            name = f"2d {shape[0]} {shape[1]} {first} {further}"
            transform = dtcwt.Transform2d(biort=first, qshift=further)
            pyramid = transform.forward(image(shape), nlevels=LEVELS)
            golden[f"{name} low"] = pyramid.lowpass.astype(np.float32)
            for number, highpass in enumerate(pyramid.highpasses):
                golden[f"{name} {number}"] = np.moveaxis(highpass, -1, 0).astype(np.complex64)
    for length in (32, 50):
        pyramid = dtcwt.Transform1d().forward(image((length,)), nlevels=LEVELS)
        golden[f"1d {length} low"] = pyramid.lowpass.ravel().astype(np.float32)
        for number, highpass in enumerate(pyramid.highpasses):
            golden[f"1d {length} {number}"] = highpass.ravel().astype(np.complex64)
    np.savez_compressed(Path(__file__).with_name("dtcwt_golden.npz"), **golden)


if __name__ == "__main__":
    main()
