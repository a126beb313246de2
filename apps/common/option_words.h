#pragma once
// Options of several words with semicolons between them: "sphere; at=0,1,0; radius=2".
#include "options.h"

#include "vdbcloud/core/fwd.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// One such option, word by word. Each word has to be asked for once, else it has no effect and is refused. All throw
/// UsageError that begins with the option and its text.
class OptionWords {
public:
    OptionWords(const std::string& option, const std::string& text);
    std::string shape;  ///< the first word

    const std::string& option() const { return option_; }
    bool has(const std::string& word);
    /// The text behind KEY=; empty if the key is not there.
    std::string value(const std::string& key);
    /// The same, without asking for it.
    std::string peek(const std::string& key) const;
    Vec3d place(const std::string& key, const std::optional<Vec3d>& otherwise);
    double size(const std::string& key, const std::optional<double>& otherwise);
    /// Seconds of "10s", "2min", "1h", "never" or a number; 0 or above.
    double time(const std::string& key, const std::optional<double>& otherwise);
    /// A reflectance.
    Vec3d colour(const std::string& key, const Vec3d& otherwise);
    /// Throws for words that nothing has asked for. `known`: all that there are, for this shape.
    void finish(const std::vector<std::string>& known) const;
    [[noreturn]] void refuse(const std::string& why) const;

private:
    std::string context() const;

    std::string option_, text_;
    std::vector<std::string> left_;
};

}  // namespace vdbcloud::app
