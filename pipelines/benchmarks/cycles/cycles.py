# One picture of a cloud by Cycles, as render --integrator path sees it: an orthographic view of a .vdb in the light of a sun
# of irradiance 1, light scattered any number of times. Run by scene.sh inside Blender:
#
#   blender -b --factory-startup -P cycles.py -- FILE.vdb EXTINCTION ALBEDO G SUN CAMERA TARGET WIDTH PIXELS SAMPLES SEED VOXEL OUT.exr
#
# Prints "cpu SECONDS" of the rendering, user and system time of all threads, without Blender's start.
import resource
import sys

import bpy
from mathutils import Matrix, Vector

arguments = sys.argv[sys.argv.index("--") + 1:]
file, extinction, albedo, g, sun, camera, target, width, pixels, samples, seed, voxel, out = arguments


def vector(text):
    return Vector([float(x) for x in text.split(",")])


def looking(place, direction, up=Vector((0, 1, 0))):
    """Placement of an object whose -z axis is `direction`."""
    z = -direction.normalized()
    x = up.cross(z).normalized()
    y = z.cross(x)
    return Matrix(((x[0], y[0], z[0], place[0]), (x[1], y[1], z[1], place[1]), (x[2], y[2], z[2], place[2]), (0, 0, 0, 1)))


for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
scene = bpy.context.scene

bpy.ops.object.volume_import(filepath=file)
cloud = bpy.context.object
# Cycles reads values half a voxel beyond their places, and import may turn the axes.
cloud.rotation_euler = (0, 0, 0)
cloud.location = [-float(voxel) / 2] * 3
material = bpy.data.materials.new("cloud")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
medium, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
medium.inputs["Density"].default_value = float(extinction)
medium.inputs["Color"].default_value = [float(albedo)] * 3 + [1]
medium.inputs["Absorption Color"].default_value = (0, 0, 0, 1)  # extinction less scattering is absorbed
medium.inputs["Anisotropy"].default_value = float(g)
material.node_tree.links.new(medium.outputs["Volume"], output.inputs["Volume"])
material.cycles.volume_interpolation = "LINEAR"
material.cycles.volume_sampling = "DISTANCE"  # equal angles help lamps, not suns
cloud.data.materials.clear()
cloud.data.materials.append(material)

light = bpy.data.lights.new("sun", "SUN")
light.energy = 1
light.angle = 0
bpy.context.collection.objects.link(bpy.data.objects.new("sun", light))
bpy.data.objects["sun"].matrix_world = looking(Vector((0, 0, 0)), -vector(sun), Vector((0, 0, 1)))
world = bpy.data.worlds.new("black")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
scene.world = world

eye = bpy.data.cameras.new("camera")
eye.type = "ORTHO"
eye.ortho_scale = float(width)
eye.clip_end = 1e4
bpy.context.collection.objects.link(bpy.data.objects.new("camera", eye))
scene.camera = bpy.data.objects["camera"]
scene.camera.matrix_world = looking(vector(camera), vector(target) - vector(camera))

scene.render.engine = "CYCLES"
scene.render.resolution_x = scene.render.resolution_y = int(pixels)
scene.render.resolution_percentage = 100
scene.render.film_transparent = True
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out
cycles = scene.cycles
cycles.device = "CPU"
cycles.samples = int(samples)
cycles.seed = int(seed)
cycles.use_adaptive_sampling = False
cycles.use_denoising = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.light_sampling_threshold = 0
cycles.pixel_filter_type = "BOX"
cycles.max_bounces = cycles.volume_bounces = cycles.transparent_max_bounces = 1024
cycles.volume_step_rate = 1
cycles.volume_max_steps = 1024
cycles.use_auto_tile = False


def cpu():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


before = cpu()
bpy.ops.render.render(write_still=True)
print("cpu %.2f" % (cpu() - before))
