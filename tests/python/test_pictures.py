"""Pictures: the command line's, their layers, files and measurements."""

import ast
import copy
import inspect
import pickle
import re
import warnings

import numpy as np
import pytest

import psivox

SMALL = (48, 32)


@pytest.mark.parametrize("keywords, options", [
    ({}, ""),
    ({"light": [(0, -1, 0), (1, 0, 0, 0.5, 0.5, 1)], "background": (0.1, 0.2, 0.3),
      "exposure": "auto", "azimuth": 30, "fov": 20.5, "tolerance": 1e-2},
     "--azimuth 30 --fov 20.5 --tolerance 1e-2 --light 0,-1,0 --light 1,0,0,0.5,0.5,1 "
     "--background 0.1,0.2,0.3 --exposure auto"),
    ({"colormap": "viridis", "opacity": [(0, 0), (1, 0.5)], "range": ("1%", "99%"),
      "color_bar": True, "aov": ["transmittance", "depth"]},
     "--colormap viridis --opacity 0:0,1:0.5 --range 1%,99% --color-bar --aov transmittance,depth"),
    ({"mode": "isosurface", "isovalue": 0.5, "projection": "orthographic", "device": None},
     "--mode isosurface --isovalue 0.5 --projection orthographic"),
    ({"background": "none"}, "--background none"),
    ({"grid": "temperature", "renderer": "march-double", "step": 1, "clip_plane": "x=0"},
     "--grid temperature --renderer march-double --step 1 --clip-plane x=0"),
])
@pytest.mark.filterwarnings("ignore:.* loses .* of the picture's light")
def test_files_are_the_command_lines(blobs, command, tmp_path, keywords, options):
    """Every byte: pixels, layers and metadata."""
    size = (160, 120) if "color_bar" in keywords else SMALL  # which has no room for a bar
    image = psivox.render(blobs, resolution=size, **keywords)
    coded = not keywords.keys() & {"mode", "grid"}  # of these the floats tell all
    for name in ("a.exr", "a.png") if coded else ("a.exr",):
        if name == "a.png":
            options = re.sub("--aov [^ ]*", "", options)
        image.write(tmp_path / name)
        written = (tmp_path / name).read_bytes()
        command("render", blobs, "-q", "-o", tmp_path / name, "--resolution", f"{size[0]}x{size[1]}",
                *options.split())
        assert written == (tmp_path / name).read_bytes()


def test_reference_is_the_command_lines(blobs, command, tmp_path):
    image = psivox.reference(blobs, resolution=(24, 16), look="plain")
    command("render", blobs, "-q", "-o", tmp_path / "a.exr", "--resolution", "24x16",
            "--renderer", "reference", "--look", "plain")
    assert psivox.compare(image, tmp_path / "a.exr").max == 0
    march = psivox.render(blobs, resolution=(24, 16), look="plain", tolerance=1e-4)
    assert psivox.compare(march, image).rms < 1e-4  # what the tolerance promises


def test_keywords_are_the_options(command):
    options = command("render", "--help-all")
    for name, row in psivox.parameters().items():
        assert re.search(rf"--{name.replace('_', '-')}\b", options)
        assert name in inspect.signature(psivox.render).parameters
        assert f"    {name}:" in psivox.render.__doc__


def test_types_are_complete():
    with open(psivox.__file__ + "i", encoding="utf-8") as file:
        tree = ast.parse(file.read())
    defined = {node.name: node for node in tree.body if hasattr(node, "name")}
    assert set(psivox.__all__) <= set(defined)
    assert {row.target.id for row in defined["Scene"].body} == set(psivox.parameters())


def test_arrays_of_a_picture(blobs):
    image = psivox.render(blobs, resolution=SMALL, look="plain", aov="transmittance")
    pixels = np.asarray(image)
    assert pixels.shape == image.shape == (32, 48, 4) and pixels.dtype == np.float32
    assert np.shares_memory(pixels, np.asarray(image)) and not pixels.flags.writeable
    assert np.array_equal(np.frombuffer(memoryview(image), "f4"), pixels.ravel())
    assert image.layers == ["transmittance"]
    # A is 1 - transmittance, both rounded to float32
    assert np.abs(image["A"] + image["transmittance"] - 1).max() <= 2**-23
    assert np.array_equal(image["G"], pixels[:, :, 1])
    layer = image["transmittance"]
    del image, pixels
    assert layer.shape == (32, 48) and np.isfinite(layer).all()


