"""Draws a volume with the Blender add-on and by the program alone, with the camera that Blender
exports: addon_blender.py -- ADDON PROGRAM VOLUME. Run by addons_test.sh in `blender -b`."""

import importlib.util
import subprocess
import sys

import bpy
from mathutils import Vector

addon_path, program, volume_path = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
spec = importlib.util.spec_from_file_location("psivox_blender", addon_path)
addon = importlib.util.module_from_spec(spec)
spec.loader.exec_module(addon)
addon.register()
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y = 320, 200
scene.render.resolution_percentage = 50
bpy.ops.object.volume_import(filepath=volume_path)
volume = bpy.context.active_object
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
scene.collection.objects.link(camera)
scene.camera = camera
camera.location = (100, -110, 70)
middle = sum((Vector(corner) for corner in volume.bound_box), Vector()) / 8
camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
bpy.context.view_layer.update()


def draw():
    """The image's pixels, from the bottom left."""
    assert bpy.ops.render.psivox() == {"FINISHED"}
    image = bpy.data.images["psivox"]
    assert tuple(image.size) == (160, 100)
    return list(image.pixels)


def largest_difference(a, b):
    return max(abs(x - y) for x, y in zip(a, b))


scene.psivox_options = "--tolerance 1e-5 --look plain"
by_addon = draw()
bpy.ops.export_scene.gltf(filepath="scene.gltf", export_format="GLTF_SEPARATE", export_cameras=True)
subprocess.run([program, "render", volume_path, "-o", "alone.exr", "--camera", "scene.gltf:Camera",
                "--up-axis", "z", "--centering", "cell", "--resolution", "160x100", "--look",
                "plain", "--tolerance", "1e-5", "-q"], check=True)
alone = list(bpy.data.images.load(bpy.path.abspath("alone.exr")).pixels)
assert max(by_addon) > 0.5
difference = largest_difference(by_addon, alone)
assert difference < 2e-3, difference  # glTF's camera is in float32: 1e-5 of a pixel

# The same view of a volume that is turned, moved and scaled with its camera.
frame = bpy.data.objects.new("Frame", None)
scene.collection.objects.link(frame)
for thing in (volume, camera):
    thing.parent = frame
frame.location, frame.rotation_euler, frame.scale = (5, -3, 2), (0.3, 0.2, 1), (2, 2, 2)
bpy.context.view_layer.update()
difference = largest_difference(by_addon, draw())
assert difference < 2e-3, difference

# A sun lights it, and a second one more.
scene.psivox_options = "--tolerance 1e-3 --look plain"
sums = []
for name in ("Sun", "Other"):
    sun = bpy.data.objects.new(name, bpy.data.lights.new(name, "SUN"))
    sun.data.energy = 5
    scene.collection.objects.link(sun)
    sums.append(sum(draw()[0::4]))
assert sums[1] > 1.5 * sums[0] > 0, sums

# What psivox cannot draw is said.
camera.data.shift_x = 0.1
try:
    bpy.ops.render.psivox()
    raise SystemExit("a lens shift was not refused")
except RuntimeError as error:
    assert "lens shift" in str(error), error
addon.unregister()
print("the add-on draws as the program does")
