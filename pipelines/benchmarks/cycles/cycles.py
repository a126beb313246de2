# One picture of a cloud by Cycles, as render --integrator path sees it: an orthographic view of a .vdb in the light of a sun
# of irradiance 1, light scattered any number of times. Run by scene.sh inside Blender:
#
#   blender -b --factory-startup -P cycles.py -- FILE.vdb EXTINCTION ALBEDO G SUN CAMERA TARGET WIDTH PIXELS SAMPLES SEED VOXEL OUT.exr [REPORT.json]
#
# With the report of a render run (--json): as that run sees the cloud, from the camera of the report, in perspective, with the sun in colour,
# under the gradient of the sky and above the planes among the solids, which are diffuse. WIDTH and PIXELS then have no effect.
#
# Prints "cpu SECONDS" of the rendering, user and system time of all threads, without Blender's start.
import json
import math
import resource
import sys

import bpy
from mathutils import Matrix, Vector

arguments = sys.argv[sys.argv.index("--") + 1:]
file, extinction, albedo, g, sun, camera, target, width, pixels, samples, seed, voxel, out = arguments[:13]
report = json.load(open(arguments[13])) if len(arguments) > 13 else None
options = report["parameters"] if report else {}


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
if report:
    light.color = report["lights"][0]["irradiance"]
light.angle = 0
bpy.context.collection.objects.link(bpy.data.objects.new("sun", light))
bpy.data.objects["sun"].matrix_world = looking(Vector((0, 0, 0)), -vector(sun), Vector((0, 0, 1)))
world = bpy.data.worlds.new("black")
world.use_nodes = True
background = world.node_tree.nodes["Background"]
background.inputs["Strength"].default_value = 1 if report else 0
scene.world = world


def sky(tree):
    """The colour of a direction: far + (horizon - far) (1 - |height|)^haze, far the zenith above the horizon and the ground below."""
    def node(kind, **inputs):
        made = tree.nodes.new(kind)
        for key, value in inputs.items():
            if key == "operation":
                made.operation = value
            elif hasattr(value, "node"):
                tree.links.new(value, made.inputs[int(key[1:])])
            else:
                made.inputs[int(key[1:])].default_value = value
        return made.outputs[0]

    def colour(key):
        return list(options[key]) + [1]

    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    separate = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(direction, separate.inputs[0])
    height = separate.outputs["Y"]
    above = node("ShaderNodeMath", operation="GREATER_THAN", _0=height, _1=0.0)
    size = node("ShaderNodeMath", operation="ABSOLUTE", _0=height)
    near = node("ShaderNodeMath", operation="POWER", _0=node("ShaderNodeMath", operation="SUBTRACT", _0=1.0, _1=size), _1=float(options["sky-haze"]))
    far = node("ShaderNodeMixRGB", _0=above, _1=colour("sky-ground"), _2=colour("sky-zenith"))
    return node("ShaderNodeMixRGB", _0=near, _1=far, _2=colour("sky-horizon"))


if report:
    world.node_tree.links.new(sky(world.node_tree), background.inputs["Color"])
    for solid in options["solid"]:
        shape, *properties = [part.strip() for part in solid.split(";")]
        if shape != "plane":
            continue
        value = dict(part.split("=") for part in properties)
        mesh = bpy.data.meshes.new("plane")
        far = 1000
        y = vector(value["at"])[1]
        mesh.from_pydata([(-far, y, -far), (-far, y, far), (far, y, far), (far, y, -far)], [], [(0, 1, 2, 3)])
        ground = bpy.data.materials.new("ground")
        ground.use_nodes = True
        ground.node_tree.nodes.clear()
        diffuse, end = ground.node_tree.nodes.new("ShaderNodeBsdfDiffuse"), ground.node_tree.nodes.new("ShaderNodeOutputMaterial")
        diffuse.inputs["Color"].default_value = list(vector(value["colour"])) + [1]
        ground.node_tree.links.new(diffuse.outputs["BSDF"], end.inputs["Surface"])
        mesh.materials.append(ground)
        bpy.context.collection.objects.link(bpy.data.objects.new("plane", mesh))

eye = bpy.data.cameras.new("camera")
eye.type = "ORTHO"
eye.ortho_scale = float(width)
eye.clip_end = 1e4
if report:
    eye.type, eye.sensor_fit, eye.angle = "PERSP", "HORIZONTAL", math.radians(options["fov"])
bpy.context.collection.objects.link(bpy.data.objects.new("camera", eye))
scene.camera = bpy.data.objects["camera"]
scene.camera.matrix_world = looking(vector(camera), vector(target) - vector(camera))

scene.render.engine = "CYCLES"
scene.render.resolution_x = scene.render.resolution_y = int(pixels)
scene.render.resolution_percentage = 100
scene.render.film_transparent = not report
if report:
    scene.render.resolution_x, scene.render.resolution_y = [int(n) for n in options["resolution"].split("x")]
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
