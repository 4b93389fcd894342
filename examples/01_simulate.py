"""Which sensor do I need? One simulated person before every sensor that rangeface knows."""

import numpy as np

from rangeface import sensors, simulate


def main() -> dict[str, float]:
    """Print, for each preset, the noise on the face at 60 cm, mm."""
    person = simulate.head(7, expression="smile")
    noise = {}
    for name, sensor in sensors.PRESETS.items():
        place = simulate.pose(yaw_deg=10.0, nose_tip_mm=(0.0, 0.0, 600.0))
        scene = simulate.render(person, sensor.camera, place)
        rng = np.random.default_rng(0)
        frames = np.stack([simulate.capture(scene, sensor, rng=rng).depth for _ in range(5)])
        face = np.isfinite(frames).all(axis=0) & (np.abs(scene.image.depth - 640.0) < 50.0)
        noise[name] = float(np.median(frames.std(axis=0, ddof=1)[face]))
        pitch = sensor.camera.pixel_mm(600.0)
        print(f"{name:17} {pitch:4.1f} mm a pixel, noise {noise[name]:5.2f} mm")
    return noise


if __name__ == "__main__":
    main()
