"""NIfTI files as nibabel reads them, and the recipes for other modules."""

import glob
import os
import re

import numpy as np
import pytest

import psivox

SMALL = (32, 18)
# Debian's nibabel and mricron-data
FOLDERS = ["tests/data/*.nii*", "/usr/share/mricron/templates/*.nii.gz"]


def scan_files(nibabel):
    own = os.path.dirname(nibabel.__file__)
    return [path for folder in FOLDERS for path in sorted(glob.glob(os.path.join(own, folder)))
            if os.path.getsize(path) < 1e6]


def dense(field, shape):
    """The whole array of a field, whose own is that of its active box."""
    values = np.zeros(shape, np.float32)
    low = field.index_min
    part = np.asarray(field)
    values[tuple(slice(a, a + n) for a, n in zip(low, part.shape))] = part
    return values


def expect_as_nibabel(nibabel, path):
    image = nibabel.load(path)
    shape = (tuple(image.dataobj.shape) + (1, 1))[:3]
    file = psivox.open(path)
    values = np.asarray(image.dataobj)
    colours = values.dtype.names is not None
    if colours:
        values = np.stack([values[name] for name in "RGB"], axis=-1)
    with np.errstate(over="ignore"):
        values = values.astype(np.float64).astype(np.float32)
    values = values.reshape(shape + (-1,), order="F")
    names = list(file)
    assert colours or len(names) == values.shape[3]
    for n in sorted({0, len(names) // 2, len(names) - 1}):
        field = file[names[n]]
        assert np.array_equal(field.world_from_index, image.affine), path
        wanted = values if colours else values[..., n]
        if not wanted.any():
            continue
        got = dense(field, wanted.shape)
        assert np.array_equal(got, np.where(np.isfinite(wanted), wanted, got)), path


def test_files_are_as_nibabel_reads_them():
    nibabel = pytest.importorskip("nibabel", reason="no nibabel (python3-nibabel)")
    files = scan_files(nibabel)
    assert len(files) > 5
    for path in files:
        if path.endswith(".dconn.nii"):
            continue  # a matrix of connections, not a scan: nibabel gives it no affine
        expect_as_nibabel(nibabel, path)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", ["u1", "i1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"])
def test_made_files_are_as_nibabel_reads_them(tmp_path, order, kind):
    nibabel = pytest.importorskip("nibabel", reason="no nibabel (python3-nibabel)")
    random = np.random.RandomState(3)
    for made in (nibabel.Nifti1Image, nibabel.Nifti2Image, nibabel.Nifti1Pair):
        for form in ("sform", "qform", "none"):
            values = (random.rand(9, 10, 17, 2) * 120).astype(order + kind)
            turn, _ = np.linalg.qr(random.rand(3, 3))
            affine = np.eye(4)
            affine[:3, :3] = turn @ np.diag([1, 2, 3.5])
            affine[:3, 3] = random.rand(3) * 100
            header = made.header_class(endianness=order)
            image = made(values, None, header, dtype=values.dtype)
            image.header.set_zooms((1.5, 2, 3, 1))
            if form == "sform":
                image.set_sform(affine, 1)
            elif form == "qform":
                image.set_qform(affine, 1)
            image.header.set_slope_inter(0.37, -5)
            path = str(tmp_path / ("a.hdr" if made is nibabel.Nifti1Pair else "a.nii.gz"))
            nibabel.save(image, path)
            if form == "qform":
                expect_affine_of_nibabel(nibabel, path)
            else:
                expect_as_nibabel(nibabel, path)


def expect_affine_of_nibabel(nibabel, path):
    got, wanted = psivox.open(path)["image[0]"].world_from_index, nibabel.load(path).affine
    # both compute in float64; the order of their sums differs
    assert np.allclose(got, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def recipes():
    docs = os.path.join(os.environ["PSIVOX_ASSETS"], "..", "docs", "interchange.md")
    with open(docs, encoding="utf-8") as file:
        return re.findall("```python\n(.*?)```", file.read(), re.S)


def run_recipe(module, tmp_path, monkeypatch):
    draw = psivox.render
    monkeypatch.setattr(psivox, "render", lambda source, **options: draw(
        source, resolution=SMALL, **options))
    monkeypatch.chdir(tmp_path)
    found = [block for block in recipes() if f"import {module}, " in block]
    assert len(found) == 1
    names = {}
    exec(found[0], names)
    assert os.path.exists("head.png")
    return names["volume"]


def test_recipe_for_nibabel(tmp_path, monkeypatch):
    nibabel = pytest.importorskip("nibabel", reason="no nibabel (python3-nibabel)")
    affine = np.array([[0, -2, 0, 7], [1, 0, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1.0]])
    values = np.random.RandomState(1).rand(5, 6, 7).astype("f4")
    nibabel.save(nibabel.Nifti1Image(values, affine), tmp_path / "head.nii")
    nibabel.save(nibabel.MGHImage(values, affine), tmp_path / "head.mgz")
    volume = run_recipe("nibabel", tmp_path, monkeypatch)
    assert np.allclose(volume.world_from_index, affine)
    assert np.array_equal(np.asarray(volume), np.asarray(psivox.open("head.nii")["image"]))


def test_recipe_for_pydicom(tmp_path, monkeypatch):
    pydicom = pytest.importorskip("pydicom", reason="no pydicom (python3-pydicom)")
    values = np.random.RandomState(1).randint(1, 4000, (5, 6, 7)).astype("u2")  # x, y, z
    for k in range(7):
        slice_ = pydicom.Dataset()
        slice_.file_meta = pydicom.dataset.FileMetaDataset()
        slice_.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
        slice_.file_meta.MediaStorageSOPClassUID = pydicom.uid.CTImageStorage
        slice_.file_meta.MediaStorageSOPInstanceUID = pydicom.uid.generate_uid()
        slice_.is_little_endian, slice_.is_implicit_VR = True, False
        slice_.Rows, slice_.Columns = 6, 5
        slice_.SamplesPerPixel, slice_.PhotometricInterpretation = 1, "MONOCHROME2"
        slice_.BitsAllocated = slice_.BitsStored = 16
        slice_.HighBit, slice_.PixelRepresentation = 15, 0
        slice_.PixelSpacing, slice_.RescaleSlope, slice_.RescaleIntercept = [3, 2], 1, -1024
        slice_.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        slice_.ImagePositionPatient = [10, 20, 4 * k]
        slice_.PixelData = values[:, :, k].T.tobytes()
        os.makedirs(tmp_path / "series", exist_ok=True)
        slice_.save_as(tmp_path / "series" / f"{9 - k}.dcm", write_like_original=False)
    volume = run_recipe("pydicom", tmp_path, monkeypatch)
    assert np.allclose(volume.world_from_index,
                       [[-2, 0, 0, -10], [0, -3, 0, -20], [0, 0, 4, 0], [0, 0, 0, 1]])
    assert np.array_equal(dense(volume, (5, 6, 7)), values.astype("f4") - 1024)


def test_recipe_for_tifffile(tmp_path, monkeypatch):
    tifffile = pytest.importorskip("tifffile", reason="no tifffile (python3-tifffile)")
    values = np.random.RandomState(1).randint(1, 200, (7, 6, 5)).astype("u1")  # z, y, x
    tifffile.imwrite(tmp_path / "stack.tif", values)
    volume = run_recipe("tifffile", tmp_path, monkeypatch)
    assert np.array_equal(np.asarray(volume), values.T)


def test_a_transform_is_checked(refused):
    values = np.ones((3, 3, 3), "f4")
    assert np.array_equal(psivox.field(values, transform=np.diag([2, 3, 4, 1])).voxel_size,
                          (2, 3, 4))
    for wrong in (np.eye(3), np.full((4, 4), np.nan), np.diag([1, 1, 1, 2.0]), "x"):
        assert "transform" in refused(2, psivox.field, values, transform=wrong)
    refused(2, psivox.field, values, voxel_size=2, transform=np.eye(4))
    refused(3, psivox.field, values, transform=np.diag([1, 1, 0, 1.0]))


def test_a_study_of_a_frame(tmp_path):
    header = np.zeros(352, "u1")
    header[:4].view("<i4")[:] = 348
    header[40:56].view("<i2")[:] = 4, 8, 8, 8, 3, 1, 1, 1
    header[70:74].view("<i2")[:] = 16, 32  # float32
    header[76:96].view("<f4")[:] = 1
    header[108:112].view("<f4")[:] = 352
    header[344:347] = list(b"n+1")
    values = np.random.default_rng(0).random(3 * 8**3, dtype="f4")
    path = tmp_path / "film.nii"
    path.write_bytes(header.tobytes() + values.tobytes())
    rows = psivox.study(f"{path}[1]", steps=1, integrators="midpoint", samplings="uniform",
                        repeats=1, split=False, resolution=(16, 9))
    assert len(rows) == 1
