#pragma once
// Scene files, --scene: what a picture is made of beside its density. Private to apps/common/ and apps/scene/.
#include "app.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// A section of a scene file.
struct SceneSection {
    const char* name;
    const char* holds;
    bool repeated;  ///< [[name]], once for each light; else [name], once
};

/// All sections, in the order in which they are printed.
const std::vector<SceneSection>& scene_sections();

/// The section of that name, or null.
const SceneSection* scene_section(const std::string& name);

/// "[sky]" or "[[lights]]".
std::string shown(const SceneSection&);

/// An option that is a key of scene files: Option::scene() makes it one.
struct SceneKey {
    Option option;
    std::string section, key;
    std::string light;      ///< of a light's parameter: the key that makes a light of that kind
    std::string otherwise;  ///< of a light's parameter: its value where a light gives none
};

/// "[sky] zenith", as help and messages have it.
std::string shown(const SceneKey&);

/// The programs that have all keys of scene files among them, with their options declared. Any program refuses what is
/// no key of one of these.
std::vector<std::unique_ptr<App>> scene_programs();

/// The value of a key: the words of its option. Of a light's parameter one for each light of its kind.
struct SceneValue {
    std::vector<std::string> words;
    size_t line = 0;  ///< of the first
};
using SceneValues = std::map<const SceneKey*, SceneValue>;

/// Reads scene files for one program.
class SceneReader {
public:
    /// Keeps a reference to `program`, whose options are declared.
    explicit SceneReader(const App& program);

    /// What the program takes of a scene file with this text. Every key and every value is checked by all programs that
    /// have the key. Throws UsageError "line N: ...": for what is not TOML, for a section or a key that no program has,
    /// with the nearest known one, and for a value that a program does not take.
    SceneValues read(const std::string& text) const;

private:
    struct Lines;  // of one file

    const App& own_;
    std::vector<std::unique_ptr<App>> programs_;
};

/// Values as a scene file: one text for each meaning, whatever the order and form of the lines.
std::string scene_text(const App& program, const SceneValues&);

/// Every key of scene files as a table in Markdown for each section: key, option, value, programs. Of `programs` alone.
std::string scene_tables(const std::vector<std::unique_ptr<App>>& programs);

}  // namespace vdbcloud::app