def test_deep_samples(blobs):
    image = psivox.render(blobs, resolution=SMALL, look="plain", aov="deep", tolerance=1e-3)
    counts, samples = image["deep"]
    assert image.layers == ["deep"]
    assert counts.shape == (32, 48) and samples.shape == (counts.sum(), 6)
    z, z_back, alpha = samples[:, 0], samples[:, 1], samples[:, 5]
    assert (z < z_back).all() and (0 <= alpha).all() and (alpha < 1).all()
    pixel = np.repeat(np.arange(counts.size), counts.ravel())
    through = np.ones(counts.size)
    np.multiply.at(through, pixel, 1 - alpha.astype("f8"))
    assert np.abs(1 - through - image["A"].ravel()).max() < 1e-6


def test_layers_are_refused(blobs, refused):
    image = psivox.render(blobs, resolution=SMALL)
    assert "aov=['depth']" in refused(2, lambda: image["depth"])
    assert "transmittance" in refused(2, lambda: image["transmitance"])
    assert "did you mean depth" in refused(2, psivox.render, blobs, aov="deepth")


def test_png_of_a_notebook(blobs):
    png = psivox.render(blobs, resolution=SMALL)._repr_png_()
    assert png.startswith(b"\x89PNG") and len(png) > 500


def test_page(blobs, refused, tmp_path):
    page = psivox.show(blobs, resolution=SMALL, credit="A < B", azimuth=20)
    image = psivox.render(blobs, resolution=SMALL, azimuth=20)
    # a page always has codes: each of the two keeps the tolerance
    assert psivox.compare(image, page.image).rms < 2e-3
    page.write(tmp_path / "x.html")
    assert (tmp_path / "x.html").read_text() == page.html
    assert page.html.startswith("<!DOCTYPE html>") and "A \\u003c B" in page.html
    assert page._repr_html_().startswith("<iframe srcdoc=")
    assert "above page_limit" in refused(2, psivox.show, blobs, resolution=SMALL, page_limit=0.01)
    assert "no holdout" in refused(2, psivox.show, blobs, resolution=SMALL, holdout="x.exr")
    for write in page.write, image.page:
        assert "a page is an .html" in refused(2, write, tmp_path / "x.png")
    assert not (tmp_path / "x.png").exists()
    image.page(tmp_path / "y.html", credit="A < B")
    assert (tmp_path / "y.html").read_text() == page.html


def test_the_scene_draws_the_picture_again(blobs):
    image = psivox.render(blobs, resolution=SMALL, elevation=20)
    again = psivox.render(blobs, scene=image.scene)
    assert image.scene["resolution"] == list(SMALL)
    assert psivox.compare(image, again).max == 0


def test_several_volumes(blobs):
    image = psivox.render(blobs, resolution=SMALL, volumes=[f"{blobs} translate=1,0,0 extinction=2"])
    again = psivox.render(blobs, scene=image.scene)
    assert image.scene["volumes"][0].startswith(f"{blobs} translate=1,0,0 extinction=2")
    assert psivox.compare(image, again).max == 0


def test_lattices_that_share_faces(tmp_path):
    """Rays that are almost in a face of both lattices cross it as all others do."""
    values = np.ones((13, 13, 13), "f4")
    colors = np.random.default_rng(0).random((6, 6, 6, 3), "f4")
    origin = (0.62618988, 1.19474907, -0.49055802)
    image = psivox.render(
        {"density": psivox.field(values, origin=origin),
         "L": psivox.field(colors, voxel_size=2.4, origin=origin)},
        look="plain", grid="density", luminance_grid="L", extinction=2.5 / 12,
        integrator="cell-exact", resolution=(128, 128), fov=40, aov=["steps"],
        camera_position=(-0.7426324327397404, 8.405780672309831, -13.107136514692368),
        camera_target=(6.626189875051028, 7.194749070196598, 5.509441977403456))
    assert image.notices == []
    # as many as the faces that a ray crosses: 3 x (13 + 6) at most
    assert 30 < image["steps"].max() <= 57


