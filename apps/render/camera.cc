#include "camera.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud {

namespace {

std::vector<Vec3d> unit_box()
{
    std::vector<Vec3d> corners;
    for (int k = 0; k < 8; ++k) corners.push_back(Vec3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    return corners;
}

}  // namespace

Camera chosen_camera(const RenderOptions& o, const LoadedScene& loaded, const ImageSize& size)
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
    return camera;
}

}  // namespace vdbcloud
