// vdbcloud PROGRAM ...: starts a program of the toolkit. The programs' names are short (render), so an installation
// keeps them out of the path, in libexec/vdbcloud.
#include "completion.h"

#include "common/nearest.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace vdbcloud::command {
namespace {

constexpr int usage_error = 2;

std::vector<std::string> program_names()
{
    std::istringstream words(VDBCLOUD_PROGRAM_NAMES);
    std::vector<std::string> names;
    for (std::string name; words >> name;) names.push_back(name);
    return names;
}

/// Found from this program's own file, through symbolic links: an installation may be moved. In a build folder the
/// programs lie beside this one.
std::filesystem::path programs_folder()
{
    const auto here = std::filesystem::canonical("/proc/self/exe").parent_path();
    const auto installed = (here / VDBCLOUD_PROGRAMS_FOLDER).lexically_normal();
    return std::filesystem::is_directory(installed) ? installed : here;
}

/// Replaces this process by the program. Returns only if that fails, with the exit status.
int start(const std::string& name, std::vector<std::string> arguments)
{
    const std::string path = (programs_folder() / name).string();
    std::vector<char*> argv;
    arguments.insert(arguments.begin(), name);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    execv(path.c_str(), argv.data());
    std::cerr << "vdbcloud: cannot start " << path << ": " << std::strerror(errno) << "\n";
    return 1;
}

/// What `name arguments` writes to standard output.
std::string output_of(const std::string& name, const std::vector<std::string>& arguments)
{
    int ends[2];
    if (pipe(ends) != 0) return {};
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        close(ends[1]);
        _exit(start(name, arguments));
    }
    close(ends[1]);
    std::string text;
    char part[4096];
    for (ssize_t n; (n = read(ends[0], part, sizeof part)) > 0 || (n < 0 && errno == EINTR);)
        if (n > 0) text.append(part, size_t(n));
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return text;
}

/// The first paragraph of a program's help is "NAME: summary".
std::string summary_of(const std::string& name)
{
    const std::string help = output_of(name, {"--help"});
    std::string text = help.substr(0, help.find("\n\n"));
    if (text.rfind(name + ": ", 0) == 0) text.erase(0, name.size() + 2);
    std::istringstream words(text);
    std::string summary;
    for (std::string word; words >> word;) summary += (summary.empty() ? "" : " ") + word;
    return summary;
}

void print_help(std::ostream& out)
{
    out << "vdbcloud: clouds, fog, smoke and fire on OpenVDB grids.\n\n"
           "Usage: vdbcloud PROGRAM [OPTIONS] ...\n\nPrograms:\n";
    for (const std::string& name : program_names())
        out << "  " << name << std::string(name.size() < 12 ? 12 - name.size() : 1, ' ') << summary_of(name) << "\n";
    out << "\nOptions:\n"
           "  --help                  print this and exit\n"
           "  --version               print the version and exit\n"
           "  --completion SHELL      print the completion script for bash, zsh or fish, and exit\n"
           "\n`vdbcloud PROGRAM --help` explains one program.\n";
}

int print_completion(const std::string& shell)
{
    if (shell != "bash" && shell != "zsh" && shell != "fish") {
        std::cerr << "vdbcloud: --completion: '" << shell << "': expected bash, zsh or fish\n";
        return usage_error;
    }
    std::vector<Program> programs;
    for (const std::string& name : program_names())
        programs.push_back({name, summary_of(name), output_of(name, {"--completion", shell})});
    std::cout << completion(shell, programs);
    return 0;
}

int run(const std::vector<std::string>& words)
{
    if (words.empty()) {
        std::cerr << "vdbcloud: expected the name of a program; vdbcloud --help lists them\n";
        return usage_error;
    }
    const std::string& first = words[0];
    if (first == "--help" || first == "-h" || first == "--help-all") return print_help(std::cout), 0;
    if (first == "--version") return std::cout << "vdbcloud " VDBCLOUD_VERSION "\n", 0;
    if (first == "--completion" && words.size() == 2) return print_completion(words[1]);

    const auto names = program_names();
    for (const std::string& name : names)
        if (name == first) return start(name, {words.begin() + 1, words.end()});

    const std::string best = app::nearest(first, names);
    std::cerr << "vdbcloud: unknown program '" << first << "'"
              << (best.empty() ? "; vdbcloud --help lists the programs" : "; did you mean '" + best + "'?") << "\n";
    return usage_error;
}

}  // namespace
}  // namespace vdbcloud::command

int main(int argc, char** argv)
{
    try {
        return vdbcloud::command::run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        std::cerr << "vdbcloud: " << error.what() << "\n";
        return 1;
    }
}
