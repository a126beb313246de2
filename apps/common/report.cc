// The --json report, and the history line: what a run says about itself.
#include "shared.h"

#include "version.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <sstream>

namespace vdbcloud::app {

namespace {

double seconds_of(clockid_t clock)
{
    timespec now = {};
    ::clock_gettime(clock, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

nlohmann::json value_of(const std::string& word, bool numeric)
{
    if (!numeric) return word;
    if (word.find(',') != std::string::npos) return *numbers(word);
    int64_t whole = 0;
    const char* end = word.data() + word.size();
    if (const auto read = std::from_chars(word.data(), end, whole); read.ec == std::errc() && read.ptr == end)
        return whole;
    uint64_t large = 0;  // seeds use all 64 bits
    if (const auto read = std::from_chars(word.data(), end, large); read.ec == std::errc() && read.ptr == end)
        return large;
    return *number(word);
}

std::string last_part(const std::string& path)
{
    const size_t slash = path.find_last_of('/');
    return slash == std::string::npos || slash + 1 == path.size() ? path : path.substr(slash + 1);
}

}  // namespace

double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }
double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

App::Phase::Phase(App& app, const std::string& name)
    : app_(app), name_(name), wall_(wall_seconds()), cpu_(cpu_seconds())
{
}

void App::note(const std::string& phase, double wall, double cpu)
{
    report()["phases"].push_back({{"name", phase}, {"wall_seconds", wall}, {"cpu_seconds", cpu}});
    if (!verbose()) return;
    char text[120];
    std::snprintf(text, sizeof text, "%s: %.3f s, %.3f s of processor", phase.substr(0, 60).c_str(), wall, cpu);
    say(text);
}

App::Phase::~Phase()
{
    try {
        app_.note(name_, wall_seconds() - wall_, cpu_seconds() - cpu_);
    } catch (const std::exception&) {  // for want of memory: a time that is not told ends no run
        return;
    }
}

std::unique_ptr<App::Phase> App::phase(const std::string& name) { return std::make_unique<Phase>(*this, name); }

nlohmann::json parameters_of(const CLI::App& app)
{
    nlohmann::json all = nlohmann::json::object();
    for (const Setting& setting : settings(app)) {
        nlohmann::json& value = all[setting.name];
        if (setting.kind == Setting::Flag) {
            value = setting.words.front() == "true";
        } else if (setting.kind == Setting::One) {
            if (!setting.words.empty()) value = value_of(setting.words.front(), setting.numeric);
        } else {
            value = nlohmann::json::array();
            for (const std::string& word : setting.words) value.push_back(value_of(word, setting.numeric));
        }
    }
    return all;
}

nlohmann::json App::finished_report(const nlohmann::json& status, const std::string& error) const
{
    Shared& s = *shared_;
    nlohmann::json out = s.report.is_object() ? s.report : nlohmann::json::object();
    out["schema"] = 1;
    out["tool"] = get_name();
    out["version"] = project_version();
    for (const char* list : {"inputs", "outputs", "phases"})
        if (!out.contains(list)) out[list] = nlohmann::json::array();
    out["parameters"] = s.parameters.is_null() ? nlohmann::json::object() : s.parameters;
    out["threads"] = threads();
    rusage usage = {};
    ::getrusage(RUSAGE_SELF, &usage);
    out["peak_memory_bytes"] = int64_t(usage.ru_maxrss) * 1024;
    out["wall_seconds"] = wall_seconds() - s.wall_start;
    out["cpu_seconds"] = cpu_seconds();
    out["dry_run"] = s.dry_run;
    if (!s.work.events().empty()) out["events"] = s.work.events();
    {
        const std::lock_guard<std::mutex> lock(s.mutex);
        out["warnings"] = s.warnings;
    }
    out["exit_status"] = status;
    if (!error.empty()) out["error"] = one_line(error);
    return out;
}

void write_report(const std::string& path, const nlohmann::json& report)
{
    const std::string text = report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    std::unique_ptr<AtomicFile> file;
    if (path != "-") file = std::make_unique<AtomicFile>(path);
    const int descriptor = file ? file->descriptor() : STDOUT_FILENO;
    for (size_t done = 0; done < text.size();) {
        const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) throw IoError(system_message(file ? path : "standard output", "cannot write the report", errno));
        done += size_t(n);
    }
    if (file) file->commit();
}

std::string App::history(const std::string& inherited) const
{
    std::string all;
    std::istringstream lines(inherited);
    for (std::string line; std::getline(lines, line);)
        if (!line.empty()) all += one_line(line) + "\n";

    std::string own = get_name() + " " + project_version();
    for (Setting setting : settings(*this)) {
        if (setting.name == "output") continue;
        const bool names_file = std::any_of(shared_->files.begin(), shared_->files.end(),
                                            [&](const NamedFile& file) { return file.option.cli() == setting.option; });
        std::vector<std::string> words;
        for (const std::string& word : setting.words) {
            const std::string path = names_file ? at_frame(word) : word;
            if (!shared_->traced_inputs.count(path)) words.push_back(setting.numeric ? word : last_part(path));
        }
        if (words.empty()) continue;
        setting.words = words;
        own += " " + setting.name + "=" + toml(setting);
    }
    return all + own;
}

}  // namespace vdbcloud::app
