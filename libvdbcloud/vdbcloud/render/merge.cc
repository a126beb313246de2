#include "vdbcloud/render/merge.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/exr_file.h"
#include "vdbcloud/render/film.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

/// A whole number at `from`, which moves behind it; false if there is none.
bool read_index(const char*& from, const char* end, uint64_t& value)
{
    const auto [rest, error] = std::from_chars(from, end, value);
    from = rest;
    return error == std::errc();
}

/// One picture as its file holds it.
struct Part {
    Imf::Header header;
    std::vector<float> pixels;
    std::vector<SampleRange> ranges;
    uint64_t samples = 0;
};

Part read_part(const std::string& path)
{
    ExrPicture picture = read_exr(path);
    Part part{picture.header, std::move(picture.values), {}, 0};
    const std::string ranges = text_attribute(part.header, picture::sample_ranges);
    if (ranges.empty())
        throw InputError(printable(path) +
                         ": says nothing of its samples: expected an .exr of render --integrator path");
    try {
        part.ranges = joined(read_ranges(ranges));
    } catch (const InputError& e) {
        throw InputError(printable(path) + ": " + e.what());
    }
    for (const SampleRange& range : part.ranges) part.samples += range.end - range.first;
    return part;
}

std::vector<std::string> channel_names(const Imf::Header& header)
{
    std::vector<std::string> names;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) names.push_back(c.name());
    return names;
}

/// How a channel's values of several parts become one.
struct ChannelRule {
    enum Kind { Mean, Least, Sum, Error, Variance } kind = Mean;
    std::array<int, 3> of{-1, -1, -1};  // Error: the channel whose error this is; Variance: r, g, b
};

std::vector<ChannelRule> rules_of(const std::vector<std::string>& names)
{
    const auto find = [&](const std::string& name) {
        const auto at = std::find(names.begin(), names.end(), name);
        return at == names.end() ? -1 : int(at - names.begin());
    };
    const std::string error = "standard_error.";
    std::vector<ChannelRule> rules(names.size());
    for (size_t c = 0; c < names.size(); ++c) {
        ChannelRule& rule = rules[c];
        if (names[c] == "Z") rule.kind = ChannelRule::Least;
        if (names[c] == "seconds.Y") rule.kind = ChannelRule::Sum;
        if (names[c].rfind(error, 0) == 0) rule = {ChannelRule::Error, {find(names[c].substr(error.size())), -1, -1}};
        if (names[c] == "variance.Y") rule = {ChannelRule::Variance, {find("R"), find("G"), find("B")}};
    }
    return rules;
}

void require_same(const std::string& path, const Imf::Header& a, const Imf::Header& b)
{
    const auto refuse = [&](const std::string& what) {
        throw InputError(printable(path) + ": " + what + ": expected a part of the same run as the first picture");
    };
    if (a.displayWindow() != b.displayWindow()) refuse("has another size");
    if (a.dataWindow() != b.dataWindow()) refuse("has another window (--crop)");
    if (channel_names(a) != channel_names(b)) refuse("has other layers (--aov)");
    for (const auto& [key, what] :
         {std::pair{picture::scene, "shows another scene, view or background"}, {picture::seed, "has another --seed"}})
        if (text_attribute(a, key) != text_attribute(b, key)) refuse(what);
}

}  // namespace

std::string range_text(const SampleRange& range)
{
    return std::to_string(range.first) + "-" + std::to_string(range.end - 1);
}

std::vector<SampleRange> read_ranges(const std::string& text)
{
    std::vector<SampleRange> ranges;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const char *at = word.data(), *end = at + word.size();
        SampleRange range{0, 0};
        uint64_t last = 0;
        const bool read = read_index(at, end, range.first) && at < end && *at++ == '-' && read_index(at, end, last) &&
                          at == end && last >= range.first && last + 1 > last;
        if (!read) throw InputError("sample range '" + printable(word) + "': expected FIRST-LAST");
        range.end = last + 1;
        ranges.push_back(range);
    }
    return ranges;
}

