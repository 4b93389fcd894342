"""Finding, registering and resampling a face; ICP against Open3D and small_gicp."""

from collections.abc import Callable, Iterator

import numpy as np

from rangeface import register, segment, sensors, simulate
from rangeface.io.reference import default_reference
from rangeface.numerics import icp
from rangeface.numerics.se3 import head_rotation
from rangeface.types import Pinhole, RangeImage

CAMERAS = {
    "176 × 144": sensors.preset("sr3000").camera,
    "640 × 480": Pinhole(585.0, 585.0, 319.5, 239.5, 640, 480),
}
METHODS = (register.icp, register.symmetric)
GATES = np.array([25] * 4 + [15] * 4 + [10] * 8, np.float32)
SCALES = np.array([9] * 4 + [5] * 4 + [3] * 8, np.float32)


def stages() -> Iterator[tuple[str, str, dict[str, Callable[[], object]]]]:
    """Yield the stage, its size and the arms, each a callable without arguments."""
    for size, camera in CAMERAS.items():
        images = [face_image(camera, person) for person in range(4)]
        faces = [segment.slices(image)[0] for image in images]
        alignments = [register.icp(face) for face in faces]
        pairs = list(zip(faces, alignments, strict=True))
        yield "find a face", size, {"ours": _turns(segment.slices, images)}
        yield "register", size, {f"ours, {m.__name__}": _turns(m, faces) for m in METHODS}
        yield (
            "first detection: find, crop, register",
            size,
            {f"ours, {m.__name__}": _turns(_detected(m), images) for m in METHODS},
        )
        yield (
            "tracked face: find, crop, register",
            size,
            {f"ours, {m.__name__}": _turns(_tracked(m, alignments), images) for m in METHODS},
        )
        yield "resample", size, {"ours": _turns(lambda p: register.frontal.resample(*p), pairs)}
        yield "ICP to the reference", size, icp_arms(images)


def face_image(camera: Pinhole, person: int) -> RangeImage:
    pose = simulate.pose(yaw_deg=5.0 * person - 8.0, nose_tip_mm=(3.0, 5.0, 450.0))
    clean = simulate.render(simulate.head(person), camera, pose).image
    return simulate.add_noise(clean, 2.0, rng=np.random.default_rng(person))


def _detected(method: Callable) -> Callable[[RangeImage], object]:
    """Find, crop and register in an image of which nothing is known."""
    return lambda image: method(segment.slices(image)[0])


def _tracked(method: Callable, alignments: list) -> Callable[[RangeImage], object]:
    """Find, crop and register in the next frame, from the pose of the last one."""
    state = {"pose": alignments[0].transform}

    def step(image: RangeImage) -> object:
        faces = segment.follow(RangeImage(image.depth, image.camera, image.sigma), state["pose"])
        alignment = method(faces[0])
        state["pose"] = alignment.transform
        return alignment

    return step


def _turns(method: Callable, items: list) -> Callable[[], object]:
    """Call the method on the next item at every call."""
    state = {"next": 0}

    def call() -> object:
        state["next"] = (state["next"] + 1) % len(items)
        return method(items[state["next"]])

    return call


def starts_of(images: list[RangeImage]) -> list[tuple[RangeImage, np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(0)
    out = []
    for k in range(200):
        image = images[k % len(images)]
        tip = np.array([3.0, 5.0, 450.0]) + rng.uniform(-12.0, 12.0, 3)
        out.append((image, head_rotation(*np.deg2rad(rng.uniform(-15.0, 15.0, 3))), tip))
    return out


def icp_arms(images: list[RangeImage]) -> dict[str, Callable[[], object]]:
    model = icp.Model(*default_reference().surface(1500))
    ones = {id(i): np.ones(i.shape, np.float32) for i in images}
    starts = starts_of(images)
    arms = {
        "ours": _turns(
            lambda s: icp.align(
                model,
                s[0].camera.projection,
                s[0].points,
                ones[id(s[0])],
                s[1],
                s[2],
                gates_mm=GATES,
                scales_mm=SCALES,
            ),
            starts,
        )
    }
    arms |= _open3d(model, starts)
    arms |= _small_gicp(model, starts)
    return arms


def _cropped(image: RangeImage, tip: np.ndarray) -> np.ndarray:
    points = image.points[image.mask].astype(np.float64)
    return points[np.linalg.norm(points - tip, axis=1) < 110.0]


def _matrix(R: np.ndarray, t: np.ndarray) -> np.ndarray:
    """T_model_camera of a pose camera←model, 4 × 4."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R.T, -R.T @ t
    return T


def _open3d(model: icp.Model, starts: list) -> dict[str, Callable[[], object]]:
    try:
        import open3d as o3d
    except ImportError:
        print("Open3D is not installed: left out")
        return {}
    reg = o3d.pipelines.registration
    target = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(model.points.astype(float)))
    target.normals = o3d.utility.Vector3dVector(model.normals.astype(float))
    clouds = [
        o3d.geometry.PointCloud(o3d.utility.Vector3dVector(_cropped(i, t))) for i, _, t in starts
    ]
    method = reg.TransformationEstimationPointToPlane(reg.TukeyLoss(k=9.0))
    items = [(c, _matrix(R, t)) for c, (_, R, t) in zip(clouds, starts, strict=True)]
    return {
        "Open3D": _turns(lambda s: reg.registration_icp(s[0], target, 20.0, s[1], method), items)
    }


def _small_gicp(model: icp.Model, starts: list) -> dict[str, Callable[[], object]]:
    try:
        import small_gicp
    except ImportError:
        print("small_gicp is not installed: left out")
        return {}
    target, tree = small_gicp.preprocess_points(
        model.points.astype(float), downsampling_resolution=0.1, num_threads=1
    )
    items = []
    for image, R, t in starts:
        source, _ = small_gicp.preprocess_points(
            _cropped(image, t), downsampling_resolution=0.1, num_threads=1
        )
        items.append((source, _matrix(R, t)))
    return {
        "small_gicp": _turns(
            lambda s: small_gicp.align(
                target,
                s[0],
                tree,
                init_T_target_source=s[1],
                registration_type="PLANE_ICP",
                max_correspondence_distance=20.0,
                num_threads=1,
            ),
            items,
        )
    }
