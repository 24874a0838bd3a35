"""Writes a .gltf of cameras, and at which pixels of 640x360 Blender sees points through them:

    blender -b --python blender_cameras.py -- blender-3.4

Used by camera_file_test. Each line of the .txt has a camera, a frame, and x and y of each point,
from the top left. Points and cameras have Blender's axes."""

import sys

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler, Vector

name = sys.argv[sys.argv.index("--") + 1]
points = [(0, 0, 0), (30, 24, 20), (15, 12, 10), (4, 20, 3), (27, 5, 16), (10, 2, 18)]
middle = Vector(points[2])

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y = 640, 360
scene.render.resolution_percentage, scene.render.fps = 100, 24
scene.frame_start, scene.frame_end = 1, 25


def camera(name, place, roll=0.0, **lens):
    data = bpy.data.cameras.new(name + " data")
    for key, value in lens.items():
        setattr(data, key, value)
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    aim(thing, Vector(place), middle, roll)
    return thing


def aim(thing, place, target, roll=0.0):
    thing.location = place
    turn = (target - place).to_track_quat("-Z", "Y").to_matrix() @ Euler((0, 0, roll)).to_matrix()
    thing.rotation_euler = turn.to_euler()


cameras = [camera("Camera", (70, -60, 45), lens=35),
           camera("Rolled", (-40, -55, 5), roll=0.3, lens=50, sensor_fit="VERTICAL"),
           camera("Flat", (20, -80, 60), type="ORTHO", ortho_scale=60)]

rig = bpy.data.objects.new("Rig", None)
scene.collection.objects.link(rig)
rig.location, rig.rotation_euler, rig.scale = (3, -2, 1), (0.1, 0.2, 0.7), (2, 2, 2)
bpy.context.view_layer.update()
mounted = camera("Mounted", (25, -20, 15), lens=28)
mounted.parent = rig
aim(mounted, mounted.location, rig.matrix_world.inverted() @ middle)
cameras.append(mounted)

moving = camera("Moving", (60, -60, 20), lens=40)
for frame, place in ((1, (60, -60, 20)), (25, (-60, -60, 40))):
    aim(moving, Vector(place), middle)
    moving.keyframe_insert("location", frame=frame)
    moving.keyframe_insert("rotation_euler", frame=frame)
cameras.append(moving)


def pixels(thing, frame):
    scene.frame_set(frame)
    seen = [world_to_camera_view(scene, thing, Vector(point)) for point in points]
    return [round(x, 3) for v in seen for x in (v.x * 640, (1 - v.y) * 360)]


def line(*words):
    return " ".join(str(word) for word in words) + "\n"


scene.camera = cameras[0]
bpy.ops.export_scene.gltf(filepath=name + ".gltf", export_format="GLTF_EMBEDDED",
                          export_cameras=True)
with open(name + ".txt", "w", encoding="ascii") as file:
    file.write(line("points", *[x for point in points for x in point]))
    for thing in cameras:
        for frame in (1, 9, 25) if thing is moving else (1,):
            file.write(line(thing.name, frame, *pixels(thing, frame)))
