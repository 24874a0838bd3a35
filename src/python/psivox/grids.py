"""Volumes: files, their grids, and arrays."""

import collections.abc
import json
import numbers
import os

import numpy as np

from . import _core

__all__ = ["Field", "File", "field", "info", "open"]

_readers = os.path.join(os.path.dirname(os.path.abspath(__file__)), "_readers")


def hint(name, known):
    """"; did you mean extinction?", of the names that are known; empty if none is near."""
    return _core.hint(str(name).encode(errors="backslashreplace"), known)


def usage(message):
    """Raises psivox.Error with the exit code of wrong usage."""
    _core.fail(2, message.encode(errors="backslashreplace"))


def _bad_input(message):
    _core.fail(3, message.encode(errors="backslashreplace"))


def file_name(path):
    """The name of a file as the library takes it: bytes, so that any name on the disk will do."""
    try:
        name = os.fsencode(path)
    except (TypeError, ValueError):
        usage(f"{path!r}: expected the name of a file")
    if b"\0" in name:
        usage(f"{path!r}: a file's name has no zero byte")
    return name


def _is_text(name):
    try:
        name.encode()
    except UnicodeEncodeError:  # surrogates
        return False
    return True


def _grid_name(name):
    if not _is_text(str(name)):
        usage(f"{name!r}: a grid's name is text that UTF-8 can hold")
    return str(name)


def kept_as_it_is(kind, advice):
    """Members of a class whose instances are never changed, and hold what no pickle can."""
    def reduce(self, protocol=None):
        raise TypeError(f"cannot pickle {kind}: {advice}")
    return {"__copy__": lambda self: self, "__deepcopy__": lambda self, memo: self,
            "__reduce_ex__": reduce}


def whole_number(value, name, least, most=2**31 - 1):
    """The value as an int, or psivox.Error."""
    if not isinstance(value, numbers.Integral) or not least <= value <= most:
        usage(f"{name} {value!r}: expected a whole number from {least} to {most}")
    return int(value)


def positive_number(value, name):
    """The value as a float, or psivox.Error."""
    if not isinstance(value, numbers.Real) or not 0 < value < float("inf"):
        usage(f"{name} {value!r}: expected a number above 0")
    return float(value)


def _open_file(path):
    name = file_name(path)
    _core.start_guarded_reading(_readers)
    return _core.File(name)


class Field:
    """One grid: of a file (`psivox.open`) or of an array (`psivox.field`).

    `numpy.asarray(field)` is a float32 array of its active box: x, y, z, and for vectors x, y or z
    of the value last. A level set is converted to fog.
    """

    def __init__(self, file, grid, path=""):
        self._file, self._grid, self._path, self._known = file, grid, path, None

    @property
    def _place(self):
        if self._known is None:
            self._known = self._file.place(self._grid) or _bad_input(
                f"there is no grid '{self._grid}'")
        return self._known

    @property
    def name(self):
        """The grid's name."""
        return self._grid

    @property
    def channels(self):
        """1 for scalars, 3 for vectors."""
        return self._file.channels(self._grid)

    @property
    def index_min(self):
        """The smallest active voxel (x, y, z): the first of the array [index]."""
        return self._place["min"]

    @property
    def shape(self):
        """Voxels of the active box along x, y and z; for vectors also 3."""
        low, high = self._place["min"], self._place["max"]
        size = tuple(b - a + 1 for a, b in zip(low, high))
        return size if self.channels == 1 else size + (3,)

    @property
    def voxel_size(self):
        """Lengths of a voxel along x, y and z [world units]."""
        return self._place["voxel_size"]

    @property
    def origin(self):
        """Centre of the array's first voxel (x, y, z) [world units]."""
        first = self.world_from_index @ np.array([*self.index_min, 1.0])
        return tuple(float(x) for x in first[:3])

    @property
    def world_from_index(self):
        """4 x 4: world point of an index point (x, y, z, 1)."""
        return np.array(self._place["world_from_index"]).reshape(4, 4)

    @property
    def active_voxels(self):
        """Number of active voxels; of an array, those that are not 0."""
        return self._place["active_voxels"]

    def __array__(self, dtype=None, copy=None):
        values = self._file.values(self._grid)
        return values if dtype is None else values.astype(dtype)

    vars().update(kept_as_it_is("a psivox.Field", "numpy.asarray(field) is an array that can be"))

    def __repr__(self):
        size = "x".join(map(str, self.shape[:3]))
        kind = "vectors" if self.channels == 3 else "values"
        return f"<psivox.Field '{self.name}': {size} {kind}>"


class File(collections.abc.Mapping):
    """An open file (.vdb, .nvdb, NIfTI, NRRD): a mapping from names of grids to `Field`s."""

    def __init__(self, path):
        self._file = _open_file(path)
        self._path = os.fsdecode(path)

    def __getitem__(self, name):
        if not self._has(name):
            known = ", ".join(self._file.names)
            _bad_input(f"{self._path}: there is no grid '{name}'"
                       f"{hint(name, self._file.names)}; there are: {known}")
        return Field(self._file, name, self._path)

    def _has(self, name):
        return isinstance(name, str) and (name in self._file.names or
                                          _is_text(name) and self._file.channels(name) > 0)

    def get(self, name, default=None):
        """The grid of that name, or `default`."""
        return self[name] if self._has(name) else default

    def __iter__(self):
        return iter(self._file.names)

    def __contains__(self, name):
        return self._has(name)

    def __len__(self):
        return len(self._file.names)

    def __repr__(self):
        return f"<psivox.File '{self._path}': {', '.join(self._file.names)}>"


