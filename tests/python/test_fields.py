"""Volumes from arrays and files."""

import ctypes
import gc
import os
import re
import shutil
import weakref

import numpy as np
import pytest

import psivox

SMALL = (48, 32)


@pytest.fixture(scope="module")
def cloud():
    """Two blobs, 0 around them."""
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n) for n in (21, 18, 30)], indexing="ij")
    values = np.maximum(0, 0.6 - (x + 0.2)**2 - y**2 - z**2) + (np.abs(z - 0.7) < 0.1) * (x > 0.5)
    return values.astype("f4")


def picture(array, **keywords):
    return np.array(psivox.render(array, resolution=SMALL, **keywords))


@pytest.fixture(scope="module")
def of_cloud(cloud):
    pixels = picture(cloud)
    assert pixels[:, :, 3].max() > 0.3
    return pixels


def test_an_array_is_the_grid_that_it_came_from(blobs):
    """Every bit of the picture, where both have their voxels at the same indices."""
    grid = psivox.open(blobs)["density"]
    values = np.asarray(grid)
    assert values.shape == grid.shape
    at_index = np.pad(values, [(first, 0) for first in grid.index_min])
    again = psivox.field(at_index, voxel_size=grid.voxel_size,
                         origin=grid.world_from_index[:3, 3])
    assert np.array_equal(np.asarray(again), values) and again.index_min == grid.index_min
    a = psivox.render({"density": grid}, resolution=(96, 64))
    b = psivox.render(again, resolution=(96, 64))
    assert psivox.compare(a, b).max == 0


@pytest.mark.parametrize("change", [
    lambda a: np.asfortranarray(a),
    lambda a: a.astype(">f4"),
    lambda a: a.astype("f8"),
    lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    lambda a: a[::-1, :, ::-1][::-1, :, ::-1],
    lambda a: np.ascontiguousarray(a.transpose(2, 0, 1)).transpose(1, 2, 0),
    lambda a: np.ma.masked_array(a),
    lambda a: memoryview(a),
])
def test_layouts(cloud, of_cloud, change):
    assert np.array_equal(picture(change(cloud)), of_cloud)


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", ">u2", "i4", "i8", "u8", "f2", "bool"])
def test_types(cloud, dtype):
    whole = np.round(cloud * 3)
    if dtype == "bool":
        whole = np.minimum(whole, 1)
    assert np.array_equal(picture(whole.astype(dtype)), picture(whole))


def test_masked_voxels_are_empty(cloud):
    masked = np.ma.masked_array(cloud, mask=cloud > 0.3)
    assert np.array_equal(picture(masked), picture(np.where(cloud > 0.3, 0, cloud)))


def test_a_freed_array(cloud, of_cloud):
    copy = cloud.copy()
    grid = psivox.field(copy, copy=True)
    copy[:] = 7
    del copy
    gc.collect()
    assert np.array_equal(picture(grid), of_cloud)


def test_an_array_lives_as_long_as_its_field(cloud, of_cloud):
    copy = cloud.copy()
    array = weakref.ref(copy)
    grid = psivox.field(copy)
    with pytest.raises(ValueError, match="resize"):
        copy.resize(7)
    del copy
    gc.collect()
    with psivox.Session(grid, resolution=SMALL) as session:
        del grid
        assert np.array_equal(np.asarray(session.render()), of_cloud)
    del session
    gc.collect()
    assert array() is None


def allocated():
    """Memory that malloc has given out [bytes]."""
    class Mallinfo2(ctypes.Structure):
        _fields_ = [(name, ctypes.c_size_t) for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks",
            "fordblks", "keepcost")]
    if not hasattr(ctypes.CDLL(None), "mallinfo2"):
        pytest.skip("no mallinfo2 (glibc 2.33)")
    function = ctypes.CDLL(None).mallinfo2
    function.restype = Mallinfo2
    info = function()
    return info.uordblks + info.hblkhd


@pytest.mark.parametrize("order", ["C", "F"])
def test_a_field_takes_no_memory_for_values(order):
    array = np.asarray(np.random.default_rng(1).random((128, 128, 128), dtype="f4"), order=order)
    before = allocated()
    grid = psivox.field(array)
    in_place = allocated() - before
    copied = psivox.field(array, copy=True)
    with_copy = allocated() - before - in_place
    # a leaf's place takes 24 bytes, in a vector that may be twice as long; its values 2048
    assert in_place < 0.05 * array.nbytes and with_copy > array.nbytes
    assert grid.active_voxels == copied.active_voxels


