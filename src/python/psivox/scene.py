"""Keywords of a scene, from the library's table of parameters."""

import collections.abc
import inspect
import json
import os
import textwrap

import numpy as np

from . import _core
from .grids import file_name, hint, usage

__all__ = ["parameters"]

_rows = {row["name"].replace("-", "_"): row for row in _core.parameters()}


def parameters():
    """The keywords of a scene: a dict of dicts with metavar, unit, default, help and group."""
    return {name: dict(row) for name, row in _rows.items()}


def _number(value):
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return None


def _items(value):
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return list(value) if isinstance(value, collections.abc.Iterable) else [value]


def _text(name, value, kind=""):
    """The value as the command line writes it."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    number = _number(value)
    if number is not None:
        return number
    if isinstance(value, collections.abc.Mapping) or not isinstance(value,
                                                                    collections.abc.Iterable):
        usage(f"{name}: expected text, a number or numbers, not {type(value).__name__}")
    items = _items(value)
    if kind == "texts":
        wrong = next((item for item in items if not isinstance(item, (str, os.PathLike))), None)
        if wrong is not None:
            usage(f"{name}: expected text, not {type(wrong).__name__}")
        return ";".join(os.fspath(item) for item in items)
    if kind == "opacity":
        return ",".join(":".join(_text(name, part) for part in _items(item)) for item in items)
    if kind == "lights" and not items:
        return "none"
    if kind == "lights" and _number(items[0]) is None:  # else one light
        return ";".join(_text(name, item) for item in items)
    return ("x" if kind == "pixels" else ",").join(_text(name, item) for item in items)


def _plain(value):
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    usage(f"scene: expected text, numbers and lists, not {type(value).__name__}")


def words_of(scene, others=(), base=None, camera=None):
    """SceneWords of keywords. `others`: names that the call takes besides, for suggestions."""
    words = _core.SceneWords()
    settings = []
    for name, value in scene.items():
        row = _rows.get(name)
        if row is None:
            known = [other for other in (*_rows, *others) if other != name]
            usage(f"unknown keyword '{name}'{hint(name, known)}")
        if value is not None:
            settings.append((row["name"], os.fsencode(_text(name, value, row["kind"]))))
    words.settings = settings
    if camera is not None:
        words.camera = file_name(camera)
    if isinstance(base, collections.abc.Mapping):
        words.base = json.dumps({str(name).replace("_", "-"): value for name, value in base.items()},
                                default=_plain)
    elif base is not None:
        words.base_file = file_name(base)
    return words


def documented(function, *, without=()):
    """Gives a function of **scene its real keywords: for help(), for completion, for editors."""
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    names = [name for name in _rows if name not in without]
    keywords = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None)
                for name in names]
    function.__signature__ = signature.replace(parameters=own + keywords)
    lines = [inspect.cleandoc(function.__doc__), "", "Keywords of the scene:"]
    for name in names:
        row = _rows[name]
        unit = f" [{row['unit']}]" if row["unit"] else ""
        metavar = f" {row['metavar']}" if row["metavar"] else ""
        usual = f" (default: {row['default']})" if row["default"] else ""
        lines.append(f"    {name}:{metavar}{unit}")
        lines.append(textwrap.indent(textwrap.fill(row["help"] + usual, 92), " " * 8))
    function.__doc__ = "\n".join(lines)
    return function
