"""Pictures: drawing, measuring and comparing them."""

import collections.abc
import csv
import html
import json
import os
import tempfile
import typing
import warnings

import numpy as np

from . import _core
from .grids import (Source, file_name, hint, kept_as_it_is, positive_number, usage,
                    whole_number)
from .scene import documented, words_of

__all__ = ["Comparison", "Image", "Page", "Session", "compare", "devices", "reference", "render",
           "show", "study", "verify"]

# keywords of calls that are not the scene's
_picture_names = ("aov", "camera", "check_error", "progress")
_study_names = ("add", "camera", "folder", "progress", "repeats", "resume", "scene", "split")


def _extends(compiled):
    """Adds a class's members to a compiled class, which has the buffer protocol."""
    def add(body):
        for name, member in vars(body).items():
            if name not in ("__dict__", "__weakref__"):
                setattr(compiled, name, member)
        return compiled
    return add


@_extends(_core.Image)
class Image:
    """A picture in linear radiance, premultiplied, as an .exr holds it.

    `numpy.asarray(image)` is a float32 array of shape (height, width, 4): R, G, B and A, from the
    top left pixel. `image["transmittance"]`, or another layer of `aov`, has shape (height, width),
    and so has `image["A"]`. The arrays are not copied and cannot be written to.

    `width` and `height` [pixels]. `renderer`: the OpenGL renderer, or the name of an integrator.
    `notices`: what was not as expected, one line each. `estimate`: the estimated error where a
    tolerance chose the method, a dict of method, rms and max [radiance, opacity] and reached,
    whether the tolerance was kept; else None. `checked`: the error that `check_error` measured, a
    dict of pixels, rms, max, max_x and max_y; else None.
    """

    def __getitem__(self, name):
        if name in ("R", "G", "B", "A"):
            return np.asarray(self)[:, :, "RGBA".index(name)]
        if name == "deep" and name in self._layers:
            return self._deep()
        if name and name in self._layers:
            return self._layer(self._layers.index(name))
        if name in _core.layer_names:
            usage(f"the picture has no layer '{name}': draw it with aov=['{name}']")
        usage(f"no layer '{name}'"
              f"{hint(name, ['R', 'G', 'B', 'A', *_core.layer_names])}")

    @property
    def shape(self):
        """(height, width, 4) [pixels, channels]."""
        return (self.height, self.width, 4)

    @property
    def layers(self):
        """Names of the layers beside the picture."""
        return [name for name in self._layers if name]

    @property
    def scene(self):
        """The complete scene as a dict, which `render(source, scene=...)` draws again."""
        return json.loads(self._scene)

    def write(self, path, half=False, bits=None):
        """Writes .exr or .tif (linear), .png, .jpg or .webp (sRGB), .hdr: the file that
        `psivox render -o` writes. half: an .exr of 16-bit floats; bits: 8 or 16, of .png or .tif.
        """
        if bits is not None:
            bits = whole_number(bits, "bits", 8, 16)
        for notice in self._write(file_name(path), bool(half), bits):
            warnings.warn(notice, stacklevel=2)

    def page(self, path, *, credit="", page_limit=32):
        """Writes a page on which the picture turns, as psivox.show makes it. Draws the picture once
        more: its file or array must still be the same."""
        _page_name(path)
        show(self._source, scene=self.scene, background=self._background, credit=credit,
             page_limit=page_limit).write(path)

    def _repr_png_(self):
        with tempfile.TemporaryDirectory(prefix="psivox-") as folder:
            path = os.path.join(folder, "picture.png")
            self._write(path, False, None)
            with open(path, "rb") as file:
                return file.read()

    vars().update(kept_as_it_is("a psivox.Image", "numpy.asarray(image) is an array that can be"))

    def __repr__(self):
        layers = ", ".join(["RGBA", *self.layers])
        return f"<psivox.Image: {self.width}x{self.height}, {layers}>"


class _Progress:
    """Calls what `progress` was given: a function of the finished fraction, or tqdm."""

    def __init__(self, progress):
        self._bar, self._call, self._done = None, None, 0.0
        if progress is None:
            return
        if hasattr(progress, "update"):  # tqdm, or a bar of it
            if isinstance(progress, type):
                progress = progress(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed}")
            self._bar = progress
            self._scale = progress.total or 100
        elif callable(progress):
            self._call = progress
        else:
            usage(f"progress: expected a function or tqdm, not {type(progress).__name__}")

    @property
    def report(self):
        return self._report if self._bar is not None or self._call else None

    def _report(self, fraction):
        if self._call:
            self._call(fraction)
        elif fraction > self._done:
            self._bar.update(self._scale * (fraction - self._done))
            self._done = fraction

    def close(self):
        if self._bar is not None:
            self._bar.close()