def test_a_transparent_picture_stays_so_beside_an_opaque_file(blobs, tmp_path):
    image = psivox.render(blobs, resolution=SMALL, look="surface")
    before = np.array(image)
    image.write(tmp_path / "a.png")
    assert np.array_equal(before, np.asarray(image))


def test_errors_are_estimated_and_checked(blobs):
    image = psivox.render(blobs, resolution=SMALL, tolerance=1e-3, check_error=50)
    assert image.estimate["reached"] and image.estimate["rms"] <= 1e-3
    assert image.checked["pixels"] > 0 and image.checked["rms"] < 2e-3


def test_compare():
    a = np.zeros((4, 5, 4), "f4")
    b = a.copy()
    b[1, 2, 0] = 0.5
    found = psivox.compare(a, b)
    assert found.rms == pytest.approx(0.5 / np.sqrt(80)) and found.max == 0.5
    assert (found.max_x, found.max_y, found.max_channel) == (2, 1, "R")


def test_compare_refuses(refused, tmp_path):
    refused(3, psivox.compare, np.zeros((4, 5, 4)), np.zeros((5, 4, 4)))
    refused(2, psivox.compare, np.zeros((4, 5)), np.zeros((4, 5)))
    refused(3, psivox.compare, tmp_path / "none.exr", np.zeros((4, 5, 4)))


def test_study(blobs):
    rows = psivox.study(blobs, resolution=(16, 16), integrators=["psi-weighted", "porter-duff"],
                        samplings="cells", segments=[1, 2], repeats=1, split=False)
    assert len(rows) == 4
    assert {row["integrator"] for row in rows} == {"psi-weighted", "porter-duff"}
    assert all(0 < row["rms"] < 1 for row in rows)


def test_study_of_other_renderers(blobs, refused, tmp_path):
    scene = {"resolution": (16, 16), "integrator": "midpoint", "step": 1, "look": "plain"}
    psivox.render(blobs, **scene).write(tmp_path / "theirs.exr")
    lists = {"resolution": (16, 16), "integrators": "midpoint", "samplings": "uniform", "steps": 1,
             "look": "plain", "repeats": 1, "split": False}
    own, theirs, timed = psivox.study(
        blobs, add={"peer 1": tmp_path / "theirs.exr", "peer 2": (tmp_path / "theirs.exr", 2.5)},
        **lists)
    assert [row["renderer"] for row in (own, theirs, timed)] == ["psivox", "peer 1", "peer 2"]
    assert own["rms"] == theirs["rms"] and theirs["wall_ms_median"] is None
    assert timed["wall_ms_median"] == 2.5
    refused(2, psivox.study, blobs, add={"a/b": tmp_path / "theirs.exr"}, **lists)
    refused(3, psivox.study, blobs, add={"peer": tmp_path / "none.exr"}, **lists)


def test_devices():
    for device in psivox.devices():
        assert {"index", "renderer", "problem", "software"} <= set(device)


def test_progress(blobs):
    seen = []
    psivox.render(blobs, resolution=SMALL, progress=seen.append)
    assert seen == sorted(seen) and seen[0] == 0 and seen[-1] == 1
    assert 0.5 in seen  # the light of the look is half of the work

    class Bar:  # as tqdm's
        total, n, closed = 50, 0, False

        def update(self, by):
            self.n += by

        def close(self):
            self.closed = True
    bar = Bar()
    psivox.render(blobs, resolution=SMALL, progress=bar)
    assert bar.n == pytest.approx(50) and bar.closed


def test_an_exception_in_progress_ends_the_picture(blobs, refused):
    def stop(fraction):
        raise KeyError("enough")
    with psivox.Session(blobs) as session:
        for again in session.close, session.render:  # would wait for themselves
            refused(2, session.render, resolution=SMALL, progress=lambda fraction: again())
        with pytest.raises(KeyError):
            session.render(resolution=SMALL, progress=stop)
        assert session.render(resolution=SMALL).shape == (32, 48, 4)


