// Points of OpenVDB's PointDataGrids as particles.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/particles.h"
#include "vdbcloud/file/io.h"

#include <openvdb/points/AttributeArray.h>
#include <openvdb/points/PointDataGrid.h>

namespace vdbcloud {

namespace {

using openvdb::points::AttributeArray;
using openvdb::points::AttributeHandle;
using Leaf = openvdb::points::PointDataTree::LeafNodeType;

/// The values of an attribute of one leaf, whatever their type.
class Attribute {
public:
    Attribute() = default;
    explicit Attribute(const AttributeArray& array)
    {
        if (array.stride() != 1) return;
        const openvdb::Name type = array.valueType();
        if (type == "float")
            read_number<float>(array);
        else if (type == "double")
            read_number<double>(array);
        else if (type == "half")
            read_number<openvdb::math::half>(array);
        else if (type == "vec3s")
            read_vector<openvdb::Vec3f>(array);
        else if (type == "vec3d")
            read_vector<openvdb::Vec3d>(array);
    }

    size_t components = 0;  ///< 1 or 3; 0: another type
    Vec3d at(uint32_t index) const { return get_(index); }

private:
    template<typename T>
    void read_number(const AttributeArray& array)
    {
        components = 1;
        get_ = [handle = AttributeHandle<T>::create(array)](uint32_t k) {
            return Vec3d(static_cast<double>(static_cast<float>(handle->get(k))));
        };
    }
    template<typename T>
    void read_vector(const AttributeArray& array)
    {
        components = 3;
        get_ = [handle = AttributeHandle<T>::create(array)](uint32_t k) { return Vec3d(handle->get(k)); };
    }

    std::function<Vec3d(uint32_t)> get_;
};

/// The first of the common names of a role that the leaf has with `components` numbers.
std::string name_of(const Leaf& leaf, const ParticleNames& chosen, const std::string& role, size_t components,
                    const std::vector<std::string>& common)
{
    const auto fits = [&](const std::string& name) {
        const size_t at = leaf.attributeSet().find(name);
        return at != openvdb::points::AttributeSet::INVALID_POS &&
               Attribute(leaf.constAttributeArray(at)).components == components;
    };
    if (const auto named = chosen.find(role); named != chosen.end()) {
        if (fits(named->second)) return named->second;
        throw InputError("points have no attribute '" + printable(named->second, 40) + "' (" + role + ") of " +
                         std::to_string(components) + " numbers");
    }
    for (const std::string& name : common)
        if (fits(name)) return name;
    return {};
}

/// Names of the attributes of a grid by particle_columns().
struct Names {
    std::array<std::string, 6> role;  // position, radius, mass, density, temperature, velocity
    std::array<int, 10> columns{};

    Names(const Leaf& leaf, const ParticleNames& chosen)
    {
        role = {name_of(leaf, chosen, "position", 3, {"P"}),
                name_of(leaf, chosen, "radius", 1, {"pscale", "radius"}),
                name_of(leaf, chosen, "mass", 1, {"mass"}),
                name_of(leaf, chosen, "density", 1, {"density", "rho"}),
                name_of(leaf, chosen, "temperature", 1, {"temperature", "temp"}),
                name_of(leaf, chosen, "velocity", 3, {"v", "vel", "velocity"})};
        if (role[0].empty()) throw InputError("points have no attribute P: expected their positions");
        for (size_t c = 0; c < columns.size(); ++c) columns[c] = role[c < 3 ? 0 : c < 7 ? c - 2 : 5].empty() ? -1 : 0;
    }
};

void add_leaf(const Leaf& leaf, const Transform& transform, const Names& names, const std::string& where,
              Particles& particles)
{
    leaf.validateOffsets();  // of a damaged file
    std::array<Attribute, 6> attributes;
    for (size_t r = 0; r < 6; ++r)
        if (!names.role[r].empty()) {
            const size_t at = leaf.attributeSet().find(names.role[r]);
            if (at == openvdb::points::AttributeSet::INVALID_POS) throw InputError("leaves differ in their attributes");
            attributes[r] = Attribute(leaf.constAttributeArray(at));
            if (attributes[r].components != (r == 0 || r == 5 ? 3u : 1u))
                throw InputError("attribute '" + printable(names.role[r], 40) + "' differs in type between leaves");
        }
    for (auto index = leaf.beginIndexOn(); index; ++index) {
        std::array<double, 10> values{};
        const Vec3d place = transform.indexToWorld(attributes[0].at(*index) + index.getCoord().asVec3d());
        for (size_t k = 0; k < 3; ++k) values[k] = place[int(k)];
        for (size_t r = 1; r < 5; ++r)
            if (attributes[r].components > 0) values[r + 2] = attributes[r].at(*index)[0];
        if (attributes[5].components > 0)
            for (size_t k = 0; k < 3; ++k) values[k + 7] = attributes[5].at(*index)[int(k)];
        add_particle(particles, names.columns, values, [&] { return where; });
    }
}

}  // namespace

Particles read_points(const std::string& path, const ParticleNames& chosen)
{
    const GridFile file = read_grid_file(path);
    Particles particles;
    std::array<int, 10> columns{};
    bool any = false;
    for (const GridBasePtr& base : file.grids) {
        const auto grid = std::dynamic_pointer_cast<openvdb::points::PointDataGrid>(base);
        if (!grid) continue;
        const std::string where = printable(path, 4096) + ": grid '" + printable(grid->getName()) + "': ";
        try {
            const auto first = grid->tree().cbeginLeaf();
            if (!first) continue;
            const Names names(*first, chosen);
            if (any && names.columns != columns)
                throw InputError("expected the attributes of the points before; import one grid at a time");
            any = true;
            columns = names.columns;
            for (auto leaf = first; leaf; ++leaf) add_leaf(*leaf, grid->transform(), names, "", particles);
        } catch (const openvdb::Exception& e) {
            throw InputError(where + "damaged points: " + printable(e.what()));
        } catch (const InputError& e) {
            throw InputError(where + e.what());
        }
    }
    if (!any)
        throw InputError(
            printable(path, 4096) +
            ": holds no points: a .vdb of volumes needs no import, illuminate, p1solve and render read it");
    return particles;
}

}  // namespace vdbcloud
