#include "hard/programs.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <sstream>
#include <stdexcept>

namespace vdbcloud::test {

/// A program that waits for requests.
struct Programs::Started {
    pid_t process = -1;
    int requests = -1, answers = -1;

    explicit Started(const std::string& path)
    {
        int in[2], out[2];
        if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
        process = ::fork();
        if (process == 0) {
            ::dup2(in[0], 0);
            ::dup2(out[1], 1);
            // The loader splits LD_PRELOAD at spaces, which a folder may hold; it splits the folders at colons alone.
            const std::filesystem::path library = VDBCLOUD_START_ONCE;
            const char* others = ::getenv("LD_LIBRARY_PATH");
            const std::string folders = library.parent_path().string() + (others ? std::string(":") + others : "");
            ::setenv("LD_LIBRARY_PATH", folders.c_str(), 1);
            ::setenv("LD_PRELOAD", library.filename().c_str(), 1);
            ::setenv("LD_BIND_NOW", "1", 1);  // else each run looks up the same symbols
            ::execl(path.c_str(), path.c_str(), nullptr);
            ::_exit(127);
        }
        ::close(in[0]);
        ::close(out[1]);
        requests = in[1];
        answers = out[0];
    }
    ~Started()
    {
        ::close(requests);
        ::close(answers);
        ::kill(process, SIGKILL);  // at its end it would wait for threads of libraries
        ::waitpid(process, nullptr, 0);
    }
    Started(const Started&) = delete;
    Started& operator=(const Started&) = delete;
};

Words split(const std::string& text)
{
    std::istringstream in(text);
    Words words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

Programs::Programs(const Limits& limits) : limits_(limits) { ::signal(SIGPIPE, SIG_IGN); }
Programs::~Programs() = default;

namespace {

/// A run from the start, without limits of memory and without its processor time.
Answer run_anew(const std::string& name, const Words& arguments, const std::string& folder, const std::string& input,
                double seconds)
{
    RunOptions options;
    options.seconds = 10 * seconds;
    Words command{
        "bash",       "-c",   "cd \"$1\" && shift && exec < \"$1\" && shift && exec \"$@\" > stdout 2> stderr",
        "run",        folder, input,
        program(name)};
    command.insert(command.end(), arguments.begin(), arguments.end());
    Answer answer;
    answer.status = test::run(command, options).status;
    return answer;
}

}  // namespace

bool Programs::start_once() { return !sanitized; }  // a sanitizer must be the first library

Answer Programs::run(const std::string& name, const Words& arguments, const std::string& folder,
                     const std::string& input)
{
    if (!start_once()) {
        ++runs_;
        return run_anew(name, arguments, folder, input, limits_.seconds);
    }
    std::unique_ptr<Started>& server = started_[name];
    if (!server) server = std::make_unique<Started>(program(name));
    std::string text;
    for (const std::string& word :
         {folder, std::to_string(long(limits_.seconds)), std::to_string(long(limits_.bytes)), input, name})
        text.append(word.c_str(), word.size() + 1);
    for (const std::string& word : arguments) text.append(word.c_str(), word.size() + 1);
    const uint32_t size = uint32_t(text.size());
    Answer answer;
    if (::write(server->requests, &size, sizeof size) != sizeof size ||
        ::write(server->requests, text.data(), size) != ssize_t(size) ||
        ::read(server->answers, &answer, sizeof answer) != sizeof answer)
        throw std::runtime_error(name + ": cannot be started with start_once preloaded");
    seconds_ += answer.seconds;
    ++runs_;
    return answer;
}

}  // namespace vdbcloud::test
