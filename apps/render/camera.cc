#include "camera.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/extent.h"

namespace vdbcloud {

namespace {

std::vector<Vec3d> unit_box()
{
    std::vector<Vec3d> corners;
    for (int k = 0; k < 8; ++k) corners.push_back(Vec3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    return corners;
}

SeenExtent seen_extent(const Scene& scene)
{
    SeenExtent extent;
    const auto add = [&](const std::vector<Vec3d>& corners) {
        extent.points.insert(extent.points.end(), corners.begin(), corners.end());
    };
    for (const Volume& volume : scene.volumes) {
        add(interpolant_corners(*volume.density));
        if (volume.emission) add(interpolant_corners(*volume.emission));
    }
    if (scene.volumes.empty()) return extent;
    const Transform& transform = scene.volumes[0].density->transform();
    for (int a = 0; a < 3; ++a)
        if (scene.periodic[size_t(a)])
            extent.repeats.push_back(transform.indexToWorld(Vec3d(a == 0, a == 1, a == 2)) -
                                     transform.indexToWorld(Vec3d(0.0)));
    return extent;
}

}  // namespace

Camera chosen_camera(app::App& app, const RenderOptions& o, const LoadedScene& loaded, const ImageSize& size)
{
    const bool placed = o.option.camera.given(), aimed = o.option.look_at.given(),
               directed = o.option.direction.given();
    if (placed && aimed && directed)
        throw UsageError("--direction follows from --camera and --look-at: give two of the three");
    const std::vector<Vec3d>& corners = loaded.corners.empty() ? unit_box() : loaded.corners;

    FramingOptions framing = o.framing;
    framing.projection = o.camera.projection;
    framing.fov = o.camera.fov;
    framing.up = vector_of(loaded.up);
    framing.direction = o.direction;
    Camera camera = frame_points(corners, size, framing);
    const Vec3d ahead = camera.look_at - camera.position;  // as far as the framed camera stands

    if (placed) camera.position = o.camera.position;
    if (aimed) camera.look_at = o.camera.look_at;
    if (placed && directed) camera.look_at = camera.position + ahead;
    if (aimed && !placed) camera.position = camera.look_at - ahead;
    if (o.option.ortho_width.given()) camera.width = o.camera.width;

    const SeenExtent extent = seen_extent(loaded.scene);
    if (!placed) camera = before_all(camera, size, extent);
    // A perspective camera within a cloud is a choice, the plane of an orthographic one easily a mistake.
    if (!placed || camera.projection == Projection::Orthographic)
        if (way_before(CameraView(camera, size), extent) > 1e-9 * (camera.look_at - camera.position).length())
            app.say("part of the medium lies behind the camera and is not in the picture: --camera places it");
    return camera;
}

}  // namespace vdbcloud
