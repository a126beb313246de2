#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

namespace vdbcloud {

namespace {

/// The value if the metadata is of type T, else null.
template<typename T>
const T* value(const openvdb::Metadata& meta)
{
    const auto* typed = dynamic_cast<const openvdb::TypedMetadata<T>*>(&meta);
    return typed ? &typed->value() : nullptr;
}

/// True for a key whose misfit is an error: all but those of the table that other programs write too.
bool is_strict(const std::string& key)
{
    const schema::MetaKey* known = schema::meta_key(key);
    return !known || known->ours();
}

schema::Range range_of(const std::string& key)
{
    const schema::MetaKey* known = schema::meta_key(key);
    return known ? known->range : schema::finite;
}

/// The value as a T by `convert`, which returns nothing for what does not fit; `otherwise` if absent or passed over.
template<typename T, typename Convert>
T get(const MetaMap& map, const std::string& key, const T& otherwise, const std::string& expected,
      const Convert& convert)
{
    const auto meta = map[key];
    if (!meta) return otherwise;
    if (const std::optional<T> found = convert(*meta)) return *found;
    if (is_strict(key)) refuse(meta_name(map, key), meta->str(), expected);
    return otherwise;
}

std::optional<double> number_of(const openvdb::Metadata& meta, const schema::Range& range)
{
    double x = NAN;
    if (const auto* d = value<double>(meta))
        x = *d;
    else if (const auto* f = value<float>(meta))
        x = double(*f);
    else if (const auto* i = value<int32_t>(meta))
        x = *i;
    else if (const auto* l = value<int64_t>(meta))
        x = double(*l);
    return range.holds(x) ? std::optional<double>(x) : std::nullopt;
}

std::optional<Vec3d> vector_of(const openvdb::Metadata& meta, const schema::Range& range)
{
    Vec3d x(NAN);
    if (const auto* d = value<Vec3d>(meta))
        x = *d;
    else if (const auto* f = value<Vec3f>(meta))
        x = Vec3d(*f);
    else if (const auto* i = value<Vec3i>(meta))
        x = Vec3d(*i);
    return range.holds(x[0]) && range.holds(x[1]) && range.holds(x[2]) ? std::optional<Vec3d>(x) : std::nullopt;
}

std::optional<std::string> text_of(const openvdb::Metadata& meta)
{
    const auto* text = value<std::string>(meta);
    return text ? std::optional<std::string>(*text) : std::nullopt;
}

/// What is expected of the value of a key that other programs write too; empty if it is that.
std::string expected_instead(const schema::MetaKey& key, const MetaMap& map)
{
    const openvdb::Metadata& meta = *map[key.key];
    if (std::string(key.type) == "string") {
        if (!text_of(meta)) return "text";
        return key.key != std::string(schema::up_axis) || read_up_axis(map) ? "" : "Y or Z";
    }
    return number_of(meta, key.range) ? "" : key.range.text(1);
}

template<typename T>
void set(MetaMap& map, const std::string& key, const T& x)
{
    map.removeMeta(key);  // insertMeta() throws if the key has another type
    map.insertMeta(key, openvdb::TypedMetadata<T>(x));
}

}  // namespace

std::string meta_name(const MetaMap& map, const std::string& key)
{
    const auto* grid = dynamic_cast<const GridBase*>(&map);
    return (grid ? "grid '" + printable(grid->getName()) + "': " : "") + "metadata '" + printable(key) + "'";
}

bool has_meta(const MetaMap& map, const std::string& key) { return bool(map[key]); }

double get_number(const MetaMap& map, const std::string& key, double otherwise)
{
    const schema::Range range = range_of(key);
    return get(map, key, otherwise, range.text(1),
               [&](const openvdb::Metadata& meta) { return number_of(meta, range); });
}

Vec3d get_vector(const MetaMap& map, const std::string& key, const Vec3d& otherwise)
{
    const schema::Range range = range_of(key);
    return get(map, key, otherwise, range.text(3),
               [&](const openvdb::Metadata& meta) { return vector_of(meta, range); });
}

std::string get_text(const MetaMap& map, const std::string& key, const std::string& otherwise)
{
    return get(map, key, otherwise, "text", text_of);
}

std::vector<double> get_numbers(const MetaMap& map, const std::string& key)
{
    std::istringstream in(get_text(map, key, ""));
    std::vector<double> numbers;
    for (std::string word; in >> word;) {
        double x = NAN;
        const char* const end = word.data() + word.size();
        const auto [rest, error] = std::from_chars(word.data(), end, x);
        if (error != std::errc() || rest != end || !std::isfinite(x))
            refuse(meta_name(map, key), word, "finite numbers");
        numbers.push_back(x);
    }
    return numbers;
}

void set_number(MetaMap& map, const std::string& key, double x) { set(map, key, x); }
void set_vector(MetaMap& map, const std::string& key, const Vec3d& x) { set(map, key, x); }
void set_text(MetaMap& map, const std::string& key, const std::string& x) { set(map, key, x); }

void set_numbers(MetaMap& map, const std::string& key, const std::vector<double>& numbers)
{
    std::ostringstream text;
    text.precision(17);
    for (size_t k = 0; k < numbers.size(); ++k) text << (k ? " " : "") << numbers[k];
    set_text(map, key, text.str());
}

std::vector<std::string> passed_over(const MetaMap& file_metadata)
{
    std::vector<std::string> sentences;
    for (const schema::MetaKey& key : schema::meta_keys()) {
        if (key.ours() || !has_meta(file_metadata, key.key)) continue;
        const std::string expected = expected_instead(key, file_metadata);
        if (!expected.empty())
            sentences.push_back(meta_name(file_metadata, key.key) + " = " + printable(file_metadata[key.key]->str()) +
                                " is passed over: expected " + expected);
    }
    std::sort(sentences.begin(), sentences.end());
    return sentences;
}

}  // namespace vdbcloud
