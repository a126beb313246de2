#include "vdbcloud/scatter/ground.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/flux_map.h"
#include "vdbcloud/scene/ground.h"
#include "vdbcloud/voxels/period.h"

#include <numeric>

namespace vdbcloud {

int face_down(const VoxelIndex& index, const Vec3d& up)
{
    for (int a = 0; a < 3; ++a)
        if (const double along = index.axis(a).dot(up.unit()); std::abs(along) > 1 - 1e-6) return 2 * a + (along < 0);
    throw InputError("a ground beneath a grid without an axis that points up: expected one");
}

GroundPlane::GroundPlane(const VoxelIndex& index, const Vec3d& up, double albedo)
    : index_(index), box_(index.blocks()), albedo_(albedo), face_(face_down(index, up))
{
    check_ground_albedo(albedo);
    const int axis = face_ / 2;
    for (int a = 0; a < 3; ++a)
        if (box_.periodic[size_t(a)] != (a != axis))
            throw InputError(std::string("a ground beneath a medium that ") +
                             (a == axis ? "repeats along " : "ends along ") + "xyz"[a] +
                             ": expected one that repeats along the two axes across up, and ends along up");
}

void GroundPlane::mark(std::vector<ExposedVoxel>& exposed) const
{
    const int axis = face_ / 2, lowest = face_ % 2 ? box_.last[axis] : box_.first[axis];
    for (ExposedVoxel& voxel : exposed)
        if (voxel.faces >> face_ & 1 && index_.blocks().voxel(voxel.slot)[axis] == lowest)
            voxel.grounded = uint8_t(1 << face_);
}

void GroundPlane::require_cover() const
{
    for (size_t cell = 0; cell < box_.cells(face_); ++cell)
        if (!index_.blocks().active(index_.blocks().slot(box_.voxel(face_, cell))))
            throw InputError("a ground beneath a medium with gaps in its lowest layer: P1 takes no light through gaps, "
                             "expected transport sweeps (--iterations 5), or a layer without gaps");
}

std::vector<float> GroundPlane::direct(const BeamMedium& medium, const std::vector<Light>& lights, int c) const
{
    const Vec3d down = index_.axis(face_ / 2) * (face_ % 2 ? 1.0 : -1.0);
    for (const Light& light : lights) require_light_above(light, Ground{albedo_, Vec3d(0), -down});
    return direct_on_plane(index_, medium, lights, c, face_, down);
}

void GroundPlane::add_direct(const P1Operator& p1, const std::vector<float>& direct, P1Source& source) const
{
    const double area = p1.face_area(face_ / 2);
    for (size_t k = 0; k < p1.exposed().size(); ++k) {
        const ExposedVoxel& voxel = p1.exposed()[k];
        if (!voxel.grounded) continue;
        const double light = direct[box_.cell(face_, index_.blocks().voxel(voxel.slot))];
        const double leaving = p1.boundary_flux(voxel, face_, 0, -2 * albedo_ / (1 + albedo_) * light) * area;
        source.rhs[voxel.slot] -= leaving;
        source.outflow[k][size_t(face_)] += leaving;
    }
}

std::vector<float> GroundPlane::irradiance(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi,
                                           const std::vector<float>& direct) const
{
    const int axis = face_ / 2;
    const double area = p1.face_area(axis), h = index_.spacing()[axis];
    std::vector<float> cells(box_.cells(face_), 0.0f);
    for (size_t k = 0; k < p1.exposed().size(); ++k) {
        const ExposedVoxel& voxel = p1.exposed()[k];
        if (!voxel.grounded) continue;
        const size_t cell = box_.cell(face_, index_.blocks().voxel(voxel.slot));
        const double flux = (p1.conductance(voxel, face_) * phi[voxel.slot] + source.outflow[k][size_t(face_)]) / area;
        // F = 2 D (phi - phi_b) / h + the beam's part on the face.
        const double of_beam = p1.q1_factor(voxel.slot) / p1.sigma_tr(voxel.slot) * direct[cell];
        const double on_face = phi[voxel.slot] - (flux - of_beam) * 1.5 * p1.sigma_tr(voxel.slot) * h;
        cells[cell] = float(on_face / 4 + flux / 2);
    }
    return cells;
}

double GroundPlane::power(const std::vector<float>& cells) const
{
    const auto [u, v] = ActiveBox::axes(face_ / 2);
    return std::accumulate(cells.begin(), cells.end(), 0.0) * index_.spacing()[u] * index_.spacing()[v];
}

std::vector<float> GroundPlane::radiance(const std::vector<float>& direct, const std::vector<float>& diffuse) const
{
    std::vector<float> cells(direct.size());
    for (size_t n = 0; n < cells.size(); ++n) cells[n] = float(albedo_ / pi * (double(direct[n]) + diffuse[n]));
    return cells;
}

Vec3SGridPtr GroundPlane::grid(const std::array<const std::vector<float>*, 3>& radiance, const Vec3d& scale,
                               const Transform& transform) const
{
    auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setName(schema::ground_radiance);
    grid->setTransform(transform.copy());
    auto accessor = grid->getAccessor();
    for (size_t cell = 0; cell < box_.cells(face_); ++cell) {
        Vec3i at = box_.voxel(face_, cell) + index_.origin();
        at[face_ / 2] += face_ % 2 ? 1 : -1;
        accessor.setValueOn(openvdb::Coord(at[0], at[1], at[2]),
                            Vec3f(Vec3d((*radiance[0])[cell], (*radiance[1])[cell], (*radiance[2])[cell]) * scale));
    }
    return wrapped(*grid, index_.period());
}

}  // namespace vdbcloud
