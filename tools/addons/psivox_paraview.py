"""ParaView macro: draws the active source with psivox. See docs/interchange.md.

Macros > Import new macro takes this file. The values of the active source (image data), its colour
map and opacities, and the camera go to psivox, which draws a picture of the view's size; it comes
back as a source, psivox.png, and stays in the folder for temporary files. PSIVOX and PSIVOX_OPTIONS
in the environment name another program and more options of psivox render.
"""

import json
import math
import os
import shlex
import subprocess
import tempfile

import numpy as np
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy


def text_of(numbers):
    return ",".join(f"{x:.9g}" for x in numbers)


def write_volume(path, source, name):
    """Writes values at points, or in cells, as a NRRD."""
    data = servermanager.Fetch(source)
    if not data.IsA("vtkImageData"):
        raise RuntimeError("psivox draws image data; Resample To Image makes it of other sources")
    array, cells = data.GetPointData().GetArray(name), False
    if array is None:
        array, cells = data.GetCellData().GetArray(name), True
    values = vtk_to_numpy(array).astype("<f4")
    if values.ndim > 1:
        values = np.linalg.norm(values, axis=1)
    size = [n - cells for n in data.GetDimensions()]
    spacing, extent = data.GetSpacing(), data.GetExtent()
    origin = [o + s * (extent[2 * i] + cells / 2)
              for i, (o, s) in enumerate(zip(data.GetOrigin(), spacing))]
    axes = " ".join("(" + text_of(s if i == j else 0 for j in range(3)) + ")"
                    for i, s in enumerate(spacing))
    with open(path, "wb") as file:
        file.write(("NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\n"
                    f"sizes: {size[0]} {size[1]} {size[2]}\nspace directions: {axes}\n"
                    f"space origin: ({text_of(origin)})\nendian: little\nencoding: raw\n\n")
                   .encode())
        file.write(values.tobytes())


def write_map(path, name):
    """Writes the colour map and the opacities of an array, as ParaView exports them."""
    colours = simple.GetColorTransferFunction(name)
    keys = {"ColorSpace": str(colours.ColorSpace).strip("'"), "RGBPoints": list(colours.RGBPoints),
            "Points": list(simple.GetOpacityTransferFunction(name).Points)}
    with open(path, "w") as file:
        json.dump([keys], file)


def camera_options(view):
    width, height = view.ViewSize
    options = ["--resolution", f"{width}x{height}",
               "--camera-position", text_of(view.CameraPosition),
               "--camera-target", text_of(view.CameraFocalPoint),
               "--camera-up", text_of(view.CameraViewUp)]
    if view.CameraParallelProjection:
        return options + ["--projection", "orthographic", "--ortho-width",
                          f"{2 * view.CameraParallelScale * width / height:.9g}"]
    half = math.tan(math.radians(view.CameraViewAngle) / 2) * width / height
    return options + ["--fov", f"{2 * math.degrees(math.atan(half)):.9g}"]


def draw():
    source, view = simple.GetActiveSource(), simple.GetActiveViewOrCreate("RenderView")
    if source is None:
        raise RuntimeError("no source is active")
    shown = simple.GetDisplayProperties(source, view)
    name = shown.ColorArrayName[1] or source.PointData.GetArray(0).Name
    picture = os.path.join(tempfile.gettempdir(), "psivox.png")
    with tempfile.TemporaryDirectory() as folder:
        volume, colours = os.path.join(folder, "volume.nrrd"), os.path.join(folder, "map.json")
        write_volume(volume, source, name)
        write_map(colours, name)
        done = subprocess.run(
            [os.environ.get("PSIVOX", "psivox"), "render", volume, "-o", picture, "-q",
             "--transfer-function", colours, *camera_options(view),
             *shlex.split(os.environ.get("PSIVOX_OPTIONS", ""))], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    old = simple.FindSource("psivox.png")
    if old is not None:
        simple.Delete(old)
    simple.PNGSeriesReader(registrationName="psivox.png", FileNames=[picture])
    simple.SetActiveSource(source)
    print("psivox drew", picture)


draw()
