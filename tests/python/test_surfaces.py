"""Surfaces and maxima where values touch, end or lie below 0."""

import numpy as np
import psivox


def sphere(size=32, radius=10.0):
    """Distances in voxels from a sphere around a point that is no voxel."""
    at = np.indices((size,) * 3) - np.array([15.3, 15.8, 16.1]).reshape(3, 1, 1, 1)
    return (np.linalg.norm(at, axis=0) - radius).astype("f4")


def test_a_plateau_at_the_isovalue_is_no_surface():
    band = sphere()
    band[band > 3] = 0  # as a level set's background, where nothing says that it is one
    how = {"mode": "isosurface", "isovalue": 0, "resolution": (96, 64)}
    image = psivox.render(band, **how)
    truth = psivox.render(band, **how, renderer="reference")
    assert psivox.compare(image, truth).max < 1e-4
    mask = (sphere() < 0).astype("f4")
    nothing = psivox.render(mask, mode="isosurface", isovalue=0, resolution=(96, 64))
    assert not np.asarray(nothing)[..., 3].any()


def test_normals_do_not_flip_at_a_silhouette():
    side = 192
    image = psivox.render(
        sphere(), mode="isosurface", isovalue=0, resolution=(side, side), look="plain",
        luminance=(1, 1, 1), light=(0, -1, 0), projection="orthographic", ortho_width=22,
        camera_position=(15.3, 15.8, 60), camera_target=(15.3, 15.8, 16.1), pixel_samples=1)
    pixels = np.asarray(image)
    y, x = (np.indices((side, side)) + 0.5) * 22 / side - 11
    normal_y = -y / 10  # of the sphere, at a pixel that sees it
    seen = pixels[..., 3] > 0
    off = np.abs(pixels[..., 0] - 0.2 - 0.8 * np.clip(normal_y, 0, 1))[seen]
    assert off.max() < 0.1, off.max()


def test_maxima_in_parts_are_those_of_the_whole(blobs):
    for mode in ("mip", "lmip"):
        how = {"mode": mode, "look": "plain", "range": (-1, 1), "resolution": (48, 48)}
        whole = psivox.render(blobs, **how)
        parts = psivox.render(blobs, **how, memory_limit="600K")
        assert any("parts" in notice for notice in parts.notices)
        assert psivox.compare(whole, parts).max < 1e-6


def test_maxima_below_zero_have_colours():
    values = np.full((8, 8, 8), -3, "f4")
    values[3:5, 3:5, 3:5] = -1
    image = psivox.render(values, mode="mip", colormap="viridis", range=(-2, 0), resolution=(48, 48))
    assert np.asarray(image)[..., 3].any()
