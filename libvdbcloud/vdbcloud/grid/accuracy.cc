#include "vdbcloud/grid/accuracy.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace vdbcloud {

namespace {

constexpr char between = ';';

std::string key_of(const std::string& name) { return schema::accuracy_prefix + name; }

}  // namespace

const std::vector<AccuracyKind>& accuracy_kinds()
{
    static const std::vector<AccuracyKind> all = {
        {"residual", "of the linear system"},
        {"solver_error", "estimate of the solver's error in phi"},
        {"change", "last change of the light by a sweep, rms"},
        {"contraction", "ratio of the last changes"},
        {"sweep_error", "estimate of what further sweeps would change"},
        {"voxel_error", "estimate of the error of phi by the size of the voxels, rms"},
        {"defect", "power that enters less what leaves and is absorbed"},
        {"faces_against_lines", "power that the suns lose, by voxel faces over by lines, less 1"},
        {"lost_at_voids", "share of the outflow that would enter again"},
        {"emission_scaled_by", "light of emission by rays, multiplied by 1 and this for the balance of power"},
        {"planes_scaled_by", "light of sweeps on the planes about the medium, multiplied by 1 and this for the same"},
        {"mean_transmittance_error", "of compared voxels, against exact rays"},
        {"max_transmittance_error", "of compared voxels, against exact rays"},
        {"series_phi_error", "of the series' phi against the direct solution, rms"},
        {"series_error", "of what a picture sees of the series, rms"}};
    return all;
}

void write_accuracy(MetaMap& to, const Accuracy& accuracy)
{
    for (const AccuracyKind& kind : accuracy_kinds()) to.removeMeta(key_of(kind.name));
    to.removeMeta(schema::left_out);
    for (const auto& figure : accuracy.figures) {
        const auto is_it = [&](const AccuracyKind& kind) { return figure.first == kind.name; };
        const auto& kinds = accuracy_kinds();
        if (std::none_of(kinds.begin(), kinds.end(), is_it))
            throw std::logic_error("no figure of accuracy: " + figure.first);
        if (std::isfinite(figure.second)) set_number(to, key_of(figure.first), figure.second);
    }
    std::string list;
    for (const std::string& part : accuracy.left_out) list += (list.empty() ? "" : "; ") + part;
    if (!list.empty()) set_text(to, schema::left_out, list);
}

Accuracy read_accuracy(const MetaMap& from)
{
    Accuracy accuracy;
    for (const AccuracyKind& kind : accuracy_kinds())
        if (has_meta(from, key_of(kind.name))) accuracy.add(kind.name, get_number(from, key_of(kind.name), 0));
    std::istringstream list(get_text(from, schema::left_out, ""));
    for (std::string part; std::getline(list >> std::ws, part, between);) accuracy.left_out.push_back(part);
    return accuracy;
}

std::string text_of(const Accuracy& accuracy)
{
    std::ostringstream text;
    text.precision(2);
    for (const auto& [name, value] : accuracy.figures) {
        std::string words = name;
        std::replace(words.begin(), words.end(), '_', ' ');
        text << (text.tellp() > 0 ? ", " : "") << words << ' ' << value;
    }
    for (size_t k = 0; k < accuracy.left_out.size(); ++k)
        text << (k > 0 ? ", " : accuracy.figures.empty() ? "left out: " : "; left out: ") << accuracy.left_out[k];
    return text.str();
}

}  // namespace vdbcloud