def open(path):
    """Opens a .vdb, .nvdb, NIfTI or NRRD. `psivox.open("smoke.vdb")["density"]` is a grid, to
    render or as an array."""
    return File(path)


def info(path):
    """What `psivox info --json` tells of a file, as a dict: its grids, their boxes, values and
    transforms, and what psivox chooses for a picture."""
    name = file_name(path)
    _core.start_guarded_reading(_readers)
    return json.loads(_core.info(name))


def _three(value, name):
    try:
        numbers = np.broadcast_to(np.asarray(value, dtype=float), (3,)).tolist()
    except (TypeError, ValueError):
        usage(f"{name} {value!r}: expected one number or three")
    if not np.isfinite(numbers).all():
        usage(f"{name} {value!r}: expected finite numbers")
    return numbers


def _rows(voxel_size, origin, transform):
    """The first three rows of the matrix from index to world, row by row."""
    if transform is None:
        size = _three(voxel_size, "voxel_size")
        if min(size) <= 0:
            usage(f"voxel_size {voxel_size!r}: expected numbers above 0")
        return np.column_stack([np.diag(size), _three(origin, "origin")]).ravel().tolist()
    if not (np.isscalar(voxel_size) and voxel_size == 1) or np.any(origin):
        usage("transform says where voxels are: leave out voxel_size and origin")
    try:
        matrix = np.asarray(transform, dtype=float)
    except (TypeError, ValueError):
        usage(f"transform {transform!r}: expected 4 x 4 numbers")
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        usage(f"transform of shape {matrix.shape}: expected 4 x 4 finite numbers")
    if matrix[3].tolist() != [0, 0, 0, 1]:
        usage(f"transform: expected a last row of 0, 0, 0, 1, not {matrix[3].tolist()}")
    return matrix[:3].ravel().tolist()


def field(array, voxel_size=1.0, origin=(0.0, 0.0, 0.0), name="density", copy=False,
          transform=None):
    """A volume from an array.

    array: numbers by index [x, y, z], or [x, y, z, 3] for vectors, of any real dtype, byte order
        and strides. float32 of any strides is read in place: leave it unchanged while the field or
        a session of it is in use. Other types become float32, a copy. Voxels of value 0, and
        those that a numpy.ma array masks, are empty. NaN and Inf are replaced and reported, as
        those of a file.
    voxel_size: length of a voxel, one number or three [world units].
    origin: centre of voxel [0, 0, 0] [world units].
    name: the grid's name.
    copy: copies float32 too, so that the array may change.
    transform: 4 x 4 from index (x, y, z, 1) to world, such as nibabel's `affine`; in place of
        voxel_size and origin.
    """
    if isinstance(array, np.ma.MaskedArray):
        array = array.filled(0)
    try:
        values = np.asarray(array)
    except Exception as error:
        usage(f"no array of numbers: {error}")
    vectors = values.ndim == 4
    if values.dtype.kind not in "biuf":
        _bad_input(f"an array of {values.dtype}: expected real numbers")
    if values.ndim not in (3, 4) or (vectors and values.shape[3] != 3):
        _bad_input(f"an array of shape {values.shape}: expected (x, y, z), or (x, y, z, 3) for "
                   "vectors")
    if 0 in values.shape:
        _bad_input(f"an array of shape {values.shape} has no voxel")
    if max(values.shape[:3]) > 2**30:
        _bad_input(f"an array of shape {values.shape} is too long")
    name = _grid_name(name)
    grid = _core.DenseField(name, list(values.shape[:3]), 3 if vectors else 1,
                            _rows(voxel_size, origin, transform))
    if not copy and values.dtype == np.float32 and values.flags.aligned:
        grid.hold(values)
        return Field(grid.finish(), name)
    with np.errstate(over="ignore", invalid="ignore"):  # too large for float32: Inf, reported
        for x in range(0, values.shape[0], 8):
            grid.add(np.ascontiguousarray(values[x:x + 8], dtype=np.float32))
    return Field(grid.finish(), name)


class Source:
    """What a call draws: an open file and, if one was meant, the grid."""

    def __init__(self, source):
        self.path, self.grid = "", None
        if isinstance(source, _core.Image):
            usage("a picture is no volume: give its file, grid or array")
        if isinstance(source, (str, bytes, os.PathLike)):
            self.file = _open_file(source)
            self.path = os.fsdecode(source)
        elif isinstance(source, File):
            self.path, self.file = source._path, source._file
        elif isinstance(source, collections.abc.Mapping):
            if not source:
                usage("no grid: the dict is empty")
            fields = {_grid_name(name): as_field(value, str(name)) for name, value in source.items()}
            self.file = _core.gather([(name, one._file, one._grid) for name, one in fields.items()])
        else:
            one = as_field(source)
            self.path, self.file, self.grid = one._path, one._file, one._grid

    def scene_of(self, keywords):
        """The keywords, with the grid unless they give one."""
        if self.grid is None or keywords.get("grid") is not None:
            return keywords
        return {**keywords, "grid": self.grid}


def as_field(value, name="density"):
    """The value itself if it is a Field, else the array's."""
    if isinstance(value, (str, bytes, os.PathLike, File)):
        usage(f"{name}: expected a grid, not a file; psivox.open(path)['{name}'] is one")
    return value if isinstance(value, Field) else field(value, name=name)