@pytest.mark.parametrize("keywords", [
    {"look": "smoke"}, {"look": "scan"}, {"mode": "isosurface", "isovalue": 0.3},
    {"colormap": "viridis", "range": ("1%", "99%"), "classification": "pre"},
    {"colormap": "plasma", "opacity": [(0.1, 0), (1, 2)]}, {"renderer": "march-double", "step": 2},
    {"mode": "slice", "slice": "z=15"}, {"renderer": "reference"}, {"lod": 1},
    {"transfer_function": "gradient.json"}, {"light": (0, -1, 0), "luminance_grid": "density"},
    {"memory_limit": "180M"},
])
@pytest.mark.filterwarnings("ignore:.*lod")
def test_in_place_and_copied_draw_alike(cloud, tmp_path, monkeypatch, keywords):
    """Every bit, whatever reads the values."""
    monkeypatch.chdir(tmp_path)
    with open("gradient.json", "w", encoding="ascii") as file:
        file.write('{"gradients": [0, 0.2], "points": [{"value": 0, "attenuation": [0, 0]},'
                   ' {"value": 1, "attenuation": [0.5, 3]}]}')
    values = np.asfortranarray(np.pad(cloud, 3))
    assert np.array_equal(picture(psivox.field(values), **keywords),
                          picture(psivox.field(values, copy=True), **keywords))


def test_array_of_a_field(cloud):
    grid = psivox.field(cloud, voxel_size=(1, 2, 3), origin=(5, 6, 7), name="smoke")
    first = np.array(grid.index_min)
    part = tuple(slice(a, a + n) for a, n in zip(first, grid.shape))
    assert np.array_equal(np.asarray(grid), cloud[part])
    assert grid.active_voxels == np.count_nonzero(cloud) == np.count_nonzero(cloud[part])
    assert grid.name == "smoke" and grid.voxel_size == (1, 2, 3)
    assert grid.origin == tuple(np.array([5, 6, 7]) + first * [1, 2, 3])


def test_place(cloud):
    """voxel_size and origin: a sphere of 0.5 voxels' worth of light moves with its camera."""
    a = picture(cloud, look="plain", camera_position=(10, 9, 100), camera_target=(10, 9, 15))
    grid = psivox.field(cloud, voxel_size=2, origin=(-4, 8, 0))
    b = picture(grid, look="plain", camera_position=(16, 26, 200), camera_target=(16, 26, 30))
    # lengths are doubled and auto halves the extinction: the same but for rounding
    assert np.abs(a - b).max() < 1e-5 and a[:, :, 3].max() > 0.3


def test_vectors(cloud):
    vectors = np.stack([cloud, -2 * cloud, 0 * cloud], axis=3)
    # the length, of which each side rounds another way
    mapped = {"look": "plain", "colormap": "viridis", "range": (0, 1)}
    length = picture(vectors, **mapped)
    assert np.abs(picture(np.sqrt(5) * cloud, **mapped) - length).max() < 1e-5
    grid = psivox.field(vectors, name="v")
    assert grid.channels == 3 and grid.shape[3] == 3
    x = picture(grid, grid="v:x", **mapped)
    assert np.array_equal(x, picture(cloud, **mapped))


def test_odd_names(cloud, blobs, refused):
    file = psivox.open(blobs)
    assert "density" in file and "\udcff" not in file
    assert psivox.render(file["temperature"], grid=None,
                         resolution=(8, 8)).scene["grid"] == "temperature"
    refused(3, lambda: file["\udcff"])
    refused(2, psivox.field, cloud, name="\udcff")
    refused(2, psivox.render, {"\udcff": cloud})


def test_grids_by_name(cloud, blobs):
    alone = picture(cloud, look="plain")
    both = {"density": cloud, "glow": 2 * cloud}
    assert np.array_equal(picture(both, look="plain"), alone)
    lit = picture(both, luminance_grid="glow", extinction=0.5)
    assert np.array_equal(lit, picture({"density": cloud, "other": cloud}, luminance_grid="other",
                                       luminance_scale=2, extinction=0.5))
    mixed = {"density": psivox.open(blobs)["density"], "glow": cloud}
    assert picture(mixed, emission_grid="glow").max() > 0


@pytest.mark.parametrize("array", [
    np.zeros((0, 3, 3)), np.zeros((3, 3)), np.zeros((3, 3, 3, 2)), np.zeros((2, 2, 2, 2, 2)),
    np.zeros((3, 3, 3), complex), np.zeros((3, 3, 3), "U3"), np.zeros((3, 3, 3), object),
    np.zeros((3, 3, 3)), np.full((3, 3, 3), np.nan), 5, None, [[1, 2], [3]],
])
def test_refused_arrays(array, refused):
    def draw():
        image = psivox.render(array, resolution=SMALL, strict=True)
        return image
    with pytest.raises(psivox.Error) as raised:
        draw()
    assert raised.value.exit_code in (2, 3) and "\n" not in str(raised.value)


def test_refused_places(cloud, refused):
    refused(2, psivox.field, cloud, voxel_size=0)
    refused(2, psivox.field, cloud, voxel_size=(1, 2))
    assert "beyond 1e75" in refused(3, psivox.field, cloud, origin=(1e300, 0, 0))
    refused(2, psivox.field, cloud, origin="there")
    refused(2, psivox.field, cloud, origin=(0, np.inf, 0))
    refused(2, psivox.render, {})


