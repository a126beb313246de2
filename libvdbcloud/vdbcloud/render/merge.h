#pragma once
// Merges pictures of light paths: parts of one run, made by different jobs.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud {

/// Attributes of pictures that say which samples they hold.
namespace picture {
inline constexpr const char* samples = "vdbcloud:samples";              ///< number: samples of each pixel
inline constexpr const char* sample_ranges = "vdbcloud:sample_ranges";  ///< text: "0-63 128-191", first and last
inline constexpr const char* seed = "vdbcloud:seed";                    ///< text: whole number
inline constexpr const char* scene = "vdbcloud:scene";                  ///< text: scene_digest()
inline constexpr const char* certificate = "vdbcloud:certificate";      ///< text: the errors of this picture alone
}  // namespace picture

/// Indices of samples, first <= k < end.
struct SampleRange {
    uint64_t first, end;
    bool operator==(const SampleRange& o) const { return first == o.first && end == o.end; }
};

std::string range_text(const SampleRange&);  ///< "0-63"; first and last
/// Reads "0-63 128-191". Throws InputError.
std::vector<SampleRange> read_ranges(const std::string& text);
/// The union in rising order, neighbours joined. Throws InputError naming the first index that two ranges share.
std::vector<SampleRange> joined(std::vector<SampleRange>);

/// Merges pictures (.exr) that Integrator::Path made with different sample indices:
///
///     layers           mean, weighted by the number of samples
///     Z                the smallest
///     standard_error   from the sums of squares of the parts and the spread of their means; variance likewise
///     seconds          sum
///
/// Equal to the picture of one run with all samples, to the rounding of floats.
class PictureMerge {
public:
    PictureMerge();
    ~PictureMerge();

    /// Adds the samples of one picture. Throws IoError for a file that cannot be read; InputError, path first, for one
    /// that says nothing of its samples or has a certificate, or whose scene, seed, size, window or channels are not
    /// the first's, or that has a sample which an earlier one has.
    void add(const std::string& path);

    uint64_t samples() const;     ///< of each pixel, in all pictures together
    std::string ranges() const;   ///< "0-63 128-191"
    std::string history() const;  ///< of the first picture
    uint64_t values() const;      ///< pixels times channels

    /// Writes the picture of all samples, with the attributes of the first, whole or not at all; `path` is an .exr or
    /// "-". Throws IoError, path first.
    void write(const std::string& path, const std::string& history, bool no_clobber) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace vdbcloud
