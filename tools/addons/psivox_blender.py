"""Blender add-on: draws the active volume object with psivox. See docs/interchange.md.

Edit > Preferences > Add-ons > Install takes this file; Render > psivox draws. The camera, the frame
and the suns go to psivox; the picture comes back as the image "psivox".
"""

import math
import os
import shlex
import subprocess
import tempfile

import bpy
from mathutils import Vector

bl_info = {
    "name": "psivox",
    "description": "Draw the active volume with psivox",
    "blender": (3, 0, 0),
    "version": (1, 0),
    "location": "Render > psivox",
    "category": "Render",
}


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(name="psivox", default="psivox", subtype="FILE_PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


def text_of(vector):
    return ",".join(f"{x:.9g}" for x in vector)


def volume_file(volume):
    """The file of the current frame."""
    volume.grids.load()
    return bpy.path.abspath(volume.grids.frame_filepath or volume.filepath)


def placed(world_from_volume, world_from_thing):
    """Where something lies in the volume's space, and the volume's size in the world."""
    scale = world_from_volume.to_scale()
    if max(scale) - min(scale) > 1e-5 * max(scale) or min(scale) <= 0:
        raise ValueError("the volume is scaled by different factors; psivox needs one")
    return world_from_volume.inverted() @ world_from_thing, scale[0]


def camera_options(scene, world_from_volume):
    camera = scene.camera
    if not camera or camera.type != "CAMERA":
        raise ValueError("the scene has no camera")
    if camera.data.type == "PANO":
        raise ValueError("psivox has no panoramic camera")
    if camera.data.shift_x or camera.data.shift_y:
        raise ValueError("psivox has no lens shift; set the camera's to 0")
    place, scale = placed(world_from_volume, camera.matrix_world)
    corner = camera.data.view_frame(scene=scene)[0]  # of the frame, seen from the camera
    position = place.translation
    turn = place.to_quaternion()
    ahead = turn @ Vector((0, 0, -1))
    options = ["--camera-position", text_of(position), "--camera-target",
               text_of(position + ahead * max(position.length, 1)),
               "--camera-up", text_of(turn @ Vector((0, 1, 0)))]
    if camera.data.type == "ORTHO":
        return options + ["--projection", "orthographic", "--ortho-width",
                          f"{2 * corner.x / scale:.9g}"]
    return options + ["--fov", f"{2 * math.degrees(math.atan(corner.x / -corner.z)):.9g}"]


def sun_options(scene, world_from_volume):
    """A sun's strength is its irradiance; psivox takes what of it is scattered to each side."""
    options = []
    for thing in scene.objects:
        if thing.type != "LIGHT" or thing.data.type != "SUN" or thing.hide_render:
            continue
        place, _ = placed(world_from_volume, thing.matrix_world)
        colour = Vector(thing.data.color) * thing.data.energy / (4 * math.pi)
        options += ["--light", text_of([*(place.to_quaternion() @ Vector((0, 0, -1))), *colour])]
    return options


def command_for(context, output):
    """The call of psivox that draws the active object as the scene's camera sees it."""
    scene, thing = context.scene, context.active_object
    if not thing or thing.type != "VOLUME":
        raise ValueError("the active object is no volume")
    if not volume_file(thing.data):
        raise ValueError("the volume has no file")
    addon = context.preferences.addons.get(__name__)
    program = addon.preferences.program if addon else "psivox"
    size = [int(pixels * scene.render.resolution_percentage / 100)
            for pixels in (scene.render.resolution_x, scene.render.resolution_y)]
    return [program, "render", volume_file(thing.data), "-o", output, "--up-axis", "z",
            "--centering", "cell", "--resolution", f"{size[0]}x{size[1]}", "-q",
            *camera_options(scene, thing.matrix_world), *sun_options(scene, thing.matrix_world),
            *shlex.split(scene.psivox_options)]


class RenderVolume(bpy.types.Operator):
    bl_idname = "render.psivox"
    bl_label = "psivox"
    bl_description = "Draw the active volume with psivox"

    def execute(self, context):
        with tempfile.TemporaryDirectory() as folder:
            picture = os.path.join(folder, "psivox.exr")
            try:
                done = subprocess.run(command_for(context, picture), capture_output=True, text=True)
            except (OSError, ValueError) as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
            if done.returncode:
                self.report({"ERROR"}, done.stderr.strip())
                return {"CANCELLED"}
            old = bpy.data.images.get("psivox")
            image = bpy.data.images.load(picture)
            image.pack()  # the file goes
            if old:
                old.user_remap(image)
                bpy.data.images.remove(old)
            image.name = "psivox"
        for area in context.screen.areas if context.screen else ():
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
        self.report({"INFO"}, "the picture is the image psivox")
        return {"FINISHED"}


def menu(self, context):
    self.layout.separator()
    self.layout.operator(RenderVolume.bl_idname, icon="OUTLINER_DATA_VOLUME")
    self.layout.prop(context.scene, "psivox_options")


def register():
    bpy.types.Scene.psivox_options = bpy.props.StringProperty(
        name="psivox options", description="more options of psivox render, such as --look fire")
    bpy.utils.register_class(Preferences)
    bpy.utils.register_class(RenderVolume)
    bpy.types.TOPBAR_MT_render.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_render.remove(menu)
    bpy.utils.unregister_class(RenderVolume)
    bpy.utils.unregister_class(Preferences)
    del bpy.types.Scene.psivox_options