def test_infinity_and_negative_values(cloud):
    bad = cloud.astype("f8")
    bad[3, 3, 3], bad[4, 4, 4], bad[5, 5, 5] = 1e300, -1, np.inf
    good = cloud.copy()
    good[3, 3, 3] = good[5, 5, 5] = cloud.max()
    good[4, 4, 4] = 0
    with pytest.warns(UserWarning, match="1 negative value taken as 0; 2 .Inf taken as"):
        pixels = picture(bad, look="plain")
    assert np.array_equal(pixels, picture(good, look="plain"))


def test_many_voxels_of_one_value_take_no_memory():
    """Through strides of 0: 2^24 voxels, as tiles."""
    values = np.broadcast_to(np.float32(1), (256, 256, 256))
    grid = psivox.field(values)
    assert grid.active_voxels == 256**3
    pixels = picture(grid, look="plain", projection="orthographic", extinction=1 / 256)
    # the value falls to 0 over a voxel before the first and behind the last: depth 255 + 2/2
    assert pixels[16, 24, 3] == pytest.approx(1 - np.exp(-1), abs=1e-3)


def test_files(blobs, refused, tmp_path):
    file = psivox.open(blobs)
    assert list(file) == ["density", "temperature", "color"] and len(file) == 3
    assert "density" in file and file["color"].channels == 3
    assert np.array_equal(picture(file), picture(blobs))
    assert np.array_equal(picture(file["temperature"]), picture(blobs, grid="temperature"))
    assert "did you mean density" in refused(3, lambda: file["densty"])
    assert file.get("densty") is None and file.get("density").shape == file["density"].shape
    refused(3, lambda: file[3])
    frames = tmp_path / "frames.nrrd"
    frames.write_text("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 1 1 2\nencoding: text\n"
                      "kinds: domain domain domain list\n\n1 2 3 4\n")
    assert psivox.open(frames)["image"].shape == (2, 1, 1)  # the first of several, as --grid has it
    refused(3, psivox.open, tmp_path / "none.vdb")
    refused(3, psivox.info, tmp_path)


def test_names_of_files_are_bytes(blobs, refused, tmp_path):
    path = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.vdb")
    shutil.copy(blobs, path)
    assert np.array_equal(picture(path), picture(blobs))
    assert "/\\xff.vdx: no such file" in refused(3, psivox.open, path[:-1] + "x")
    assert "zero byte" in refused(2, psivox.open, blobs + "\0")
    assert "expected the name of a file" in refused(2, psivox.info, 3)
    for file in blobs, psivox.open(blobs):
        assert "psivox.open" in refused(2, psivox.render, {"density": file})


def test_info(blobs, command):
    import json
    assert psivox.info(blobs) == json.loads(command("info", "--json", blobs))


def test_damaged_files(blobs, refused, tmp_path):
    """Read in a process of its own: a crash there is an error here."""
    from psivox import _core
    data = open(blobs, "rb").read()
    path = tmp_path / "bad.vdb"
    random = np.random.RandomState(1)
    for cut in (10, 200, len(data) // 2):
        path.write_bytes(data[:cut])
        refused(3, psivox.render, path, resolution=SMALL)
    for _ in range(5):
        changed = bytearray(data)
        for at in random.randint(300, len(data), 40):
            changed[at] = random.randint(256)
        path.write_bytes(changed)
        try:
            psivox.render(path, resolution=(4, 4))
        except psivox.Error as error:
            assert error.exit_code in (3, 6)
    assert _core.reading_guard() != "nothing"


def test_documented_exchange(tmp_path, monkeypatch):
    """The code of docs/interchange.md, and that its file draws as its array."""
    assets = os.environ["PSIVOX_ASSETS"]
    with open(os.path.join(assets, "..", "docs", "interchange.md"), encoding="utf-8") as file:
        blocks = [block for block in re.findall("```python\n(.*?)```", file.read(), re.S)
                  if "import bpy" not in block]  # which runs within Blender
    monkeypatch.chdir(tmp_path)
    os.symlink(assets, "assets")
    names = {}
    draw = psivox.render
    monkeypatch.setattr(psivox, "render", lambda source: draw(source, resolution=SMALL))
    exec(blocks[0], names)
    pytest.importorskip("pyopenvdb", reason="no pyopenvdb (python3-openvdb)")
    exec(blocks[1] + blocks[2], names)
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    alike = psivox.field(names["array"], voxel_size=0.1)
    assert np.array_equal(picture("array.vdb"), picture(alike))
    assert np.array_equal(names["array"], psivox.open("assets/blobs.vdb")["density"])
    assert os.path.exists("scan.png") and os.path.exists("blobs.png")
