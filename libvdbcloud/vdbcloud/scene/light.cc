#include "vdbcloud/scene/light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scene/light_kinds.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

const std::vector<const LightKind*>& light_kinds()
{
    static const std::vector<const LightKind*> kinds{&sun_kind, &lamp_kind, &spot_kind};  // in the order of help
    return kinds;
}

namespace {

bool plain_name(const std::string& text)
{
    if (text.empty()) return false;
    for (const char c : text)
        if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9') && c != '_') return false;
    return true;
}

bool is_finite(const Vec3d& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

template<typename T>
[[noreturn]] void refuse(const std::string& light, const char* what, const T& value, const std::string& expected)
{
    std::ostringstream sentence;
    sentence << "light '" << printable(light) << "': " << what << " " << value << ": expected " << expected;
    throw InputError(sentence.str());
}

constexpr const char* between = "; ";

std::string sorted_list(std::vector<std::string> texts)
{
    std::sort(texts.begin(), texts.end());
    std::string list;
    for (const std::string& text : texts) list += (list.empty() ? "" : between) + text;
    return list;
}

std::string text_of(const Light& light)
{
    std::ostringstream text;
    text.precision(12);
    const Vec3d &at = light.place(), &strength = light.strength();
    text << light.name << ' ' << light.kind().preposition << ' ' << at[0] << ',' << at[1] << ',' << at[2] << " of "
         << strength[0] << ',' << strength[1] << ',' << strength[2];
    for (size_t p = 1; p < light.parameters().size(); ++p) {
        const LightParameter& parameter = light.kind().parameters[p];
        const Vec3d& value = light.parameters()[p];
        if (parameter.type == LightValue::Direction)
            text << ' ' << parameter.name << ' ' << value[0] << ',' << value[1] << ',' << value[2];
        else if (value[0] != 0)
            text << ' ' << parameter.name << ' ' << value[0];
    }
    return text.str();
}

void check_name(const std::string& name)
{
    if (!plain_name(name)) refuse(name, "name", printable(name), "letters, digits and '_'");
}

void check(const std::string& light, const LightParameter& parameter, const Vec3d& value)
{
    for (int c = 0; c < 3; ++c) {
        if (value[c] >= parameter.least && value[c] <= parameter.most && std::isfinite(value[c])) continue;
        std::ostringstream expected;
        if (std::isfinite(parameter.most))
            expected << "a number in [" << parameter.least << ", " << parameter.most << "]";
        else if (parameter.type == LightValue::Direction)
            expected << "finite coordinates";
        else
            expected << "finite numbers, " << parameter.least << " or above";
        if (parameter.type != LightValue::Number) refuse(light, parameter.name, value, expected.str());
        refuse(light, parameter.name, value[0], expected.str());
    }
    if (parameter.type == LightValue::Direction && !(value.length() > 0))
        refuse(light, parameter.name, value, "a non-zero vector");
}

std::string kind_words()
{
    std::string words;
    for (const LightKind* kind : light_kinds()) words += (words.empty() ? "" : " or ") + std::string(kind->word);
    return words;
}

}  // namespace

Light::Light(const LightKind& kind, std::string named, const Vec3d& place, std::vector<Vec3d> parameters)
    : name(std::move(named)), kind_(&kind), place_(place), parameters_(std::move(parameters))
{
    check_name(name);
    if (!is_finite(place)) refuse(name, kind.place_name, place, "finite coordinates");
    if (kind.at_infinity) {
        const double length = place.length();
        if (!(std::isfinite(length) && length > 0)) refuse(name, kind.place_name, place, "a non-zero vector");
        place_ /= length;
    }
    for (size_t p = 0; p < kind.parameters.size(); ++p) {
        if (p == parameters_.size()) parameters_.push_back(kind.parameters[p].otherwise);
        check(name, kind.parameters[p], parameters_[p]);
        if (kind.parameters[p].type == LightValue::Direction) parameters_[p].normalize();
    }
    model_ = kind.model(place_, parameters_);
}

std::vector<std::shared_ptr<const LightModel>> Light::parts(int count) const
{
    auto parts = model_->parts(count);
    if (parts.empty()) parts.push_back(model_);
    return parts;
}

std::vector<Light> Light::points(int count) const
{
    const auto models = parts(count);
    std::vector<Light> points(models.size(), *this);
    for (size_t k = 0; k < models.size(); ++k) {
        points[k].model_ = models[k];
        points[k].parameters_[0] /= double(models.size());
    }
    return points;
}

std::vector<Light> points_of(const std::vector<Light>& lights, int count)
{
    std::vector<Light> all;
    for (const Light& light : lights)
        for (const Light& point : light.points(count)) all.push_back(point);
    return all;
}

bool same_place(const Light& a, const Light& b)
{
    constexpr double tolerance = 1e-9;
    if (&a.kind() != &b.kind()) return false;
    if (!((a.place() - b.place()).length() <= tolerance * a.place().length())) return false;
    for (size_t p = 1; p < a.parameters().size(); ++p)
        if (!((a.parameters()[p] - b.parameters()[p]).length() <= tolerance)) return false;
    return true;
}

bool same_light(const Light& a, const Light& b) { return same_place(a, b) && a.strength() == b.strength(); }

std::string lights_text(const std::vector<Light>& lights)
{
    std::vector<std::string> texts;
    for (const Light& light : lights)
        if (light.strength() != Vec3d(0.0)) texts.push_back(text_of(light));
    return sorted_list(std::move(texts));
}

std::optional<std::string> other_lights(const MetaMap& solution, const std::vector<Light>& lights)
{
    if (!has_meta(solution, schema::lit_by)) return std::nullopt;
    const std::string theirs = get_text(solution, schema::lit_by, "");
    // Names follow the order of options and have no meaning for the field: a light is what comes after its name.
    const auto without_names = [](const std::string& text) {
        std::vector<std::string> texts;
        for (size_t from = 0; from < text.size();) {
            const size_t end = std::min(text.find(between, from), text.size());
            texts.push_back(
                text.substr(std::min(text.find(' ', from), end), end - std::min(text.find(' ', from), end)));
            from = end + std::string(between).size();
        }
        return sorted_list(std::move(texts));
    };
    if (without_names(theirs) == without_names(lights_text(lights))) return std::nullopt;
    return theirs;
}

Vec3d brightest_sun(const std::vector<Light>& lights)
{
    Vec3d brightest(0.0);
    for (const Light& light : lights)
        if (light.kind().at_infinity)
            for (int c = 0; c < 3; ++c) brightest[c] = std::max(brightest[c], light.strength()[c]);
    return brightest;
}

std::string transmittance_name(const Light& light) { return schema::transmittance_prefix + light.name; }

void write_light(MetaMap& to, const Light& light)
{
    check_name(light.name);
    const LightKind& kind = light.kind();
    set_text(to, schema::light_kind, kind.word);
    set_vector(to, kind.place_key, light.place());
    for (size_t p = 0; p < kind.parameters.size(); ++p) {
        const LightParameter& parameter = kind.parameters[p];
        if (parameter.type != LightValue::Number)
            set_vector(to, parameter.key, light.parameters()[p]);
        else
            set_number(to, parameter.key, light.parameters()[p][0]);
    }
}

std::optional<Light> read_light(const MetaMap& from, const std::string& grid_name)
{
    const std::string prefix = schema::transmittance_prefix;
    if (grid_name.rfind(prefix, 0) != 0 || !has_meta(from, schema::light_kind)) return std::nullopt;

    const std::string name = grid_name.substr(prefix.size()), word = get_text(from, schema::light_kind, "");
    for (const LightKind* kind : light_kinds()) {
        if (word != kind->word) continue;
        if (!has_meta(from, kind->place_key)) refuse(name, kind->place_key, "is missing", "it beside the light's kind");
        std::vector<Vec3d> values;
        for (const LightParameter& parameter : kind->parameters)
            values.push_back(parameter.type == LightValue::Number
                                 ? Vec3d(get_number(from, parameter.key, parameter.otherwise[0]))
                                 : get_vector(from, parameter.key, parameter.otherwise));
        return Light(*kind, name, get_vector(from, kind->place_key, Vec3d(0.0)), std::move(values));
    }
    refuse(name, "kind", "'" + printable(word) + "'", kind_words());
}

std::vector<Light> lights_of(const GridFile& file)
{
    std::vector<Light> lights;
    for (const auto& grid : file.grids)
        if (const auto light = read_light(*grid, grid->getName())) lights.push_back(*light);
    std::sort(lights.begin(), lights.end(), [](const Light& a, const Light& b) { return a.name < b.name; });
    return lights;
}

GridBasePtr grid_of_light(const GridFile& file, const Light& light)
{
    const std::string own_name = transmittance_name(light);
    const GridBasePtr named = find_grid(file, own_name);
    GridBasePtr best = named;
    int most = 0;  // the light itself counts 4, its place 2, its name 1
    for (const GridBasePtr& grid : file.grids) {
        const auto theirs = read_light(*grid, grid->getName());
        if (!theirs || !same_place(*theirs, light)) continue;
        const int likeness = (same_light(*theirs, light) ? 4 : 2) + (grid == named);
        if (likeness > most) best = grid;
        most = std::max(most, likeness);
    }
    return best;
}

}  // namespace vdbcloud
