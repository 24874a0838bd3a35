"""Draws a VDB's density of constant luminance with Blender's Cycles.

    psivox study IN.vdb ... --camera-for blender >camera.py
    blender -b --factory-startup -P draw_in_cycles.py -- camera.py IN.vdb EXTINCTION R,G,B STEP OUT.exr

STEP is in world units. The last line that it prints is the time of the picture [ms]."""

import re
import sys
import time
from pathlib import Path

import bpy

camera_lines, volume, extinction, luminance, step, picture = sys.argv[sys.argv.index("--") + 1:]
lines = Path(camera_lines).read_text()
exec(lines)
scene = bpy.context.scene
for thing in [thing for thing in scene.objects if thing.type != "CAMERA"]:
    bpy.data.objects.remove(thing)

data = bpy.data.volumes.new("volume")
data.filepath = str(Path(volume).resolve())
data.render.space, data.render.precision, data.render.step_size = "WORLD", "FULL", float(step)
thing = bpy.data.objects.new("volume", data)
# half a voxel, as the camera's lines say
thing.location = [float(x) for x in re.search(r"object by \((.*)\)", lines)[1].split(",")]
scene.collection.objects.link(thing)

# attenuation and emission are extinction times density; emission has the luminance's colour
material = bpy.data.materials.new("medium")
material.use_nodes = True
tree = material.node_tree
tree.nodes.clear()
output, add, absorption, emission, density, product = [
    tree.nodes.new("ShaderNode" + name) for name in (
        "OutputMaterial", "AddShader", "VolumeAbsorption", "Emission", "Attribute", "Math")]
density.attribute_name = "density"
product.operation = "MULTIPLY"
product.inputs[1].default_value = float(extinction)
absorption.inputs["Color"].default_value = (0, 0, 0, 1)
emission.inputs["Color"].default_value = (*map(float, luminance.split(",")), 1)
for start, end in ((density.outputs["Fac"], product.inputs[0]),
                   (product.outputs[0], absorption.inputs["Density"]),
                   (product.outputs[0], emission.inputs["Strength"]),
                   (absorption.outputs[0], add.inputs[0]), (emission.outputs[0], add.inputs[1]),
                   (add.outputs[0], output.inputs["Volume"])):
    tree.links.new(start, end)
data.materials.append(material)

scene.world = bpy.data.worlds.new("black")
scene.render.engine = "CYCLES"
scene.cycles.samples, scene.cycles.max_bounces = 1, 0
scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01  # pixel centres
scene.cycles.volume_max_steps = 65536
scene.render.film_transparent = True
scene.view_settings.view_transform = "Raw"
image = scene.render.image_settings
image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
scene.render.filepath = str(Path(picture).resolve())
start = time.perf_counter()
bpy.ops.render.render(write_still=True)
print(f"{1e3 * (time.perf_counter() - start):.1f}")
