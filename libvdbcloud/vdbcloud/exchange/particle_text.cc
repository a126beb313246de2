// Particles in tables of text with a line of names.
#include "vdbcloud/core/error.h"
#include "vdbcloud/exchange/particles.h"
#include "vdbcloud/file/text.h"

#include <charconv>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr uint64_t most_bytes = uint64_t(4) << 30;

/// The lines of a text, without the ends of lines.
class Lines {
public:
    explicit Lines(const std::string& text) : text_(text) {}

    /// The next line that is neither empty nor a comment.
    bool next(std::string_view& line)
    {
        while (at_ < text_.size()) {
            size_t end = text_.find('\n', at_);
            if (end == std::string::npos) end = text_.size();
            line = std::string_view(text_).substr(at_, end - at_);
            at_ = end + 1;
            ++number_;
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            const size_t first = line.find_first_not_of(" \t");
            if (first != std::string_view::npos && line[first] != '#') return true;
        }
        return false;
    }
    size_t number() const { return number_; }

private:
    const std::string& text_;
    size_t at_ = 0, number_ = 0;
};

/// Splits a line at `mark`, or at blanks if `mark` is one.
void split(std::string_view line, char mark, std::vector<std::string_view>& words)
{
    words.clear();
    for (size_t at = 0; at <= line.size();) {
        if (mark == ' ') at = std::min(line.find_first_not_of(" \t", at), line.size());
        if (mark == ' ' && at == line.size()) return;
        size_t end = mark == ' ' ? line.find_first_of(" \t", at) : line.find(mark, at);
        if (end == std::string_view::npos) end = line.size();
        std::string_view word = line.substr(at, end - at);
        while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
        while (!word.empty() && (word.back() == ' ' || word.back() == '\t')) word.remove_suffix(1);
        words.push_back(word);
        at = end + 1;
    }
}

char mark_of(std::string_view line)
{
    for (const char mark : {',', ';', '\t'})
        if (line.find(mark) != std::string_view::npos) return mark;
    return ' ';
}

}  // namespace

Particles read_csv(const std::string& path, const ParticleNames& chosen)
{
    const std::string text = read_text(path, most_bytes, "table of particles"), file = printable(path, 4096) + ": ";
    Lines lines(text);
    std::string_view line;
    if (!lines.next(line)) throw InputError(file + "empty: expected a line of names, then a particle a line");
    const char mark = mark_of(line);
    std::vector<std::string_view> words;
    split(line, mark, words);
    const std::vector<std::string> names(words.begin(), words.end());
    std::array<int, 10> columns{};
    try {
        columns = particle_columns(names, chosen);
    } catch (const InputError& e) {
        throw InputError(file + e.what());
    }
    Particles particles;
    std::array<double, 10> values{};
    while (lines.next(line)) {
        split(line, mark, words);
        const auto where = [&] { return file + "line " + std::to_string(lines.number()) + ": "; };
        if (words.size() != names.size())
            throw InputError(where() + std::to_string(words.size()) + " columns: expected " +
                             std::to_string(names.size()) + ", as the first line names");
        for (size_t k = 0; k < columns.size(); ++k) {
            if (columns[k] < 0) continue;
            std::string_view word = words[size_t(columns[k])];
            if (!word.empty() && word.front() == '+') word.remove_prefix(1);
            const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), values[k]);
            if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(values[k]))
                throw InputError(where() + "'" + printable(word, 40) + "' in column '" +
                                 printable(names[size_t(columns[k])], 40) + "': expected a finite number");
        }
        add_particle(particles, columns, values, where);
    }
    return particles;
}

}  // namespace vdbcloud
