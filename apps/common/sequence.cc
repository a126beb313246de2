// Numbered frames through a program: --frames, and the files of each frame.
#include "frames.h"
#include "shared.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace vdbcloud::app {

namespace {

/// The pattern of a path that an option gave. A file that exists under the very name is no pattern.
std::optional<FramePattern> pattern_of(const NamedFile& file, const std::string& path)
{
    std::error_code none;
    if (!file.kind && std::filesystem::exists(path, none)) return std::nullopt;
    return FramePattern::in(file.option.name(), path);
}

std::string numbered(const NamedFile& file, const std::string& path)
{
    return file.option.name() + " " + printable(path) + " has a place for the number of a frame: ";
}

/// "cloud.%04d.vdb" for "cloud.vdb".
std::string numbered_name(const std::string& path)
{
    const std::filesystem::path whole = path;
    return printable(whole.stem().string()) + ".%04d" + printable(whole.extension().string());
}

bool is_picture_or_grids(const NamedFile& file)
{
    return file.kind && *file.kind != FileKind::Report && *file.kind != FileKind::Other && *file.kind != FileKind::Any;
}

}  // namespace

void App::takes_frames(bool several_inputs)
{
    shared_->sequences = true;
    shared_->several_inputs = several_inputs;
}

void App::declare_frames()
{
    Shared& s = *shared_;
    if (!s.sequences) return;
    add_option("--frames", s.frames,
               "work on numbered files, one frame after the other: 1-24, 1-24x2 for each second, or 1,5,9. Names of "
               "input and output have a place for the number: cloud.%04d.vdb or cloud.####.vdb")
        .configurable(false)
        .group("Frames");
    if (!s.several_inputs) return;
    add_flag("--one-medium", s.one_medium,
             "take inputs whose names differ in a number alone as parts of one medium; without it they are refused, "
             "because they look like frames")
        .configurable(false)
        .group("Frames");
}

/// Says how to work on frames where names are those of frames and --frames is missing.
void App::refuse_unasked_frames() const
{
    const Shared& s = *shared_;
    for (const NamedFile& file : s.files)
        for (const std::string& path : file.option.cli()->results()) {
            if (file.own_number || file.kind == FileKind::Any || (!s.sequences && !file.kind)) continue;
            const auto pattern = pattern_of(file, path);
            if (!pattern) continue;
            if (!s.sequences || (file.kind && !is_picture_or_grids(file))) {
                if (file.kind == FileKind::Report) shared_->json.clear();
                throw UsageError(numbered(file, path) + "expected a name without it, because one file is written");
            }
            const bool input = std::any_of(s.files.begin(), s.files.end(), [&](const NamedFile& f) {
                const auto names = f.option.cli()->results();
                return !f.kind && std::any_of(names.begin(), names.end(),
                                              [&](const std::string& name) { return bool(pattern_of(f, name)); });
            });
            if (file.kind && !input)
                throw UsageError(numbered(file, path) + "expected a name without it, or numbered inputs, as "
                                                        "cloud.%04d.vdb, and --frames A-B");
            const std::vector<int> there = file.kind ? std::vector<int>() : pattern->existing();
            throw UsageError(numbered(file, path) + "add --frames " +
                             (there.empty() ? "A-B" : range_text(there) + ", the frames that are there"));
        }
    if (!s.several_inputs) return;
    const std::vector<std::string> inputs = get_option("input")->results();
    const std::string pattern = common_pattern(inputs);
    if (s.one_medium && pattern.empty())
        throw UsageError(
            "--one-medium has no effect without inputs whose names differ in a number alone: leave it out");
    if (!s.one_medium && !pattern.empty())
        throw UsageError("the inputs look like frames of a sequence, as " + printable(pattern) +
                         ": for a result each, '" + printable(pattern) +
                         "' --frames A-B and a numbered --output; for all of them as one medium, "
                         "add --one-medium");
}

void App::check_frames()
{
    Shared& s = *shared_;
    if (s.frames.empty()) return refuse_unasked_frames();
    s.numbers = frame_numbers(s.frames);
    if (s.one_medium) throw UsageError("--one-medium has no effect with --frames: leave out one of them");
    bool varies = false;
    for (const NamedFile& file : s.files)
        for (const std::string& path : file.own_number ? std::vector<std::string>() : file.option.cli()->results()) {
            const auto pattern = FramePattern::in(file.option.name(), path);
            if (!file.kind && path == "-" && s.numbers.size() > 1)
                throw UsageError("standard input has one frame, and --frames " + printable(s.frames) + " is given");
            varies = varies || (!file.kind && pattern);
            if (file.kind && !is_picture_or_grids(file) && pattern) {
                if (file.kind == FileKind::Report) s.json.clear();
                throw UsageError(numbered(file, path) + "expected one file for all frames");
            }
            if (is_picture_or_grids(file) && !pattern && s.numbers.size() > 1 && path.rfind("/dev/", 0) != 0)
                throw UsageError(file.option.name() + " " + printable(path) +
                                 ": expected a numbered name with --frames, as " + numbered_name(path));
        }
    if (!varies)
        throw UsageError(
            "--frames has no effect without a numbered input, as cloud.%04d.vdb: all frames would be equal");
}

std::string App::at_frame(const std::string& path) const
{
    if (!shared_->frame) return path;
    const auto pattern = FramePattern::in("", path);
    return pattern ? pattern->path(*shared_->frame) : path;
}

/// Adds the report of a frame to that of the run: lists at their ends, everything else under "frames".
void App::join_report(nlohmann::json& whole, int number) const
{
    nlohmann::json one = {{"number", number}};
    for (auto& [key, value] : shared_->report.items()) {
        if (key == "inputs" || key == "outputs" || key == "phases")
            for (auto& entry : value) whole[key].push_back(entry);
        else
            one[key] = value;
    }
    whole["frames"].push_back(one);
}

void App::each_frame(const std::function<void(const PlaceFrame&)>& work)
{
    Shared& s = *shared_;
    if (s.numbers.empty()) return work([](std::string&) {});
    nlohmann::json whole = nlohmann::json::object();
    for (const int number : s.numbers) {
        s.frame = number;
        s.used.clear();
        s.inherited_grids.clear();
        s.traced_inputs.clear();
        s.report = nlohmann::json();
        say("frame " + std::to_string(number));
        // Without --json nobody reads the reports, which would grow with the frames.
        const auto keep = [&] {
            if (!s.json.empty()) join_report(whole, number);
        };
        try {
            check_files();
            check_places();
            work([this](std::string& path) { path = at_frame(path); });
        } catch (...) {
            keep();
            s.report = std::move(whole);
            throw;
        }
        keep();
        for (auto& [option, need] : s.frame_needs)
            if (!need.remark.empty()) say(std::exchange(need.remark, ""));
    }
    s.report = std::move(whole);
    s.frame.reset();
    for (const auto& [option, need] : s.frame_needs)
        if (!need.met) throw UsageError(need.refusal + ": no frame has it");
}

}  // namespace vdbcloud::app
