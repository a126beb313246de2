#include "scene_file.h"

#include "nearest.h"
#include "options.h"
#include "toml_items.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <utility>

namespace vdbcloud::app {

namespace {

std::string joined(const std::vector<std::string>& words)
{
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
}

/// The end of a sentence about an unknown name.
std::string near(const std::string& name, const std::vector<std::string>& known)
{
    const std::string best = nearest(name, known);
    return best.empty() ? "; expected " + joined(known) : "; did you mean '" + best + "'?";
}

bool is_among(const std::string& name, const std::vector<std::string>& names)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::string unknown(const std::string& name) { return "unknown key '" + printable(name) + "'"; }

bool is_table(const toml::node& value) { return value.is_table() || value.is_array_of_tables(); }

const SceneKey* find(const App& app, const std::string& section, const std::string& name, const std::string& light)
{
    for (const SceneKey& key : app.scene_keys())
        if (key.section == section && key.key == name && key.light == light) return &key;
    return nullptr;
}

}  // namespace

/// The lines of one file: what the program takes of them, so far.
struct SceneReader::Lines {
    /// A light of the file: the key of its kind ("" for other sections), and how many of its kind are before it.
    struct Light {
        std::string kind;
        size_t number = 0;
    };

    const SceneReader& reader;
    SceneValues values;
    std::map<std::string, size_t> lights;  // how many of each kind

    template<typename Use>
    void for_each_key(const Use& use) const
    {
        for (const auto& program : reader.programs_)
            for (const SceneKey& key : program->scene_keys()) use(key);
        for (const SceneKey& key : reader.own_.scene_keys()) use(key);
    }

    std::vector<std::string> keys_of(const std::string& section, const std::string& light) const
    {
        std::vector<std::string> names;
        for_each_key([&](const SceneKey& key) {
            if (key.section == section && key.light == light && !is_among(key.key, names)) names.push_back(key.key);
        });
        return names;
    }

    [[noreturn]] void refuse_section(const TomlItem& item) const
    {
        std::vector<std::string> names;
        for (const SceneSection& section : scene_sections()) names.emplace_back(section.name);
        if (is_table(item.value()))
            refuse_line(item.line, "unknown section [" + printable(item.name) + "]" + near(item.name, names));
        refuse_line(item.line, "'" + printable(item.name) + "' is in no section" +
                                   elsewhere(item.name, "; expected a line [section] before it"));
    }

    /// Where a key belongs that is none of its section; else `otherwise`.
    std::string elsewhere(const std::string& name, const std::string& otherwise) const
    {
        std::string found;
        for_each_key([&](const SceneKey& key) {
            if (found.empty() && key.light.empty() && (key.key == name || key.option.name() == "--" + name))
                found = "; expected '" + key.key + "' in " + shown(*scene_section(key.section));
        });
        return found.empty() ? otherwise : found;
    }

    void read_section(const SceneSection& section, const TomlItem& item)
    {
        const toml::table* table = item.value().as_table();
        if (!table) refuse_line(item.line, "'" + item.name + "': expected one section " + shown(section));
        for (const TomlItem& line : items_of(*table)) take(section, line, {});
    }

    void read_lights(const SceneSection& section, const TomlItem& item)
    {
        const toml::array* all = item.value().as_array();
        if (!all || (!all->empty() && !item.value().is_array_of_tables()))
            refuse_line(item.line, "'" + item.name + "': expected a section " + shown(section) + " for each light");
        for (const toml::node& node : *all) {
            const std::vector<TomlItem> lines = items_of(*node.as_table());
            const std::string kind = kind_of(section, lines, node.source().begin.line);
            const Light light{kind, lights[kind]++};
            for (const TomlItem& line : lines) take(section, line, light);
        }
    }