def test_wrong_keywords(blobs, refused):
    assert "did you mean extinction" in refused(2, psivox.render, blobs, extintion=3)
    assert "extinction does that" in refused(2, psivox.render, blobs, absorb=3)
    assert "aov does that" in refused(2, psivox.render, blobs, passes=3)
    assert refused(2, psivox.render, blobs, early_termination=2).startswith("early_termination ")
    assert "isosurface" in refused(2, psivox.render, blobs, mode="isosurfaces")
    refused(2, psivox.render, blobs, step=1, tolerance=1e-3)
    refused(2, psivox.render, blobs, fov=object())
    refused(2, psivox.render, blobs, progress=3)
    refused(2, psivox.render, blobs, camera_position=(1, float("nan"), 0))
    for name, value in [("aov", 3), ("check_error", -1), ("check_error", "x"),
                        ("scene", 3), ("scene", {"fov": object()})]:
        refused(2, psivox.render, blobs, **{name: value})
    assert len(refused(2, psivox.render, blobs, step=1, volumes=[np.zeros((9, 9))])) < 80
    refused(2, psivox.show, blobs, page_limit="x")
    refused(2, psivox.study, blobs, repeats=0)
    assert "mean aov" not in refused(2, psivox.study, blobs, aov="depth")
    scene = {"azimuth": np.float32(30), "camera-target": np.zeros(3)}
    assert psivox.render(blobs, resolution=SMALL, aov=None, scene=scene).layers == []


def test_a_picture_stays_itself(blobs, refused):
    image = psivox.render(blobs, resolution=SMALL, light=(0, -1, 0, "orange"))
    assert image.scene["light"][3:] == [1, pytest.approx(0.376, abs=1e-3), 0]  # one light
    assert copy.copy(image) is image and copy.deepcopy({"a": image})["a"] is image
    for kept in image, psivox.open(blobs)["density"]:
        with pytest.raises(TypeError, match="numpy.asarray"):
            pickle.dumps(kept)
    refused(2, psivox.render, image)  # no volume
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the scene's tolerance is none of the reference's
        psivox.reference(blobs, scene={**image.scene, "camera_position": (0, 0, 9)})
    nothing = psivox.compare(image, np.full(image.shape, np.nan))
    assert np.isnan([nothing.rms, nothing.max]).all() and nothing.not_finite == 32 * 48


def test_other_errors(blobs, refused, tmp_path):
    image = psivox.render(blobs, resolution=SMALL)
    refused(5, image.write, tmp_path / "none" / "a.exr")
    assert ".exr" in refused(2, image.write, tmp_path / "a.xyz")
    refused(6, psivox.render, blobs, resolution=(65536, 65536))
    refused(4, psivox.render, blobs, device=900)
    refused(3, psivox.render, blobs, camera=tmp_path / "none.gltf")
    refused(3, psivox.render, blobs, scene=tmp_path / "none.json")


def test_an_array_with_values_below_zero_ends_at_its_voxels():
    hounsfield = np.full((8, 8, 8), -1000, "f4")
    hounsfield[3:5, 3:5, 3:5] = 40
    for how in ({"mode": "isosurface", "isovalue": -300}, {"mode": "mip"}):
        image = psivox.render(hounsfield, resolution=SMALL, **how)
        clipped = psivox.render(hounsfield, resolution=SMALL, **how, clip=(0, 0, 0, 7, 7, 7))
        assert not image.notices
        seen = np.asarray(image)[..., 3] > 0
        assert 0 < seen.sum() < 0.3 * seen.size  # of a cube of two voxels, not of eight
        assert psivox.compare(image, clipped).max < 1e-6
    # the camera sees what a surface below 0 encloses
    how = {"resolution": SMALL, "mode": "isosurface"}
    cameras = [
        psivox.render(hounsfield + more, isovalue=more - 300, **how).scene["camera-position"]
        for more in (0, 1000)
    ]
    assert cameras[0] == cameras[1]


def test_notices_are_warnings():
    values = np.full((8, 8, 8), 0.5, "f4")
    values[2, 2, 2] = np.nan
    for draw in psivox.render, lambda *source, **scene: psivox.Session(*source).render(**scene):
        with pytest.warns(UserWarning, match="1 NaN value taken as no data") as caught:
            image = draw(values, resolution=SMALL)
        assert caught[0].filename == __file__
    assert any("NaN" in notice for notice in image.notices)
