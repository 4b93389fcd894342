"""How well ICP ends, beside Open3D and small_gicp: 200 random starts of ±15° and 12 mm an axis.

python -m benchmarks.icp_error

The error of a pose is one measure for all: the mean distance of the nearest 80 % of the reference's
points to the face's points, mm.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.bench_register import CAMERAS, face_image, icp_arms, starts_of
from rangeface.io.reference import default_reference


def main() -> None:
    points = default_reference().surface(1500)[0].astype(float)
    for size, camera in CAMERAS.items():
        images = [face_image(camera, person) for person in range(4)]
        trees = {id(i): cKDTree(i.points[i.mask]) for i in images}
        starts = starts_of(images)
        for arm, call in icp_arms(images).items():
            # every arm goes through the starts in turn, beginning with the second
            order = [*starts[1:], starts[0]]
            errors = [_error(points, *_pose(call()), trees[id(start[0])]) for start in order]
            low, middle, high = np.percentile(errors, [5, 50, 95])
            print(f"{size:12} {arm:12} {middle:6.3f} mm  [5 %: {low:.3f}, 95 %: {high:.3f}]  "
                  f"n = {len(errors)}")  # fmt: skip


def _pose(result: object) -> tuple[np.ndarray, np.ndarray]:
    """Camera←model of what an arm returns."""
    if hasattr(result, "rotation"):
        return result.rotation, result.translation
    pose = result.transformation if hasattr(result, "transformation") else result.T_target_source
    T = np.linalg.inv(pose)
    return T[:3, :3], T[:3, 3]


def _error(points: np.ndarray, R: np.ndarray, t: np.ndarray, tree: cKDTree) -> float:
    distances = np.sort(tree.query(points @ R.T + t)[0])
    return float(distances[: int(0.8 * len(distances))].mean())


if __name__ == "__main__":
    main()
