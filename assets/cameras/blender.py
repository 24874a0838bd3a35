import bpy
import math
from mathutils import Matrix
scene = bpy.context.scene
camera = bpy.data.objects.new("psivox", bpy.data.cameras.new("psivox"))
scene.collection.objects.link(camera)
scene.camera = camera
# Cycles places a voxel's value in its middle: move the volume's object by ({half_voxel})
axes = Matrix((({right}), ({up}), ({back}))).transposed()
camera.matrix_world = Matrix.Translation(({position})) @ axes.to_4x4()
camera.data.sensor_fit = "HORIZONTAL"
camera.data.clip_start, camera.data.clip_end = {near}, {far}
@perspective camera.data.angle = math.radians({fov})
@orthographic camera.data.type, camera.data.ortho_scale = "ORTHO", {width}
scene.render.resolution_x, scene.render.resolution_y = {x}, {y}
scene.render.resolution_percentage = 100
scene.render.pixel_aspect_x = scene.render.pixel_aspect_y = 1
