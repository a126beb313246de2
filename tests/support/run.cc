#include "support/run.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

struct Pipe {
    int ends[2] = {-1, -1};
    Pipe()
    {
        if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    }
    ~Pipe()
    {
        close(0);
        close(1);
    }
    void close(int k)
    {
        if (ends[k] >= 0) ::close(ends[k]);
        ends[k] = -1;
    }
};

[[noreturn]] void become(const std::vector<std::string>& command, const RunOptions& options)
{
    for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(signal, SIG_DFL);
    if (options.ignore_sigpipe) ::signal(SIGPIPE, SIG_IGN);
#if !defined(__SANITIZE_ADDRESS__)  // AddressSanitizer reserves terabytes of address space
    if (options.memory) {
        const rlimit limit = {options.memory, options.memory};
        ::setrlimit(RLIMIT_AS, &limit);
    }
#endif
    for (const std::string& entry : options.environment) {
        const size_t equals = entry.find('=');
        if (equals == std::string::npos)
            ::unsetenv(entry.c_str());
        else
            ::setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
    }
    if (!options.folder.empty() && ::chdir(options.folder.c_str()) != 0) ::_exit(126);
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    ::execvp(words[0], words.data());
    ::_exit(127);
}

/// Appends the bytes available from `file` to `text`; false at the end of the stream.
bool take(int file, std::string& text)
{
    char buffer[65536];
    const ssize_t n = ::read(file, buffer, sizeof buffer);
    if (n > 0) text.append(buffer, size_t(n));
    return n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN));  // EIO: end of a terminal's output
}

/// The parent's side of the pipes, while the child process runs.
class Watch {
public:
    Watch(pid_t child, const RunOptions& options) : child_(child), options_(options) {}

    RunResult follow(int in, int out, int err)
    {
        size_t sent = 0;
        if (in >= 0) ::fcntl(in, F_SETFL, O_NONBLOCK);
        while (out >= 0 || err >= 0) {
            if (in >= 0 && sent == options_.input.size()) in = (::close(in), -1);
            pollfd files[3] = {{out, POLLIN, 0}, {err, POLLIN, 0}, {in, POLLOUT, 0}};
            ::poll(files, 3, 50);
            if (files[0].revents && !take(out, result_.out)) out = -1;
            if (files[1].revents && !take(err, result_.err)) err = -1;
            if (files[2].revents) {
                const ssize_t n = ::write(in, options_.input.data() + sent, options_.input.size() - sent);
                if (n > 0)
                    sent += size_t(n);
                else if (errno != EAGAIN && errno != EINTR)
                    sent = options_.input.size();
            }
            tend();
        }
        if (in >= 0) ::close(in);
        int status = 0;
        while (::waitpid(child_, &status, WNOHANG) == 0) {
            tend();
            ::usleep(2000);
        }
        result_.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
        return result_;
    }

private:
    void tend()
    {
        const std::string& said = options_.terminal ? result_.out : result_.err;
        if (!signalled_ && options_.signal && said.find(options_.until) != std::string::npos) {
            ::kill(child_, options_.signal);
            signalled_ = true;
        }
        const std::chrono::duration<double> past = std::chrono::steady_clock::now() - start_;
        if (past.count() < options_.seconds || result_.timed_out) return;
        result_.timed_out = true;
        ::kill(child_, SIGKILL);
    }

    pid_t child_;
    const RunOptions& options_;
    RunResult result_;
    bool signalled_ = false;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

RunResult run_on_terminal(const std::vector<std::string>& command, const RunOptions& options)
{
    int master = -1;
    const pid_t child = ::forkpty(&master, nullptr, nullptr, nullptr);
    if (child < 0) throw std::runtime_error("forkpty");
    if (child == 0) become(command, options);
    const RunResult result = Watch(child, options).follow(-1, master, -1);
    ::close(master);
    return result;
}

}  // namespace

RunResult run(const std::vector<std::string>& command, const RunOptions& options)
{
    if (options.terminal) return run_on_terminal(command, options);
    ::signal(SIGPIPE, SIG_IGN);  // a child may exit without reading all input
    Pipe in, out, err;
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("fork");
    if (child == 0) {
        int standard_out = out.ends[1];
        if (!options.stdout_to.empty()) standard_out = ::open(options.stdout_to.c_str(), O_WRONLY | O_CREAT, 0666);
        ::dup2(in.ends[0], 0);
        ::dup2(standard_out, 1);
        ::dup2(err.ends[1], 2);
        if (options.close_stdout) out.close(0);
        become(command, options);
    }
    in.close(0);
    out.close(1);
    err.close(1);
    if (options.close_stdout) out.close(0);
    const int input = in.ends[1];
    in.ends[1] = -1;  // closed after all input is sent
    return Watch(child, options).follow(input, out.ends[0], err.ends[0]);
}

RunResult shell(const std::string& line, const RunOptions& options)
{
    for (size_t at = line.find(VDBCLOUD_PROGRAMS); at != std::string::npos; at = line.find(VDBCLOUD_PROGRAMS, at + 1))
        if (at == 0 || line[at - 1] != '\'') throw std::logic_error("a path without quotes in: " + line);
    RunOptions in_path = options;
    const char* old = ::getenv("PATH");
    in_path.environment.push_back("PATH=" VDBCLOUD_PROGRAMS ":" + std::string(old ? old : "/usr/bin:/bin"));
    return run({"bash", "-o", "pipefail", "-c", line}, in_path);
}

std::string program(const std::string& name) { return std::string(VDBCLOUD_PROGRAMS) + "/" + name; }

Scratch::Scratch()
{
    std::string pattern = (std::filesystem::temp_directory_path() / "vdbcloud test-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("mkdtemp");
    path_ = pattern;
}

Scratch::~Scratch()
{
    std::error_code none;
    std::filesystem::remove_all(path_, none);
}

std::vector<std::string> Scratch::list() const
{
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
}

std::string read_text(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

}  // namespace vdbcloud::test
