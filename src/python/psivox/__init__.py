"""Renders volumes to a given error.

    import numpy as np, psivox
    psivox.render(np.random.rand(64, 64, 64).astype("f4")).write("x.png")

A source is the path of a .vdb, .nvdb, NIfTI or NRRD file, a grid of `psivox.open`, an array,
`psivox.field`, or a dict of grids and arrays by the names of grids. The keywords of a scene are the
options of the program `psivox`, with `_` in place of `-`; `help(psivox.render)` lists them.

Whatever goes wrong is a `psivox.Error` with one line of text and `exit_code`, that of the program:
2 usage, 3 input, 4 graphics, 5 output, 6 memory, 7 a check failed, 1 anything else.
"""

import atexit as _atexit
import os as _os

from . import _core
from ._core import Error, trust_files
from .grids import Field, File, field, info, open
from .pictures import (Comparison, Image, Page, Session, compare, devices, reference, render, show,
                       study, verify)
from .scene import parameters

__version__ = _core.version
__all__ = ["Comparison", "Error", "Field", "File", "Image", "Page", "Session", "compare",
           "devices", "field", "info", "open", "parameters", "reference", "render", "show", "study",
           "trust_files", "verify"]

Error.__module__ = "psivox"


def _close(process=_os.getpid()):
    if _os.getpid() == process:  # OpenGL does not survive a fork
        _core.close()


_atexit.register(_close)
