#include "named_files.h"

#include "shared.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace vdbcloud::app {

namespace {

namespace fs = std::filesystem;

/// The names that a kind of file may have.
struct Names {
    FileKind kind;
    std::vector<std::string> extensions;
    bool any_other;  ///< also names without one of the extensions of this table
};
const std::vector<Names>& table()
{
    static const std::vector<Names> all = {
        {FileKind::Grids, {".vdb"}, false},  {FileKind::Picture, {".exr", ".png"}, false},
        {FileKind::Png, {".png"}, false},    {FileKind::Map, {".exr"}, false},
        {FileKind::Report, {".json"}, true}, {FileKind::Other, {".json"}, true}};
    return all;
}
/// Extensions of files that no program here writes.
const std::vector<std::string> foreign = {".nvdb", ".toml"};

std::string extension_of(const std::string& path)
{
    std::string extension = fs::path(path).extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return extension;
}

bool among(const std::string& word, const std::vector<std::string>& words)
{
    return std::find(words.begin(), words.end(), word) != words.end();
}

bool belongs_elsewhere(const std::string& extension)
{
    return among(extension, foreign) || std::any_of(table().begin(), table().end(), [&](const Names& names) {
               return among(extension, names.extensions);
           });
}

/// A command that makes the file that the name asks for; empty if there is none.
std::string way_out(FileKind kind, const std::string& path)
{
    const std::string stem = fs::path(path).stem().string(), named = printable(path);
    if (kind == FileKind::Grids && extension_of(path) == ".nvdb")
        return "; for NanoVDB write " + printable(stem) + ".vdb, then nanovdb_convert " + printable(stem) + ".vdb " +
               named;
    if (kind == FileKind::Picture && !belongs_elsewhere(extension_of(path)) && !extension_of(path).empty())
        return "; for other formats write " + printable(stem) + ".exr, then oiiotool " + printable(stem) + ".exr -o " +
               named;
    return {};
}

bool is_no_plain_file(const std::string& path)
{
    struct stat status = {};
    if (path == "-" || path.rfind("/dev/", 0) == 0 || path.rfind("/proc/", 0) == 0) return true;
    return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

std::string option_and(const std::string& option, const std::string& path) { return option + " " + printable(path); }

struct NamedPath {
    const NamedFile* file;
    std::string path;
};

/// The paths that were given for inputs, or with `written` those for outputs.
std::vector<NamedPath> paths_of(const std::vector<NamedFile>& files, bool written)
{
    std::vector<NamedPath> paths;
    for (const NamedFile& file : files)
        if (file.kind.has_value() == written)
            for (const std::string& word : file.option.cli()->results())
                if (!word.empty()) paths.push_back({&file, word});
    return paths;
}

}  // namespace

void require_name(const std::string& option, const std::string& path, FileKind kind)
{
    if (kind == FileKind::Any || path.empty() || is_no_plain_file(path)) return;
    const std::string extension = extension_of(path);
    const auto names = std::find_if(table().begin(), table().end(), [&](const Names& n) { return n.kind == kind; });
    if (among(extension, names->extensions)) return;
    if (names->any_other) {
        if (belongs_elsewhere(extension))
            throw UsageError(option_and(option, path) + ": this is text, expected a name that does not end in " +
                             extension);
        return;
    }
    std::string expected;
    for (const std::string& own : names->extensions) expected += (expected.empty() ? "" : " or ") + own;
    throw UsageError(option_and(option, path) + ": expected a name that ends in " + expected + way_out(kind, path));
}

FileIdentity identify(const std::string& path, int standard_stream)
{
    struct stat status = {};
    const bool standard = path == "-";
    const bool exists = (standard ? ::fstat(standard_stream, &status) : ::stat(path.c_str(), &status)) == 0;
    if (exists && (S_ISREG(status.st_mode) || S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode)))
        return {std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino), bool(S_ISREG(status.st_mode))};
    if (standard) return {"standard stream " + std::to_string(standard_stream), false};
    if (exists && !S_ISDIR(status.st_mode)) return {};
    std::error_code none;
    const fs::path target = link_target(path);
    const fs::path folder = fs::canonical(target.has_parent_path() ? target.parent_path() : ".", none);
    return {((none ? target.parent_path() : folder) / target.filename()).string(), true};
}

void App::check_files()
{
    Shared& s = *shared_;
    std::map<std::string, std::string> read, written;  // by identity, the option and its file
    std::string piped;
    for (NamedPath input : paths_of(s.files, false)) {
        input.path = at_frame(input.path);
        const std::string name = input.file->option.name();
        if (input.path == "-" && !piped.empty())
            throw UsageError((piped == name ? "standard input is named twice"
                                            : piped + " and " + name + " are both standard input") +
                             ": name one of them as a file");
        if (input.path == "-") piped = name;
        if (const FileIdentity id = identify(input.path, STDIN_FILENO); !id.key.empty() && id.regular)
            read.emplace(id.key, option_and(name, input.path));
    }
    for (NamedPath output : paths_of(s.files, true)) {
        output.path = at_frame(output.path);
        const std::string name = output.file->option.name(), named = option_and(name, output.path);
        const auto refuse = [&](const std::string& why) {
            if (why.find("--json") != std::string::npos || name == "--json") s.json.clear();
            throw UsageError(why);
        };
        try {
            require_name(name, output.path, *output.file->kind);
        } catch (const UsageError& error) {
            refuse(error.what());
        }
        const FileIdentity id = identify(output.path, STDOUT_FILENO);
        if (id.key.empty()) continue;
        if (const auto [other, fresh] = written.emplace(id.key, named); !fresh)
            refuse(other->second + " and " + named + " are the same file: expected a file for each");
        if (const auto source = read.find(id.key); source != read.end() && !output.file->may_replace_input)
            refuse(named + " is the same file as " + source->second + ", which is read: expected another file");
    }
}

void App::forget_unsafe_report(int argc, char** argv)
{
    std::string& json = shared_->json;
    try {
        require_name("--json", json, FileKind::Report);
    } catch (const UsageError&) {
        json.clear();
    }
    const std::string own = json.empty() ? "" : identify(json, STDOUT_FILENO).key;
    int seen = 0;
    for (int k = 1; k < argc && !own.empty(); ++k) {
        const std::string word = argv[k];
        const size_t equals = word.rfind("--", 0) == 0 ? word.find('=') : std::string::npos;
        const std::string path = equals == std::string::npos ? word : word.substr(equals + 1);
        seen += path != "-" && !path.empty() && identify(path, STDOUT_FILENO).key == own;
    }
    if (seen > 1) json.clear();
}

}  // namespace vdbcloud::app
