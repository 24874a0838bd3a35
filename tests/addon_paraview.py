"""Draws ParaView's wavelet with the macro, and the same field by the program alone:
addon_paraview.py MACRO PROGRAM. Run by addons_test.sh in pvpython."""

import os
import subprocess
import sys
import tempfile

import numpy as np
from paraview import servermanager, simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

macro, program = sys.argv[1:]
os.environ["PSIVOX"] = program
os.environ["PSIVOX_OPTIONS"] = "--background black --tolerance 1e-4 --extinction 0.2"
tempfile.tempdir = os.getcwd()
wavelet = simple.Wavelet()
wavelet.WholeExtent = [-10, 10, -8, 8, -6, 9]
wavelet.UpdatePipeline()
view = simple.CreateView("RenderView")
view.ViewSize = [160, 100]
simple.Show(wavelet, view)
simple.ColorBy(simple.GetDisplayProperties(wavelet, view), ("POINTS", "RTData"))
view.CameraPosition, view.CameraFocalPoint = [40, 30, 60], [0, 0, 1]
view.CameraViewUp, view.CameraViewAngle = [0, 1, 0], 30
colours = simple.GetColorTransferFunction("RTData")
colours.ColorSpace = "RGB"
colours.RGBPoints = [40, 0, 0, 1, 280, 1, 0, 0]
simple.GetOpacityTransferFunction("RTData").Points = [40, 0, 0.5, 0, 280, 1, 0.5, 0]


def pixels(path):
    reader = simple.PNGSeriesReader(FileNames=[path])
    reader.UpdatePipeline()
    data = servermanager.Fetch(reader)
    return vtk_to_numpy(data.GetPointData().GetScalars()).astype(int)


for parallel in (0, 1):
    simple.SetActiveSource(wavelet)
    view.CameraParallelProjection, view.CameraParallelScale = parallel, 12
    exec(compile(open(macro).read(), macro, "exec"), {"__name__": "macro"})
    by_macro = pixels("psivox.png")
    values = vtk_to_numpy(servermanager.Fetch(wavelet).GetPointData().GetArray("RTData"))
    with open("alone.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 21 17 16\nspace dimension: 3\n"
                   b"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (-10,-8,-6)\n"
                   b"endian: little\nencoding: raw\n\n" + values.astype("<f4").tobytes())
    with open("map.json", "w") as file:
        file.write('[{"ColorSpace": "RGB", "RGBPoints": [40, 0, 0, 1, 280, 1, 0, 0], '
                   '"Points": [40, 0, 0.5, 0, 280, 1, 0.5, 0]}]')
    with open("view.pvcc", "w") as file:
        rows = {"CameraPosition": view.CameraPosition, "CameraFocalPoint": view.CameraFocalPoint,
                "CameraViewUp": view.CameraViewUp, "CameraViewAngle": [view.CameraViewAngle],
                "CameraParallelScale": [12], "CameraParallelProjection": [parallel]}
        file.write("<PVCameraConfiguration><Proxy>" + "".join(
            f'<Property name="{name}">' + "".join(f'<Element index="{i}" value="{x}"/>'
                                                  for i, x in enumerate(row)) + "</Property>"
            for name, row in rows.items()) + "</Proxy></PVCameraConfiguration>")
    subprocess.run([program, "render", "alone.nrrd", "-o", "alone.png", "--camera", "view.pvcc",
                    "--transfer-function", "map.json", "--resolution", "160x100", "-q",
                    *os.environ["PSIVOX_OPTIONS"].split()], check=True)
    difference = np.abs(by_macro - pixels("alone.png"))
    assert by_macro.max() > 100, by_macro.max()
    assert difference.max() <= 1, difference.max()  # the view's numbers are rounded alike

os.environ["PSIVOX"] = "no-such-program"
try:
    exec(compile(open(macro).read(), macro, "exec"), {"__name__": "macro"})
    sys.exit("a missing program was not said")
except FileNotFoundError:
    pass
print("the macro draws as the program does")
