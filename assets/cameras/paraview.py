from paraview.simple import *
view = GetActiveViewOrCreate("RenderView")
view.ViewSize = [{x}, {y}]
view.CameraPosition, view.CameraFocalPoint = [{position}], [{target}]
view.CameraViewUp = [{up}]
@perspective view.CameraParallelProjection, view.CameraViewAngle = 0, {vertical_fov}
@orthographic view.CameraParallelProjection, view.CameraParallelScale = 1, {half_height}
