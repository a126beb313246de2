#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"

#include <openvdb/MetaMap.h>
#include <openvdb/Metadata.h>

#include <cmath>

namespace vdbcloud {

namespace {

/// The value if the metadata is of type T, else null.
template<typename T>
const T* value(const openvdb::Metadata& meta)
{
    const auto* typed = dynamic_cast<const openvdb::TypedMetadata<T>*>(&meta);
    return typed ? &typed->value() : nullptr;
}

[[noreturn]] void refuse_meta(const std::string& key, const openvdb::Metadata& meta, const std::string& expected)
{
    refuse("metadata '" + printable(key) + "'", meta.str(), expected);
}

template<typename T>
void set(MetaMap& map, const std::string& key, const T& x)
{
    map.removeMeta(key);  // insertMeta() throws if the key has another type
    map.insertMeta(key, openvdb::TypedMetadata<T>(x));
}

}  // namespace

bool has_meta(const MetaMap& map, const std::string& key) { return bool(map[key]); }

double get_number(const MetaMap& map, const std::string& key, double otherwise)
{
    const auto meta = map[key];
    if (!meta) return otherwise;
    double x = NAN;
    if (const auto* d = value<double>(*meta))
        x = *d;
    else if (const auto* f = value<float>(*meta))
        x = double(*f);
    else if (const auto* i = value<int32_t>(*meta))
        x = *i;
    else if (const auto* l = value<int64_t>(*meta))
        x = double(*l);
    if (!std::isfinite(x)) refuse_meta(key, *meta, "a finite number");
    return x;
}

Vec3d get_vector(const MetaMap& map, const std::string& key, const Vec3d& otherwise)
{
    const auto meta = map[key];
    if (!meta) return otherwise;
    Vec3d x(NAN);
    if (const auto* d = value<Vec3d>(*meta))
        x = *d;
    else if (const auto* f = value<Vec3f>(*meta))
        x = Vec3d(*f);
    else if (const auto* i = value<Vec3i>(*meta))
        x = Vec3d(*i);
    if (!x.isFinite()) refuse_meta(key, *meta, "three finite numbers");
    return x;
}

std::string get_text(const MetaMap& map, const std::string& key, const std::string& otherwise)
{
    const auto meta = map[key];
    if (!meta) return otherwise;
    const auto* text = value<std::string>(*meta);
    if (!text) refuse_meta(key, *meta, "text");
    return *text;
}

void set_number(MetaMap& map, const std::string& key, double x) { set(map, key, x); }
void set_vector(MetaMap& map, const std::string& key, const Vec3d& x) { set(map, key, x); }
void set_text(MetaMap& map, const std::string& key, const std::string& x) { set(map, key, x); }

}  // namespace vdbcloud
