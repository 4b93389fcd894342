"""Makes data/lbp_scikit_image.npz: codes of scikit-image 0.26 on integer images.

python tests/cross/make_lbp_golden.py      (needs scikit-image; the tests do not)
"""

from pathlib import Path

import numpy as np
from skimage import __version__
from skimage.feature import local_binary_pattern

CASES = [(8, 1.0), (8, 2.0), (16, 1.0), (16, 2.0), (24, 3.0), (8, 1.5)]
METHODS = ["default", "ror", "uniform", "nri_uniform"]


def images():
    rng = np.random.default_rng(2026)
    v, u = np.mgrid[0:40, 0:34]
    face = 255 - ((u - 16.3) ** 2 / 3 + (v - 20.7) ** 2 / 5 + rng.integers(0, 4, u.shape))
    return {"noise": rng.integers(0, 256, (40, 34)), "face": face.clip(0, 255).astype(int)}


if __name__ == "__main__":
    golden = {"version": np.array(__version__)}
    for name, image in images().items():
        golden[name] = image.astype(np.uint8)
        for points, radius in CASES:
            for method in METHODS:
                codes = local_binary_pattern(image.astype(np.uint8), points, radius, method)
                key = f"{name}_{points}_{radius}_{method}"
                golden[key] = codes.astype(np.uint32)
    np.savez_compressed(Path(__file__).parent / "data" / "lbp_scikit_image.npz", **golden)
