#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/scene/panorama.h"
#include "vdbcloud/scene/sky_kinds.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

const std::vector<const SkyKind*>& sky_kinds()
{
    static const std::vector<const SkyKind*> kinds = {&gradient_kind, &preetham_kind, &environment_kind};
    return kinds;
}

template<typename T>
[[noreturn]] void refuse(const char* what, const T& value, const std::string& expected)
{
    std::ostringstream sentence;
    sentence << "sky's " << what << " " << value << ": expected " << expected;
    throw InputError(sentence.str());
}

void check(const SkyParameter& parameter, const Vec3d& value)
{
    for (int c = 0; c < 3; ++c) {
        if (value[c] >= parameter.least && value[c] <= parameter.most && std::isfinite(value[c])) continue;
        std::ostringstream expected;
        if (std::isfinite(parameter.most))
            expected << "a number in [" << parameter.least << ", " << parameter.most << "]";
        else if (std::isfinite(parameter.least))
            expected << "finite numbers, " << parameter.least << " or above";
        else
            expected << "finite numbers";
        if (parameter.vector) refuse(parameter.name, value, expected.str());
        refuse(parameter.name, value[0], expected.str());
    }
}

}  // namespace

Sky::Sky(const SkyKind& kind, const Vec3d& up, std::vector<Vec3d> parameters, std::shared_ptr<const Panorama> map)
    : kind_(&kind), description_{up, std::move(parameters), false, std::move(map)}
{
    if (!(up.length() > 0 && std::isfinite(up.length()))) refuse("up", up, "a vector with a length above 0");
    description_.up = up.unit();
    for (size_t p = 0; p < kind.parameters.size(); ++p) check(kind.parameters[p], description_.parameters[p]);
    make_model();
}

void Sky::make_model()
{
    model_ = kind_->model(description_);
    const auto all = tones();
    dark_ = std::all_of(all.begin(), all.end(), [](const Vec3d& tone) { return tone == Vec3d(0.0); });
}

Sky Sky::above_horizon() const
{
    Sky sky = *this;
    sky.description_.ends_at_horizon = true;
    sky.make_model();
    return sky;
}

bool operator==(const Sky& a, const Sky& b)
{
    if (bool(a.map()) != bool(b.map()) || (a.map() && a.map()->digest() != b.map()->digest())) return false;
    return a.kind_ == b.kind_ && a.up() == b.up() && a.parameters() == b.parameters() &&
           a.description_.ends_at_horizon == b.description_.ends_at_horizon;
}

void write_sky(MetaMap& to, const Sky& sky)
{
    set_text(to, schema::lit_sky_kind, sky.kind().word);
    set_vector(to, schema::lit_sky_up, sky.up());
    if (sky.map()) set_text(to, schema::lit_sky_texels, sky.map()->digest());
    for (size_t p = 0; p < sky.parameters().size(); ++p) {
        const SkyParameter& parameter = sky.kind().parameters[p];
        if (parameter.vector)
            set_vector(to, parameter.key, sky.parameters()[p]);
        else
            set_number(to, parameter.key, sky.parameters()[p][0]);
    }
}

namespace {

std::shared_ptr<const Panorama> texels_of(const MetaMap& from, const GridFile* file)
{
    const std::string digest = get_text(from, schema::lit_sky_texels, "");
    if (digest.empty() || !file) return nullptr;
    auto map = panorama_of(*file);
    if (map && map->digest() != digest)
        throw InputError("grid 'environment' is not the one that lit the medium: run p1solve again");
    return map;
}

}  // namespace

std::optional<Sky> read_sky(const MetaMap& from, const GridFile* file)
{
    const std::string word = get_text(from, schema::lit_sky_kind, gradient_kind.word);
    std::string words;
    for (const SkyKind* kind : sky_kinds()) {
        words += (words.empty() ? "" : " or ") + std::string(kind->word);
        if (word != kind->word) continue;
        std::vector<Vec3d> values;
        for (const SkyParameter& parameter : kind->parameters) {
            const Vec3d otherwise = std::isnan(parameter.otherwise) ? values.front() : Vec3d(parameter.otherwise);
            values.push_back(parameter.vector ? get_vector(from, parameter.key, otherwise)
                                              : Vec3d(get_number(from, parameter.key, otherwise[0])));
        }
        const Sky sky(*kind, get_vector(from, schema::lit_sky_up, Vec3d(0, 1, 0)), std::move(values),
                      texels_of(from, file));
        if (sky.dark()) return std::nullopt;
        return sky;
    }
    refuse("kind", "'" + printable(word) + "'", words);
}

}  // namespace vdbcloud
