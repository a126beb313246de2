#pragma once
// What bounds the error of a result, as metadata of its grids: one family of keys for all stages.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <utility>
#include <vector>

namespace vdbcloud {

/// A kind of figure: its name in metadata (schema::accuracy_prefix + name) and in lines for people.
struct AccuracyKind {
    const char* name;
    const char* meaning;  ///< as docs/format.md has it
};

/// All kinds, in the order in which they are told.
const std::vector<AccuracyKind>& accuracy_kinds();

/// In Accuracy::left_out: what a value for a whole voxel loses about a lamp.
inline constexpr const char* lamp_cusp = "the cusp of a lamp's light within its voxel";

/// Figures of one result. All are relative to the result, 0 is exact.
struct Accuracy {
    std::vector<std::pair<std::string, double>> figures;  ///< names are those of accuracy_kinds()
    std::vector<std::string> left_out;                    ///< parts of the light that the result does not have

    void add(const std::string& name, double value) { figures.emplace_back(name, value); }
    bool empty() const { return figures.empty() && left_out.empty(); }
};

/// Replaces what an earlier stage wrote about the grid. Throws std::logic_error for a name that is not of
/// accuracy_kinds().
void write_accuracy(MetaMap&, const Accuracy&);

/// What write_accuracy() wrote; empty if nothing. Throws InputError for a value that is not a finite number.
Accuracy read_accuracy(const MetaMap&);

/// "residual 3.1e-07, defect 2e-09; left out: ...", two digits each; empty for no figures.
std::string text_of(const Accuracy&);

}  // namespace vdbcloud
