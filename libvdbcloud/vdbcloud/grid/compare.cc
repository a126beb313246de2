#include "vdbcloud/grid/compare.h"

#include "vdbcloud/core/archive_layout.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/compare_trees.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"

#include <openvdb/io/Stream.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <set>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Keys that only one of two maps has, and keys whose type or value differs.
std::vector<std::string> differing_keys(const MetaMap& a, const MetaMap& b)
{
    std::set<std::string> keys;
    for (const MetaMap* map : {&a, &b})
        for (auto it = map->beginMeta(); it != map->endMeta(); ++it)
            if (!is_volatile(it->first)) keys.insert(it->first);
    std::vector<std::string> differing;
    for (const std::string& key : keys) {
        const auto x = a[key], y = b[key];
        if (!x || !y || !(*x == *y)) differing.push_back(key);
    }
    return differing;
}

double transform_difference(const Transform& a, const Transform& b)
{
    if (a == b) return 0;
    if (!a.isLinear() || !b.isLinear()) return infinite;
    const auto p = a.baseMap()->getAffineMap()->getMat4(), q = b.baseMap()->getAffineMap()->getMat4();
    double most = 0, scale = 0;
    for (int k = 0; k < 16; ++k) {
        most = std::max(most, std::abs(p.asPointer()[k] - q.asPointer()[k]));
        scale = std::max({scale, std::abs(p.asPointer()[k]), std::abs(q.asPointer()[k])});
    }
    return most / scale;
}

/// Digest of a grid's stored bytes without its metadata, for value types that compare_trees() does not support.
std::string stored_digest(const GridBase& grid)
{
    const auto bare = grid.copyGridReplacingMetadata(MetaMap());
    std::ostringstream text;
    openvdb::io::Stream(text).write(openvdb::GridCPtrVec{bare});
    const std::string bytes = text.str();
    Digest digest;
    digest.add(bytes.data() + identifier_end, bytes.size() - identifier_end);
    return digest.hex();
}

void measure_values(const GridBase& a, const GridBase& b, GridDifference& result)
{
    TreeDifference difference;
    if (!compare_trees(a.baseTree(), b.baseTree(), difference)) {
        result.by_value = false;
        result.voxels = a.activeVoxelCount();
        if (stored_digest(a) != stored_digest(b)) result.max = result.rms = result.relative = infinite;
        return;
    }
    result.max = std::max(difference.max, difference.background);
    result.where = difference.where;
    result.voxels = difference.voxels;
    result.only_a = difference.only_a;
    result.only_b = difference.only_b;
    if (difference.voxels == 0) return;
    result.rms = std::sqrt(difference.sum_squares / double(difference.voxels));
    result.relative = difference.sum_squares == 0 ? 0 : std::sqrt(difference.sum_squares / difference.sum_squares_a);
}

std::string number(double x)
{
    std::ostringstream text;
    text << x;
    return text.str();
}

void beyond(const GridDifference& d, const Tolerances& allowed, std::vector<std::string>& reasons)
{
    const std::string grid = "grid '" + printable(d.label) + "': ";
    if (!d.comparable) {
        reasons.push_back(grid + "of different types (" + d.types + ")");
        return;
    }
    const auto check = [&](double found, double most, const std::string& what) {
        if (!(found <= most))
            reasons.push_back(grid + what + " " + number(found) + ": expected at most " + number(most));
    };
    std::ostringstream where;
    where << " at [" << d.where[0] << ", " << d.where[1] << ", " << d.where[2] << "]";
    if (!d.by_value && d.max > 0)
        reasons.push_back(grid + "its stored contents differ");
    else if (!(d.max <= allowed.max))
        reasons.push_back(grid + "largest difference " + number(d.max) + where.str() + ": expected at most " +
                          number(allowed.max));
    check(d.rms, allowed.rms, "rms difference");
    check(d.relative, allowed.relative, "relative difference");
    check(d.voxels ? double(d.only_a + d.only_b) / double(d.voxels) : 0, allowed.topology,
          "part of voxels active in one alone");
    check(d.transform, allowed.transform, "transform's relative difference");
    if (allowed.metadata)
        for (const auto& key : d.metadata) reasons.push_back(grid + "metadata '" + printable(key) + "' differs");
}

}  // namespace

bool is_volatile(const std::string& key)
{
    return key.rfind("file_", 0) == 0 || key == schema::creator || key == schema::history || key == schema::format ||
           key == GridBase::META_IS_LOCAL_SPACE || key == GridBase::META_SAVE_HALF_FLOAT;
}

GridDifference compare_grids(const GridBase& a, const GridBase& b)
{
    GridDifference result;
    result.label = a.getName();
    result.types = a.valueType();
    result.comparable = a.type() == b.type();
    result.metadata = differing_keys(a, b);
    if (!result.comparable) {
        result.types += ", " + b.valueType();
        return result;
    }
    result.transform = transform_difference(a.transform(), b.transform());
    measure_values(a, b, result);
    return result;
}

FileDifference compare_files(const GridFile& a, const GridFile& b, const std::vector<std::string>& which)
{
    FileDifference result;
    const auto labels_a = grid_labels(a), labels_b = grid_labels(b);
    const auto has = [](const std::vector<std::string>& all, const std::string& one) {
        return std::find(all.begin(), all.end(), one) != all.end();
    };
    for (const auto& label : which)
        if (!has(labels_a, label) && !has(labels_b, label))
            throw InputError(printable(a.path, 4096) + ", " + printable(b.path, 4096) + ": no grid '" +
                             printable(label) + "': they have " + grid_list(a) + " and " + grid_list(b));
    const auto wanted = [&](const std::string& label) { return which.empty() || has(which, label); };
    for (const auto& label : labels_a) {
        if (!wanted(label)) continue;
        if (!has(labels_b, label)) {
            result.only_a.push_back(label);
            continue;
        }
        result.grids.push_back(compare_grids(*find_grid(a, label), *find_grid(b, label)));
        result.grids.back().label = label;
    }
    for (const auto& label : labels_b)
        if (wanted(label) && !has(labels_a, label)) result.only_b.push_back(label);
    if (which.empty()) result.metadata = differing_keys(*a.metadata, *b.metadata);
    return result;
}

std::vector<std::string> beyond(const FileDifference& difference, const Tolerances& allowed)
{
    std::vector<std::string> reasons;
    for (const auto& label : difference.only_a)
        reasons.push_back("grid '" + printable(label) + "' is in the first file alone");
    for (const auto& label : difference.only_b)
        reasons.push_back("grid '" + printable(label) + "' is in the second file alone");
    for (const auto& grid : difference.grids) beyond(grid, allowed, reasons);
    if (allowed.metadata)
        for (const auto& key : difference.metadata)
            reasons.push_back("the files' metadata '" + printable(key) + "' differs");
    return reasons;
}

}  // namespace vdbcloud
