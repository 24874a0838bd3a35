#!/usr/bin/env python3
"""Draws a VDB's density of constant luminance with VTK's ray caster for GPUs.

    psivox study IN.vdb ... --camera-for paraview >camera.txt
    draw_in_vtk.py camera.txt IN.vdb EXTINCTION R,G,B STEP OUT.exr

STEP is in world units. It needs python3-vtk9, python3-openvdb, python3-openimageio and a display,
such as xvfb-run's, and prints the time of the second picture [ms]."""

import sys
import time
from pathlib import Path

import numpy
import OpenImageIO
import pyopenvdb
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

camera_lines, volume, extinction, luminance, step, picture = sys.argv[1:]
grid = pyopenvdb.read(volume, "density")
low, high = ([x + by for x in corner]
             for corner, by in zip(grid.evalActiveVoxelBoundingBox(), (-1, 1)))
values = numpy.zeros([b - a + 1 for a, b in zip(low, high)], "f4")
grid.copyToArray(values, ijk=low)
image = vtk.vtkImageData()
image.SetDimensions(values.shape)
image.SetSpacing(grid.transform.voxelSize())
image.SetOrigin(grid.transform.indexToWorld(low))
image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(order="F"), deep=True))

opacity, color = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
for value in numpy.linspace(0, values.max(), 16385):
    opacity.AddPoint(value, -numpy.expm1(-float(extinction) * float(step) * value))
color.AddRGBPoint(0, *map(float, luminance.split(",")))
medium = vtk.vtkVolumeProperty()
medium.SetInterpolationTypeToLinear()
medium.SetScalarOpacityUnitDistance(float(step))
medium.SetScalarOpacity(opacity)
medium.SetColor(color)
mapper = vtk.vtkGPUVolumeRayCastMapper()
mapper.SetInputData(image)
mapper.SetAutoAdjustSampleDistances(False)
mapper.SetSampleDistance(float(step))
actor = vtk.vtkVolume()
actor.SetMapper(mapper)
actor.SetProperty(medium)
renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
renderer.AddVolume(actor)
window.SetOffScreenRendering(True)
window.SetAlphaBitPlanes(True)
window.SetMultiSamples(0)
window.AddRenderer(renderer)


class View:
    """Takes the lines for ParaView's view: its properties are the window's size and the camera's."""

    def __setattr__(self, name, value):
        if name == "ViewSize":
            return window.SetSize(value)
        return getattr(renderer.GetActiveCamera(), "Set" + name.removeprefix("Camera"))(value)


lines = Path(camera_lines).read_text().splitlines()
exec("\n".join(line for line in lines if line.startswith("view.")), {"view": View()})
renderer.ResetCameraClippingRange()
window.Render()  # compiles
start = time.perf_counter()
window.Render()
pixels, (width, height) = vtk.vtkFloatArray(), window.GetSize()
window.GetRGBAPixelData(0, 0, width - 1, height - 1, 0, pixels)
print(f"{1e3 * (time.perf_counter() - start):.1f}")
rgba = vtk_to_numpy(pixels).reshape(height, width, 4)[::-1]
file = OpenImageIO.ImageOutput.create(picture)
file.open(picture, OpenImageIO.ImageSpec(width, height, 4, "float"))
file.write_image(numpy.ascontiguousarray(rgba))
file.close()