def _layers(aov):
    if aov is None:
        return []
    names = list(aov) if np.iterable(aov) and not isinstance(aov, str) else [aov]
    for name in names:
        if name not in _core.layer_names:
            usage(f"aov: unknown layer '{name}'{hint(name, _core.layer_names)}")
    return names


class Session:
    """A volume whose pictures share its grids, its light, its atlas and an OpenGL context.

        with psivox.Session("smoke.vdb", look="smoke") as session:
            for angle in range(0, 360, 10):
                session.render(azimuth=angle).write(f"turn.{angle:03}.png")

    The look is chosen once. `render` takes every keyword of a scene; those of camera, picture and
    accuracy need no new atlas. Several threads may draw with a session, one at a time; two sessions
    draw at the same time.
    """

    def __init__(self, source, *, scene=None, camera=None, **keywords):
        """Opens a source; see psivox.render for it and for the keywords."""
        opened = Source(source)
        words = words_of(opened.scene_of(keywords), (*_picture_names, "scene"), scene, camera)
        words.settings = [("input", os.fsencode(opened.path)), *words.settings]
        self._source = source
        self._drawing = _core.Drawing(opened.file, words)

    def render(self, *, aov=(), check_error=0, progress=None, camera=None, **scene):
        """Draws the session's scene with these keywords in place of its own; see psivox.render."""
        words = words_of(scene, _picture_names, None, camera)
        return self._draw(words, aov, check_error, progress)

    def _draw(self, words, aov, check_error, progress, page=None, depth=3):
        check_error = whole_number(check_error, "check_error", 0)
        layers = _layers(aov)
        bar = _Progress(progress)
        try:
            image = self._drawing.draw(words, layers, check_error, bar.report, page)
        finally:
            bar.close()
        for notice in image.notices:
            warnings.warn(notice, stacklevel=depth)  # where `render` was called
        image._source = self._source
        return image

    def close(self):
        """Lets other sessions use the OpenGL context. Drawing again takes another."""
        self._drawing.close()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()


def render(source, *, aov=(), check_error=0, progress=None, scene=None, camera=None, **keywords):
    """Draws a picture, the one that `psivox render` draws with the same options.

    source: a .vdb's path, a grid of `psivox.open`, an array by [x, y, z] (see `psivox.field`), or a
        dict of grids and arrays by the names of grids.
    aov: extra layers: depth, transmittance, steps, samples, error, bound; or deep, a deep picture:
        image["deep"] is the number of samples of each pixel and, from front to back, their Z,
        ZBack, R, G, B and A.
    check_error: compares so many pixels with the reference; see Image.checked.
    progress: a function of the finished fraction, or tqdm.
    scene: a scene that the keywords override: a dict such as Image.scene, a .json, or a picture
        that psivox wrote.
    camera: FILE[:NAME], a camera of a .gltf, .glb or ParaView's .pvcc.
    A keyword that is None counts as not given; "auto" and "none" are values.

    Returns an Image. Ctrl-C ends the work. Raises psivox.Error.
    """
    return _render(source, aov, check_error, progress, scene, camera, keywords)


def _render(source, aov, check_error, progress, scene, camera, keywords):
    with Session(source, scene=scene, camera=camera, **keywords) as session:
        return session._draw(words_of({}), aov, check_error, progress, depth=4)


def _page_name(path):
    name = file_name(path)
    if not name.lower().endswith(b".html"):
        usage(f"cannot write {os.fspath(path)!r}: a page is an .html; psivox.render draws pictures")
    return name


class Page:
    """A page on which a picture turns, in any browser with WebGL 2; Jupyter shows it.

    `image`: the Image that it shows at rest. `html`: its text.
    """

    def __init__(self, image):
        self.image, self.html = image, image._page.decode(errors="replace")

    def write(self, path):
        """Writes the .html that `psivox render -o` writes."""
        _core.write_text(_page_name(path), self.html)

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self.html)}" width="100%" allow="fullscreen" '
                f'style="border: 0; height: {self.image.height + 80}px"></iframe>')

    def __repr__(self):
        return f"<psivox.Page: {self.image.width}x{self.image.height}, {len(self.html) / 1e6:.1f} MB>"


def show(source, *, credit="", page_limit=32, progress=None, scene=None, camera=None, **keywords):
    """Draws the picture of psivox.render and returns a Page, on which it turns. Jupyter shows it.

    credit: a line below the picture.
    page_limit: largest page [MB].
    The other keywords are those of psivox.render.
    """
    with Session(source, scene=scene, camera=camera, **keywords) as session:
        page = (str(credit), positive_number(page_limit, "page_limit"))
        return Page(session._draw(words_of({}), (), 0, progress, page))


