#include "scene_file.h"

#include "shared.h"
#include "standard_streams.h"
#include "toml_items.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <fstream>
#include <utility>

namespace vdbcloud::app {

const std::vector<SceneSection>& scene_sections()
{
    static const std::vector<SceneSection> all = {
        {"medium", "what the cloud is made of, which way is up, along which axes the cloud repeats", false},
        {"lights", "a sun, a lamp or a spot", true},
        {"sky", "the sky, which lights the medium and is drawn behind it", false},
        {"solids", "the ground and other solids", false},
        {"camera", "where the camera stands, and how it looks", false},
        {"picture", "size, layers and tones of the picture", false},
        {"accuracy", "methods, samples and tolerances", false},
    };
    return all;
}

const SceneSection* scene_section(const std::string& name)
{
    for (const SceneSection& section : scene_sections())
        if (name == section.name) return &section;
    return nullptr;
}

std::string shown(const SceneSection& section)
{
    const std::string name = section.name;
    return section.repeated ? "[[" + name + "]]" : "[" + name + "]";
}

std::string shown(const SceneKey& key) { return shown(*scene_section(key.section)) + " " + key.key; }

std::string scene_text(const App& program, const SceneValues& values)
{
    const auto line = [](const SceneKey& key, const std::vector<std::string>& words) {
        Setting setting = setting_of(key.option.cli(), words);
        if (scene_section(key.section)->repeated) setting.kind = Setting::One;  // one light's
        return key.key + " = " + toml(setting) + "\n";
    };
    const auto parameters = [&](const SceneKey& place, size_t n) {
        std::string lines;
        for (const auto& [key, value] : values)
            if (key->light == place.key) lines += line(*key, {value.words[n]});
        return lines;
    };
    std::string out;
    for (const SceneSection& section : scene_sections()) {
        std::string lines;
        for (const SceneKey& key : program.scene_keys()) {
            const auto found = values.find(&key);
            if (key.section != section.name || !key.light.empty() || found == values.end()) continue;
            const std::vector<std::string>& words = found->second.words;
            if (!section.repeated) lines += line(key, words);
            for (size_t n = 0; section.repeated && n < words.size(); ++n)
                lines += shown(section) + "\n" + line(key, {words[n]}) + parameters(key, n);
        }
        if (!lines.empty() && !section.repeated) out += shown(section) + "\n";
        out += lines;
    }
    return out;
}

bool App::read_scene()
{
    Shared& s = *shared_;
    if (s.scene.empty() && s.print_scene)
        throw UsageError("--print-scene has no effect without --scene: add --scene, or leave out --print-scene");
    if (s.scene.empty()) return true;
    const std::string path = printable(s.scene, 4096);
    std::ifstream file(s.scene, std::ios::binary);
    if (!file) throw IoError(path + ": cannot read this scene file");
    const std::string text = read_text(file, path);
    SceneValues values;
    try {
        values = SceneReader(*this).read(text);
    } catch (const UsageError& error) {
        throw UsageError(path + ": " + error.what());
    }
    // What the user gives by an option wins; a light's place with all parameters of the lights of its kind.
    std::vector<const SceneKey*> beaten;
    for (const auto& [key, value] : values) {
        const CLI::Option* place = key->light.empty() ? nullptr : get_option_no_throw("--" + key->light);
        if (!key->option.cli()->empty() || (place && !place->empty())) beaten.push_back(key);
    }
    for (const SceneKey* key : beaten) values.erase(key);
    for (const auto& [key, value] : values) {
        CLI::Option* option = key->option.cli();
        s.scene_places[option] = path + ": line " + std::to_string(value.line) + ": ";
        give(*option, value.words);
    }
    if (s.print_scene) to_standard_output(scene_text(*this, values));
    return !s.print_scene;
}

void App::give(CLI::Option& option, const std::vector<std::string>& words)
{
    if (option.get_items_expected_max() == 0)
        option.add_result(option.get_flag_value(option.get_single_name(), words.front()));
    else
        option.add_result(words);
    option.run_callback();
}

bool App::of_scene(const CLI::Option* option) const
{
    return option->count() > 0 && shared_->scene_places.count(option) > 0;
}

void App::leave_out_idle_scene()
{
    Shared& s = *shared_;
    const auto idle = [&](const Rule& rule) { return of_scene(rule.option) && !rule.holds(); };
    // Each that is left out may leave another without effect.
    for (auto rule = s.rules.begin(); (rule = std::find_if(s.rules.begin(), s.rules.end(), idle)) != s.rules.end();) {
        rule->option->clear();
        const bool flag = rule->option->get_items_expected_max() == 0;
        const std::string otherwise = rule->option->get_default_str();
        if (flag || !otherwise.empty())
            rule->option->run_callback_for_default()->default_val(flag && otherwise.empty() ? "false" : otherwise);
    }
}

const std::vector<SceneKey>& App::scene_keys() const { return shared_->scene_keys; }

std::string scene_tables(const std::vector<std::unique_ptr<App>>& programs)
{
    std::string out;
    for (const SceneSection& section : scene_sections()) {
        std::vector<std::pair<std::string, std::string>> rows;  // without the programs, and those
        for (const auto& program : programs)
            for (const SceneKey& key : program->scene_keys()) {
                if (key.section != section.name) continue;
                std::string value = key.option.cli()->get_type_name();
                while (!value.empty() && value.back() == ':') value.pop_back();
                for (const std::string mark : {":", "|"})  // a | would end a column
                    for (size_t at; (at = value.find(mark)) != std::string::npos;)
                        value.replace(at, 1, mark == ":" ? " " : " or ");
                const std::string row =
                    "| `" + key.key + "` | `" + key.option.name() + "` | `" + (value.empty() ? "true, false" : value);
                const auto same = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.first == row; });
                if (same == rows.end())
                    rows.emplace_back(row, program->get_name());
                else
                    same->second += ", " + program->get_name();
            }
        if (rows.empty()) continue;
        out += "### " + shown(section) + "\n\n" + section.holds +
               "\n\n| key | option | value | programs |\n|---|---|---|---|\n";
        for (const auto& [row, names] : rows) out += row + "` | " + names + " |\n";
        out += "\n";
    }
    return out;
}

}  // namespace vdbcloud::app
