#pragma once
// What invariants share: the values of grids, and what the options of a world say. Private to hard/.
#include "hard/judge.h"
#include "vdbcloud/core/vdb.h"

namespace vdbcloud::test {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double half_rounding = 0x1p-10, half_least = 0x1p-24;  ///< of 16-bit floats: relative and absolute

bool begins(const std::string& text, const std::string& with);

std::string name_of(const std::string& grid, const openvdb::Coord& c);

double largest(const Vec3d& v);

/// A twin that could not be computed differs without end.
bool failed(const Seen& seen, Verdict& verdict);

/// The value after an option, or `otherwise`.
std::string option(const std::string& words, const std::string& name, const std::string& otherwise);

Vec3d colour(const std::string& numbers);

void remove_option(std::string& words, const std::string& name);

bool has_discs(const World& world);

bool has_lamps(const World& world);

bool emits(const World& world);

double mean(const std::vector<float>& values);

/// Reads a float or vec3s grid as vectors: of a float grid three times its value.
class Vectors {
public:
    explicit Vectors(const GridBasePtr& grid)
        : grid_(grid), floats_(openvdb::gridPtrCast<FloatGrid>(grid)), vectors_(openvdb::gridPtrCast<Vec3SGrid>(grid))
    {
        if (const auto scale = grid->getMetadata<openvdb::Vec3DMetadata>("vdbcloud:channel_scale"); floats_ && scale)
            scale_ = scale->value();
    }
    Vec3d place(const openvdb::Coord& c) const { return grid_->transform().indexToWorld(c); }
    Vec3d index(const Vec3d& place) const { return grid_->transform().worldToIndex(place); }
    bool readable() const { return floats_ || vectors_; }
    bool active(const openvdb::Coord& c) const
    {
        return floats_ ? floats_->tree().isValueOn(c) : vectors_->tree().isValueOn(c);
    }
    /// With the factors of the channels that share the grid.
    Vec3d colour(const openvdb::Coord& c) const { return scale_ * value(c); }
    Vec3d value(const openvdb::Coord& c) const
    {
        return floats_ ? Vec3d(floats_->tree().getValue(c)) : Vec3d(vectors_->tree().getValue(c));
    }
    void each(const std::function<void(const openvdb::Coord&)>& visit) const
    {
        if (floats_)
            for (auto v = floats_->cbeginValueOn(); v; ++v) visit(v.getCoord());
        if (vectors_)
            for (auto v = vectors_->cbeginValueOn(); v; ++v) visit(v.getCoord());
    }

private:
    GridBasePtr grid_;
    std::shared_ptr<FloatGrid> floats_;
    std::shared_ptr<Vec3SGrid> vectors_;
    Vec3d scale_{1, 1, 1};
};

}  // namespace vdbcloud::test
