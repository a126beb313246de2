#include "frames.h"

#include "named_files.h"
#include "shared.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

namespace vdbcloud::app {

namespace {

constexpr size_t most_frames = 1000000;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A place for a number within a text.
struct Place {
    size_t begin, end;
    std::string width;  // digits of %04d
};

size_t end_of_digits(const std::string& text, size_t from)
{
    while (from < text.size() && is_digit(text[from])) ++from;
    return from;
}

/// True for the # of "a.#.vdb", which in "tree #3.vdb" is text.
bool lone_mark(const std::string& path, size_t at)
{
    return at > 0 && at + 1 < path.size() && path[at - 1] == '.' && path[at + 1] == '.';
}

std::vector<Place> places_in(const std::string& option, const std::string& path)
{
    std::vector<Place> places;
    for (size_t at = 0; at < path.size(); ++at) {
        if (path[at] == '%') {
            const size_t end = end_of_digits(path, at + 1);
            const bool conversion =
                end < path.size() && std::string("diouxXeEfFgGaAsc").find(path[end]) != std::string::npos;
            if (!conversion) continue;
            const std::string width = path.substr(at + 1, end - at - 1);
            if (path[end] != 'd' || width.size() > 3)
                throw UsageError(option + " " + printable(path) + ": expected one number like %04d");
            places.push_back({at, end + 1, width});
            at = end;
        } else if (path[at] == '#') {
            const size_t end = std::min(path.find_first_not_of('#', at), path.size());
            if (end - at > 1 || lone_mark(path, at)) places.push_back({at, end, "0" + std::to_string(end - at)});
            at = end - 1;
        } else if (path.compare(at, 2, "$F") == 0) {
            const size_t end = end_of_digits(path, at + 2);
            if (end - at <= 4) places.push_back({at, end, end > at + 2 ? "0" + path.substr(at + 2, end - at - 2) : ""});
            at = end - 1;
        }
    }
    return places;
}

int whole_number(const std::string& text, const std::string& part)
{
    int number = -1;
    if (part.empty() || !is_digit(part[0]) || read_whole(part, number) != 0)
        throw UsageError("--frames " + printable(text) + ": expected numbers as 7, 1-24, or 1-24x2 for each second");
    return number;
}

}  // namespace

std::optional<FramePattern> FramePattern::in(const std::string& option, const std::string& path)
{
    const std::vector<Place> places = places_in(option, path);
    if (places.empty()) return std::nullopt;
    if (places.size() > 1) throw UsageError(option + " " + printable(path) + ": expected one number like %04d");
    const Place& place = places.front();
    FramePattern pattern;
    pattern.before_ = path.substr(0, place.begin);
    pattern.after_ = path.substr(place.end);
    pattern.digits_ = place.width.empty() ? 1 : std::stoul(place.width);
    pattern.fill_ = !place.width.empty() && place.width[0] == '0' ? '0' : ' ';
    return pattern;
}

std::string FramePattern::path(int number) const
{
    std::string digits = std::to_string(number);
    if (digits.size() < digits_) digits.insert(0, digits_ - digits.size(), fill_);
    return before_ + digits + after_;
}

std::vector<int> FramePattern::existing() const
{
    namespace fs = std::filesystem;
    std::error_code failed;
    std::vector<int> numbers;
    const size_t slash = before_.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : before_.substr(0, slash + 1);
    for (fs::directory_iterator entry(folder.empty() ? "." : folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        const std::string name = folder + entry->path().filename().string();
        int number = 0;
        if (name.size() <= before_.size() + after_.size() || name.compare(0, before_.size(), before_) != 0) continue;
        const std::string digits = name.substr(before_.size(), name.size() - before_.size() - after_.size());
        if (end_of_digits(digits, 0) == digits.size() && read_whole(digits, number) == 0 && path(number) == name)
            numbers.push_back(number);
    }
    std::sort(numbers.begin(), numbers.end());
    return numbers;
}

std::vector<int> frame_numbers(const std::string& text)
{
    std::vector<int> numbers;
    std::set<int> seen;
    for (size_t from = 0; from <= text.size();) {
        const size_t comma = std::min(text.find(',', from), text.size());
        const std::string part = text.substr(from, comma - from);
        from = comma + 1;
        const size_t hyphen = part.find('-'), times = part.find('x');
        const int first = whole_number(text, part.substr(0, std::min(hyphen, times)));
        if (hyphen == std::string::npos && times != std::string::npos) whole_number(text, "");
        const int last =
            hyphen == std::string::npos
                ? first
                : whole_number(text, part.substr(hyphen + 1, times == std::string::npos ? times : times - hyphen - 1));
        const int step = times == std::string::npos ? 1 : whole_number(text, part.substr(times + 1));
        if (last < first || step < 1)
            throw UsageError("--frames " + printable(text) + ": expected rising numbers and a step of 1 or more");
        for (int64_t n = first; n <= last; n += step) {
            if (!seen.insert(int(n)).second)
                throw UsageError("--frames " + printable(text) + ": frame " + std::to_string(n) + " comes twice");
            numbers.push_back(int(n));
            if (numbers.size() > most_frames)
                throw UsageError("--frames " + printable(text) + ": expected at most a million frames");
        }
    }
    return numbers;
}

std::string range_text(const std::vector<int>& numbers)
{
    std::string text;
    int ranges = 0;
    for (size_t from = 0; from < numbers.size();) {
        if (++ranges > 4) return text + ", ...";
        const int step = from + 1 < numbers.size() ? numbers[from + 1] - numbers[from] : 1;
        size_t to = from;
        while (to + 1 < numbers.size() && numbers[to + 1] - numbers[to] == step) ++to;
        if (step > 1 && to < from + 2) to = from;  // two numbers far apart are no range
        text += (text.empty() ? "" : ",") + std::to_string(numbers[from]);
        if (to > from) text += "-" + std::to_string(numbers[to]) + (step > 1 ? "x" + std::to_string(step) : "");
        from = to + 1;
    }
    return text;
}

std::string common_pattern(const std::vector<std::string>& paths)
{
    if (paths.size() < 2) return {};
    const auto is_border = [](char c) { return c == '.' || c == '_' || c == '-'; };
    const std::string& first = paths.front();
    // The last number that stands free, as in "shot2_cloud.0007.vdb".
    for (size_t end = first.size(); end > 0; --end) {
        if (!is_digit(first[end - 1]) || end == first.size() || !is_border(first[end])) continue;
        size_t begin = end;
        while (begin > 0 && is_digit(first[begin - 1])) --begin;
        if (begin == 0 || !is_border(first[begin - 1])) return {};
        const std::string before = first.substr(0, begin), after = first.substr(end);
        std::set<std::string> numbers;
        size_t least = first.size(), most = 0;
        for (const std::string& path : paths) {
            if (path.size() <= before.size() + after.size() || path.compare(0, before.size(), before) != 0 ||
                path.compare(path.size() - after.size(), after.size(), after) != 0)
                return {};
            const std::string digits = path.substr(before.size(), path.size() - before.size() - after.size());
            if (end_of_digits(digits, 0) != digits.size() || !numbers.insert(digits).second) return {};
            least = std::min(least, digits.size());
            most = std::max(most, digits.size());
        }
        return before + (least == most && least > 1 ? "%0" + std::to_string(least) + "d" : "%d") + after;
    }
    return {};
}

void require_numbered(const std::string& output, std::string& before)
{
    if (output == before && output != "-" && output.rfind("/dev/", 0) != 0)
        throw UsageError("--output " + printable(output) + ": expected a numbered name with --frames, as cloud.%04d" +
                         printable(std::filesystem::path(output).extension().string()));
    before = output;
}

void require_placed(const std::string& output)
{
    if (FramePattern::in("--output", output))
        throw UsageError("--output " + printable(output) +
                         " has a place for the number of a frame: expected a name without it, or numbered inputs, as "
                         "cloud.%04d.vdb, and --frames A-B");
}

}  // namespace vdbcloud::app
