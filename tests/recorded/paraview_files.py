"""Writes cameras and colour maps as ParaView saves them, and what ParaView makes of them:

    xvfb-run -s "-screen 0 1600x1000x24 -noreset" python3 paraview_files.py paraview-5.11

Used by camera_file_test and paraview_map_test. Pixels count from the top left."""

import sys

from paraview.modules.vtkRemotingMisc import vtkSMCameraConfigurationWriter
from paraview.modules.vtkRemotingViews import vtkSMTransferFunctionProxy
from paraview.simple import CreateView, GetColorTransferFunction, GetOpacityTransferFunction

prefix = sys.argv[1]
points = [(0, 0, 0), (30, 24, 20), (15, 12, 10), (4, 20, 3), (27, 5, 16), (10, 2, 18)]
size = (640, 360)


def camera(name, parallel):
    view = CreateView("RenderView")
    view.ViewSize = size
    view.CameraPosition, view.CameraFocalPoint = [70, -40, 55], [15, 12, 10]
    view.CameraViewUp, view.CameraViewAngle = [0.1, 0.2, 0.97], 37
    view.CameraParallelScale, view.CameraParallelProjection = 22, parallel
    view.StillRender()
    writer = vtkSMCameraConfigurationWriter()
    writer.SetRenderViewProxy(view.SMProxy)
    writer.WriteConfiguration(f"{prefix}-{name}.pvcc")
    renderer, seen = view.GetRenderer(), []
    for point in points:
        renderer.SetWorldPoint(*point, 1)
        renderer.WorldToDisplay()
        x, y, _ = renderer.GetDisplayPoint()
        seen += [round(x, 3), round(size[1] - y, 3)]
    return [name, 1, *seen]


def color_map(name, preset, opacity, space=None):
    """Rows of the name, a value, its colour (as displayed) and its opacity."""
    colors, opacities = GetColorTransferFunction(name), GetOpacityTransferFunction(name)
    colors.ApplyPreset(preset, True)
    if space:
        colors.ColorSpace = space
    colors.Discretize = 0
    colors.RescaleTransferFunction(-2.0, 6.0)
    opacities.Points = [8 * x - 2 if i % 4 == 0 else x for i, x in enumerate(opacity)]
    colors.UpdateVTKObjects()
    opacities.UpdateVTKObjects()
    vtkSMTransferFunctionProxy.ExportTransferFunction(colors.SMProxy, opacities.SMProxy, name,
                                                      f"{prefix}-{name}.json")
    rows = []
    for i in range(24):
        value, color = -2 + 8 * (i + 0.37) / 24, [0, 0, 0]
        colors.GetClientSideObject().GetColor(value, color)
        opacity_there = opacities.GetClientSideObject().GetValue(value)
        rows.append([name, *[round(x, 6) for x in (value, *color, opacity_there)]])
    return rows


def write(name, rows):
    with open(name, "w", encoding="ascii") as file:
        for row in rows:
            file.write(" ".join(str(word) for word in row) + "\n")


write(prefix + "-cameras.txt", [["points", *[x for point in points for x in point]],
                                camera("perspective", 0), camera("parallel", 1)])
ramp = [0, 0, 0.5, 0, 1, 1, 0.5, 0]
write(prefix + "-maps.txt",
      color_map("diverging", "Cool to Warm", ramp)
      + color_map("rgb", "Rainbow Desaturated",
                  [0, 0.1, 0.3, 0.2, 0.4, 0.8, 0.6, 0.7, 1, 0.2, 0.5, 0])
      + color_map("hsv", "Blue to Red Rainbow", [0, 0, 0.5, 1, 0.5, 1, 0.5, 0, 1, 0, 0.5, 0])
      + color_map("lab", "Black-Body Radiation", ramp, "Lab"))