std::vector<SampleRange> joined(std::vector<SampleRange> ranges)
{
    std::sort(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<SampleRange> out;
    for (const SampleRange& range : ranges) {
        if (!out.empty() && range.first < out.back().end)
            throw InputError("sample " + std::to_string(range.first) +
                             " is there twice: expected other indices in each part (--spp-offset)");
        if (!out.empty() && range.first == out.back().end)
            out.back().end = range.end;
        else
            out.push_back(range);
    }
    return out;
}

struct PictureMerge::State {
    Imf::Header header;
    std::vector<ChannelRule> rules;
    std::vector<SampleRange> ranges;
    uint64_t samples = 0;
    std::vector<double> values;  // means; for errors and variances sums of squared deviations
};

PictureMerge::PictureMerge() : state_(std::make_unique<State>()) {}
PictureMerge::~PictureMerge() = default;

void PictureMerge::add(const std::string& path)
{
    const Part part = read_part(path);
    if (!text_attribute(part.header, picture::certificate).empty())
        throw InputError(printable(path) +
                         ": has a certificate, of its own samples alone: expected parts made without --certify");
    State& s = *state_;
    if (s.samples == 0) {
        s.header = part.header;
        s.rules = rules_of(channel_names(part.header));
    } else {
        require_same(path, s.header, part.header);
    }
    const size_t channels = s.rules.size();
    if (s.samples == 0) {
        s.values.assign(part.pixels.size(), 0.0);
        for (size_t c = 0; c < channels; ++c)
            if (s.rules[c].kind == ChannelRule::Least)
                for (size_t p = c; p < s.values.size(); p += channels) s.values[p] = part.pixels[p];
    }
    std::vector<SampleRange> all = s.ranges;
    all.insert(all.end(), part.ranges.begin(), part.ranges.end());
    try {
        s.ranges = joined(all);
    } catch (const InputError& e) {
        throw InputError(printable(path) + ": " + e.what());
    }
    const double before = double(s.samples), n = double(part.samples), after = before + n;
    for (size_t p = 0; p < s.values.size(); p += channels) {
        double* sum = &s.values[p];
        const float* value = &part.pixels[p];
        // Squares first: they need the means of what was there before (Chan, Golub & LeVeque 1979).
        const auto apart = [&](int c) { return c < 0 ? 0 : value[c] - sum[c]; };
        for (size_t c = 0; c < channels; ++c) {
            const auto& of = s.rules[c].of;
            if (s.rules[c].kind == ChannelRule::Error)
                sum[c] += double(value[c]) * value[c] * n * (n - 1) + apart(of[0]) * apart(of[0]) * before * n / after;
            if (s.rules[c].kind == ChannelRule::Variance) {
                const double d = luminance(apart(of[0]), apart(of[1]), apart(of[2]));
                sum[c] += value[c] * n * (n - 1) + d * d * before * n / after;
            }
        }
        for (size_t c = 0; c < channels; ++c) {
            if (s.rules[c].kind == ChannelRule::Mean) sum[c] += (value[c] - sum[c]) * (n / after);
            if (s.rules[c].kind == ChannelRule::Least) sum[c] = std::min(sum[c], double(value[c]));
            if (s.rules[c].kind == ChannelRule::Sum) sum[c] += value[c];
        }
    }
    s.samples += part.samples;
}

uint64_t PictureMerge::samples() const { return state_->samples; }

std::string PictureMerge::ranges() const
{
    std::string text;
    for (const SampleRange& range : state_->ranges) text += (text.empty() ? "" : " ") + range_text(range);
    return text;
}

uint64_t PictureMerge::values() const { return state_->values.size(); }

std::string PictureMerge::history() const { return text_attribute(state_->header, "history"); }

void PictureMerge::write(const std::string& path, const std::string& history, bool no_clobber) const
{
    const State& s = *state_;
    Imf::Header header = s.header;
    set_text_attribute(header, "history", history);
    set_text_attribute(header, picture::sample_ranges, ranges());
    set_number_attribute(header, picture::samples, double(s.samples));
    const size_t count = s.rules.size();
    const double n = double(s.samples), squares = n > 1 ? 1 / (n * (n - 1)) : 0;
    std::vector<float> pixels(s.values.size());
    for (size_t k = 0; k < pixels.size(); ++k) {
        const auto kind = s.rules[k % count].kind;
        const double value = s.values[k];
        pixels[k] = float(kind == ChannelRule::Error      ? std::sqrt(value * squares)
                          : kind == ChannelRule::Variance ? value * squares
                                                          : value);
    }
    std::vector<ExrChannel> channels;
    const auto& stored = s.header.channels();
    for (auto c = stored.begin(); c != stored.end(); ++c)
        channels.push_back({c.name(), c.channel().type == Imf::HALF, pixels.data() + channels.size(), count});
    write_picture_file(path, no_clobber, [&] { return encoded_exr(path, header, channels); });
}

}  // namespace vdbcloud
