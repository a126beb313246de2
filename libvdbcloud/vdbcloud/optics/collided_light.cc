#include "vdbcloud/optics/collided_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

namespace vdbcloud {

namespace {

/// True where the three channels are multiples of one solution.
bool shared(const CollidedLight& light) { return bool(openvdb::gridPtrCast<FloatGrid>(light.phi)); }

/// Calls visit(grid) for each grid of the light once.
template<typename Visit>
void for_each_grid(const CollidedLight& light, const Visit& visit)
{
    visit(*light.phi);
    for (size_t c = 0; c < (shared(light) ? 1u : 3u); ++c) {
        if (light.flux[c]) visit(*light.flux[c]);
        for (const auto& moment : light.moments[c]) visit(*moment);
    }
}

/// The grid called `name` as a GridT; null if there is none. Throws InputError for another type.
template<typename GridT>
typename GridT::Ptr typed(const GridFile& file, const std::string& name)
{
    const GridBasePtr grid = find_grid(file, name);
    if (!grid) return nullptr;
    auto found = openvdb::gridPtrCast<GridT>(grid);
    if (!found)
        throw InputError(file.path + ": grid '" + name + "' is " + grid->valueType() + ": expected " +
                         std::string(openvdb::typeNameAsString<typename GridT::ValueType>()) + "; run p1solve again");
    return found;
}

/// The moment of channel c. A file of format 1 may share moments, with channel_scale, beside phi and fluxes of their
/// own.
FloatGridPtr moment_of(const GridFile& file, int l, int m, int c, bool one)
{
    if (one) return typed<FloatGrid>(file, schema::moment_name(l, m, -1));
    if (const auto own = typed<FloatGrid>(file, schema::moment_name(l, m, c))) return own;
    const auto shared = typed<FloatGrid>(file, schema::moment_name(l, m, -1));
    const double scale = shared ? get_vector(*shared, schema::channel_scale, Vec3d(1.0))[c] : 1.0;
    if (scale == 1) return shared;
    const auto scaled = shared->deepCopy();
    for (auto v = scaled->beginValueOn(); v; ++v) v.setValue(float(scale * double(*v)));
    return scaled;
}

/// A grid of vectors with the topology of `from`: value(v) of each value v.
template<typename GridT, typename Value>
Vec3SGridPtr mapped(const GridT& from, const std::string& name, const Value& value)
{
    auto grid = Vec3SGrid::create(value(from.background()));
    grid->setTree(std::make_shared<openvdb::Vec3STree>(from.tree(), value(from.background()), openvdb::TopologyCopy()));
    grid->setTransform(from.transform().copy());
    grid->setName(name);
    const auto at = from.getConstAccessor();
    for (auto v = grid->beginValueOn(); v; ++v) v.setValue(value(at.getValue(v.getCoord())));
    return grid;
}

}  // namespace

Vec3SGridPtr fluence(const CollidedLight& light)
{
    if (!light.phi) return nullptr;
    const auto one = openvdb::gridPtrCast<FloatGrid>(light.phi);
    if (!one) return openvdb::gridPtrCast<Vec3SGrid>(light.phi);
    return mapped(*one, schema::phi, [&](float v) { return Vec3f(double(v) * light.channel_scale); });
}

Vec3SGridPtr flux_of(const CollidedLight& light, int channel)
{
    const Vec3SGridPtr& flux = light.flux[size_t(channel)];
    const double scale = light.channel_scale[channel];
    if (!flux || scale == 1) return flux;
    return mapped(*flux, schema::flux_name(channel), [&](const Vec3f& v) { return Vec3f(Vec3d(v) * scale); });
}

void name_collided_light(const CollidedLight& light, const std::function<void(GridBase&)>& stamp)
{
    const bool one = shared(light);
    light.phi->setName(schema::phi);
    for (int c = 0; c < (one ? 1 : 3); ++c) {
        if (light.flux[size_t(c)]) {
            light.flux[size_t(c)]->setName(one ? schema::flux : schema::flux_name(c));
            light.flux[size_t(c)]->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
        }
        size_t k = 0;
        for (int l = 2; k < light.moments[size_t(c)].size(); ++l)
            for (int m = -l; m <= l; ++m)
                light.moments[size_t(c)][k++]->setName(schema::moment_name(l, m, one ? -1 : c));
    }
    for_each_grid(light, [&](GridBase& grid) {
        stamp(grid);
        write_delta_scaling(grid, light.scaling);
        if (one) set_vector(grid, schema::channel_scale, light.channel_scale);
        if (light.flux_limit > 0) set_number(grid, schema::flux_limit, light.flux_limit);
    });
}

void put_collided_light(GridFile& file, const CollidedLight& light)
{
    remove_grids(file, [](const std::string& name) {
        using schema::Role;
        return schema::has_role(name, Role::Fluence) || schema::has_role(name, Role::Flux) ||
               schema::has_role(name, Role::Moment);
    });
    if (!light.phi) return;
    const int last = light.scaling.last_degree();
    put_grid(file, light.phi);
    for (size_t c = 0; c < (shared(light) ? 1u : 3u); ++c) {
        if (light.flux[c] && light.scaling.mean_cosine() != 0) put_grid(file, light.flux[c]);
        size_t k = 0;
        for (int l = 2; l <= last; ++l)
            for (int m = -l; m <= l && k < light.moments[c].size(); ++m) put_grid(file, light.moments[c][k++]);
    }
}

GridBasePtr fluence_grid(const GridFile& file)
{
    const GridBasePtr phi = find_grid(file, schema::phi);
    if (!phi || phi->empty()) return nullptr;
    if (phi->isType<FloatGrid>() && has_meta(*phi, schema::degree) && !has_meta(*phi, schema::channel_scale))
        throw InputError(file.path + ": " + meta_name(*phi, schema::channel_scale) +
                         " is missing: expected three numbers; run p1solve again");
    const bool ours = phi->isType<Vec3SGrid>() || (phi->isType<FloatGrid>() && has_meta(*phi, schema::channel_scale));
    return ours ? phi : nullptr;
}

CollidedLight read_collided_light(const GridFile& file, const PhaseFunction& phase, const Warn& listener)
{
    CollidedLight light;
    light.phi = fluence_grid(file);
    if (!light.phi) return {};
    const bool one = shared(light);
    if (one) light.channel_scale = get_vector(*light.phi, schema::channel_scale, Vec3d(1.0));
    light.flux_limit = get_number(*light.phi, schema::flux_limit, 0);
    light.scaling = read_delta_scaling(*light.phi, phase);
    for (int c = 0; c < 3; ++c)
        light.flux[size_t(c)] = typed<Vec3SGrid>(file, one ? schema::flux : schema::flux_name(c));
    const int degree = light.scaling.last_degree();
    const bool no_flux = light.scaling.mean_cosine() != 0 && !(light.flux[0] && light.flux[1] && light.flux[2]);
    if (no_flux)
        warn(listener, file.path + ": collided light was scattered to degree " + std::to_string(degree) +
                           " and its flux is missing: the picture has it as if it were isotropic");
    for (int l = 2; l <= degree && !no_flux; ++l) {
        std::array<std::vector<FloatGridPtr>, 3> of_degree;
        bool whole = true;
        for (int c = 0; c < 3; ++c)
            for (int m = -l; m <= l; ++m) {
                of_degree[size_t(c)].push_back(moment_of(file, l, m, c, one));
                whole = whole && of_degree[size_t(c)].back();
            }
        if (!whole) {
            warn(listener, file.path + ": collided light was scattered to degree " + std::to_string(degree) +
                               " and is kept to degree " + std::to_string(l - 1) +
                               ": the picture lacks higher degrees");
            break;
        }
        for (size_t c = 0; c < 3; ++c)
            light.moments[c].insert(light.moments[c].end(), of_degree[c].begin(), of_degree[c].end());
    }
    return light;
}

}  // namespace vdbcloud
