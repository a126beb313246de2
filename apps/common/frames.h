#pragma once
// Numbered frames: names with a place for a number, and which numbers.
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// A file name with one place for the number of a frame.
///
/// The place is %d, %4d or %04d as of printf; two or more #, or one # between dots, each # a digit; or $F4, as other
/// programs of this trade write it. Numbers with more digits than the place take what they need.
class FramePattern {
public:
    /// Nothing if `path` has no such place. Throws UsageError, beginning with `option`, for two places and for another
    /// conversion of printf (%f).
    static std::optional<FramePattern> in(const std::string& option, const std::string& path);

    std::string path(int number) const;
    /// The numbers of the files that exist, rising.
    std::vector<int> existing() const;

private:
    std::string before_, after_;
    size_t digits_ = 0;  // at least this many
    char fill_ = '0';
};

/// The numbers of "7", "1-24", "1-24x2" (each second) and lists of those between commas, in that order. Throws
/// UsageError for other text, for a number that comes twice, and for more than a million.
std::vector<int> frame_numbers(const std::string& text);

/// "1-24x2", or "1-3, 7" for numbers with gaps; cut after a few.
std::string range_text(const std::vector<int>& numbers);

/// The pattern of names that differ in a number alone, which stands between dots, underscores or hyphens:
/// "cloud.%04d.vdb"; empty for other names and for a single one.
std::string common_pattern(const std::vector<std::string>& paths);

/// For programs that place the numbers themselves (Option::writes_frames). Throws UsageError if `output` is `before`,
/// the output of the frame before, which it would replace. Then `before` is `output`.
void require_numbered(const std::string& output, std::string& before);

/// Throws UsageError if `output` still has a place for a number, which no --frames filled.
void require_placed(const std::string& output);

}  // namespace vdbcloud::app