    /// The key that says which kind of light this is.
    std::string kind_of(const SceneSection& section, const std::vector<TomlItem>& lines, size_t first_line) const
    {
        const std::vector<std::string> kinds = keys_of(section.name, "");
        std::string kind;
        for (const TomlItem& line : lines) {
            if (!is_among(line.name, kinds)) continue;
            if (!kind.empty())
                refuse_line(line.line, "'" + line.name + "': this light is a " + kind +
                                           " already: expected a section " + shown(section) + " for each light");
            kind = line.name;
        }
        if (!kind.empty()) return kind;
        for (const TomlItem& line : lines) {
            bool known = false;
            for_each_key([&](const SceneKey& key) { known = known || (!key.light.empty() && key.key == line.name); });
            if (!known) refuse_line(line.line, unknown(line.name) + " in " + shown(section) + near(line.name, kinds));
        }
        refuse_line(first_line, shown(section) + ": expected one of the keys " + joined(kinds));
    }

    void take(const SceneSection& section, const TomlItem& item, const Light& light)
    {
        if (is_table(item.value()))
            refuse_line(item.line, "'" + printable(item.name) + "' is a table within " + shown(section) +
                                       ": expected lines key = value");
        const std::string of = item.name == light.kind ? "" : light.kind;
        const SceneKey* own = find(reader.own_, section.name, item.name, of);
        std::vector<std::string> words;
        if (own) words = words_of(*own, section, item);
        bool known = own;
        for (const auto& program : reader.programs_)
            if (const SceneKey* key = find(*program, section.name, item.name, of)) {
                known = true;
                const std::vector<std::string> read = as_read(*program, *key, section, item);
                if (own) words = read;
            }
        if (!known && !of.empty())
            refuse_line(item.line, unknown(item.name) + " of a " + of + near(item.name, keys_of(section.name, of)));
        if (!known)
            refuse_line(item.line, unknown(item.name) + " in " + shown(section) +
                                       elsewhere(item.name, near(item.name, keys_of(section.name, ""))));
        if (!own) return;
        SceneValue& value = values.emplace(own, SceneValue{{}, item.line}).first->second;
        if (section.repeated) {
            value.words.resize(std::max(value.words.size(), light.number), own->otherwise);
            value.words.push_back(words.front());
        } else {
            value.words = words;
        }
    }

    static std::vector<std::string> words_of(const SceneKey& key, const SceneSection& section, const TomlItem& item)
    {
        std::vector<std::string> words = item.words(*key.option.cli());
        if (section.repeated && words.size() != 1) refuse_line(item.line, "'" + item.name + "': expected one value");
        return words;
    }

    /// The value as `program` reads it. Throws UsageError if the program does not take it.
    static std::vector<std::string> as_read(const App& program, const SceneKey& key, const SceneSection& section,
                                            const TomlItem& item)
    {
        CLI::Option& option = *key.option.cli();
        const std::vector<std::string> words = words_of(key, section, item);
        option.clear();
        try {
            program.give(option, words);
        } catch (const CLI::ParseError& error) {
            std::string why = program.reworded(error);
            const std::string name = key.option.name();
            if (why.rfind(name, 0) == 0) why.erase(0, name.size());
            refuse_line(item.line, shown(key) + why);
        }
        return option.reduced_results();
    }
};

SceneReader::SceneReader(const App& program) : own_(program), programs_(scene_programs()) {}

SceneValues SceneReader::read(const std::string& text) const
{
    const toml::table table = parse_toml(text);
    Lines lines{*this, {}, {}};
    for (const TomlItem& item : items_of(table)) {
        const SceneSection* section = scene_section(item.name);
        if (!section) lines.refuse_section(item);
        if (section->repeated)
            lines.read_lights(*section, item);
        else
            lines.read_section(*section, item);
    }
    for (auto& [key, value] : lines.values)
        if (const auto of = lines.lights.find(key->light); of != lines.lights.end())
            value.words.resize(of->second, key->otherwise);
    return std::move(lines.values);
}

}  // namespace vdbcloud::app