def reference(source, *, aov=(), progress=None, scene=None, camera=None, **keywords):
    """Draws with the reference: another algorithm, in double precision on the CPU. Takes the
    keywords of `psivox.render`, but for check_error. A tolerance and a renderer in `scene` do not matter."""
    if isinstance(scene, collections.abc.Mapping):
        scene = {name: value for name, value in scene.items() if name != "tolerance"}
    return _render(source, aov, 0, progress, scene, camera,
                   {**keywords, "renderer": "reference"})


class Comparison(typing.NamedTuple):
    """The difference a - b of two pictures over R, G, B and A, in linear radiance."""
    rms: float  #: over all finite pixels and the four channels
    max: float  #: largest absolute difference
    max_x: int  #: its pixel, from the top left
    max_y: int
    max_channel: str  #: "R", "G", "B", "A", or "" where the pictures are equal
    channel_rms: typing.List[float]
    channel_mean: typing.List[float]  #: signed
    not_finite: int  #: pixels with NaN or Inf in either, which are left out


def _picture(source):
    if isinstance(source, (str, bytes, os.PathLike)):
        return file_name(source)
    pixels = np.asarray(source)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.dtype.kind not in "biuf":
        usage(f"a picture of shape {pixels.shape}: expected (height, width, 3 or 4)")
    return np.ascontiguousarray(pixels, dtype=np.float32)


def compare(a, b):
    """Compares two pictures of one size: Images, files, or arrays (height, width, 3 or 4)."""
    return Comparison(**_core.compare(_picture(a), _picture(b)))


def _value(text):
    for number in (int, float):
        try:
            return number(text)
        except ValueError:
            pass
    return text or None


def study(source, folder=None, *, add=None, repeats=3, split=True, resume=False, progress=None,
          scene=None, camera=None, **keywords):
    """Draws one scene by many methods and measures the error and the time of each.

    folder: for what `psivox study` writes; by default it is not kept.
    add: pictures of other renderers by name, each a file, or a file and its time [ms].
    repeats: timed runs of each method, 1 to 1000.
    split: also measures step error and arithmetic error apart, which takes most of the time.
    resume: goes on with the study in the folder.
    integrators, samplings, segments, steps, filters, texels, tolerances, resolutions: lists of what
        to vary; all combinations are drawn.
    Other keywords are the scene's, as for render().

    Returns a list of dicts, one for each method and added picture: the rows of results.csv, for
    pandas.DataFrame.
    """
    names = _core.sweep_lists()
    keywords = {name: value for name, value in keywords.items() if value is not None}
    lists = {name: ",".join(_item(item) for item in _list(keywords.pop(name)))
             for name in names if name in keywords}
    for name in _core.swept_parameters():
        if name.replace("-", "_") in keywords:
            usage(f"a study varies {name} itself")
    opened = Source(source)
    words = words_of(opened.scene_of(keywords), (*_study_names, *names), scene, camera)
    words.settings = [("input", os.fsencode(opened.path)), *words.settings]
    repeats = whole_number(repeats, "repeats", 1, 1000)
    bar = _Progress(progress)
    foreign = []
    for name, picture in (add or {}).items():
        file, time_ms = picture if isinstance(picture, tuple) else (picture, 0)
        foreign.append((name, file_name(file), time_ms))
    with tempfile.TemporaryDirectory(prefix="psivox-") as kept:
        where = os.path.join(kept, "study") if folder is None else os.fsdecode(file_name(folder))
        try:
            _core.study(opened.file, words, file_name(where), lists, foreign, repeats, bool(split),
                        bool(resume), bar.report)
        finally:
            bar.close()
        with open(os.path.join(where, "results.csv"), newline="", encoding="utf-8") as file:
            return [{key: _value(text) for key, text in row.items()}
                    for row in csv.DictReader(file)]


def _list(value):
    return [value] if isinstance(value, str) or not hasattr(value, "__iter__") else list(value)


def _item(value):
    return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)


def verify(filter="exact", device=-1):
    """Draws cases whose results are known, to check this machine's OpenGL driver.

    Returns a list of dicts: name, error, bound, reason, passed.
    """
    return _core.verify(str(filter), whole_number(device, "device", -1))


def devices():
    """The EGL devices: a list of dicts with index, renderer, version, problem and software."""
    return _core.devices()


documented(render)
documented(show)
documented(reference)
documented(Session.render)
documented(Session.__init__)
