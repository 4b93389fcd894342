"""Any kind of 3-D objects: the same pipeline tells ten bumpy plates apart.

What a face pipeline needs is a reference surface to align to and a size to crop. Here the
reference is a shallow dome and the objects are domes with bumps and dents in closed form; the
camera, the noise, the finder, the registration, the features and the classifier are the same.
"""

from dataclasses import replace

import numpy as np

from rangeface import simulate
from rangeface.config import load_pipeline
from rangeface.gallery import stack
from rangeface.types import Orthographic, Pinhole, PointSet, RangeImage, ReferenceFace

CAMERA = Pinhole(230.0, 230.0, 87.5, 71.5, 176, 144)
OBJECTS = 10
RADIUS_MM = 60.0


def surface(number: int | None) -> PointSet:
    """Object `number` (None: the plain dome of the reference), apex at the origin, mm."""
    axis = np.arange(-RADIUS_MM, RADIUS_MM + 1.0, 2.0)
    x, y = np.meshgrid(axis, axis)
    z = 45.0 * (1.0 - np.exp(-(x**2 + 1.5 * (y + 8.0) ** 2) / 1800.0)) + 0.004 * (x**2 + y**2)
    if number is not None:
        for sign, (u, v) in zip((1, -1, 1, -1), _places(number), strict=True):
            z -= sign * 7.0 * np.exp(-((x - u) ** 2 + (y - v) ** 2) / 160.0)
    z -= z[len(axis) // 2, len(axis) // 2]
    inside = np.hypot(x, y) <= RADIUS_MM
    index = np.cumsum(inside).reshape(inside.shape) - 1
    a, b, c, d = (
        np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[:-1, 1:], np.s_[1:, 1:]
    )  # fmt: skip
    whole = inside[a] & inside[b] & inside[c] & inside[d]
    corners = [index[s][whole] for s in (a, b, c, d)]
    upper, lower = np.stack(corners[:3], 1), np.stack([corners[2], corners[1], corners[3]], 1)
    points = np.stack([x[inside], y[inside], z[inside]], axis=1)
    return PointSet(points, np.concatenate([upper, lower]))


def _places(number: int) -> np.ndarray:
    """Where the bumps and dents of an object are, (4, 2) mm."""
    rng = np.random.default_rng(number)
    angle = np.linspace(0.0, 2.0 * np.pi, 4, endpoint=False) + rng.uniform(0.0, np.pi / 2, 4)
    distance = rng.uniform(22.0, 45.0, 4)
    return np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=1)


def capture(number: int, seed: int) -> RangeImage:
    """A noisy range image of an object, a little turned."""
    rng = np.random.default_rng([number, seed])
    yaw, pitch, roll = rng.uniform(-10.0, 10.0, 3)
    pose = simulate.pose(
        yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll, nose_tip_mm=(*rng.uniform(-15, 15, 2), 400.0)
    )
    clean = simulate.render(surface(number), CAMERA, pose).image
    return simulate.add_noise(clean, 1.0, rng=rng)


def pipeline() -> object:
    """The face pipeline with another reference, crop and grid."""
    grid = Orthographic(2.0, 30.0, 30.0, 61, 61)
    reference = ReferenceFace(simulate.render(surface(None), grid).image, name="dome")
    way = replace(load_pipeline("full-n-mlda"), adapt_reference=False)
    way = replace(
        way,
        segment=way.segment.with_params(radius_mm=RADIUS_MM + 15.0, max_yaw_deg=30.0),
        frontal=way.frontal.with_params(
            width_mm=110.0, height_mm=110.0, width=55, height=55, radius_mm=RADIUS_MM + 15.0
        ),
    )
    return way.with_reference(reference)


def main() -> tuple[int, int]:
    """Learn each object from two captures, recognise it from two others; print the count."""
    way = pipeline()
    train = [(n, seed) for n in range(OBJECTS) for seed in (0, 1)]
    fitted = way.fit([capture(*item) for item in train], [str(n) for n, _ in train])
    gallery = stack(
        ((str(n), fitted.template(capture(n, 0), augment=True)) for n in range(OBJECTS)),
        fitted.fingerprint,
    )
    probes = [(n, seed) for n in range(OBJECTS) for seed in (2, 3)]
    right = 0
    for number, seed in probes:
        trace = fitted.trace(capture(number, seed))
        if trace.frontal is not None:
            scores = fitted.similarity(fitted.template(trace), gallery)
            right += gallery.subjects[int(scores.argmax())] == str(number)
    print(f"{right} of {len(probes)} objects recognised")
    return right, len(probes)


if __name__ == "__main__":
    main()
