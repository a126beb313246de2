#include "signals.h"

#include "scarcity.h"

#include "vdbcloud/core/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

namespace vdbcloud::app {

namespace {

struct Ending {
    int signal;
    const char* name;
};
constexpr Ending endings[] = {
    {SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}, {SIGPIPE, "SIGPIPE"}, {SIGXCPU, "SIGXCPU"}};

/// The status of a run that a signal ends. Limits of the system end it as its other failures do.
int status_of(int signal) { return signal == SIGXCPU ? 1 : 128 + signal; }

/// What a handler needs must be there before, as memory that no longer changes.
struct LastWords {
    std::string path, temporary, before, between, after;
};
std::atomic<const LastWords*> last_words{nullptr};
std::string tool_name;

void put(int file, const char* text, size_t size)
{
    while (size > 0) {
        const ssize_t n = ::write(file, text, size);
        if (n <= 0) return;
        text += n;
        size -= size_t(n);
    }
}
void put(int file, const std::string& text) { put(file, text.data(), text.size()); }

/// A sentence on standard error. Takes no memory: there may be none, and an exception in a terminate handler aborts.
void complain(const char* tool, const char* sentence)
{
    for (const char* part : {tool, ": ", sentence, "\n"}) put(STDERR_FILENO, part, std::strlen(part));
}

/// Only calls that are safe in a handler.
void leave_report(const LastWords& words, int signal)
{
    const int file = ::open(words.temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0) return;
    put(file, words.before);
    for (const Ending& ending : endings)
        if (ending.signal == signal) put(file, ending.name, std::strlen(ending.name));
    put(file, words.between);
    const int status = status_of(signal);
    const char digits[] = {char('0' + status / 100), char('0' + status / 10 % 10), char('0' + status % 10)};
    const size_t zeros = status < 10 ? 2 : status < 100 ? 1 : 0;
    put(file, digits + zeros, 3 - zeros);
    put(file, words.after);
    ::close(file);
    if (::rename(words.temporary.c_str(), words.path.c_str()) != 0) ::unlink(words.temporary.c_str());
}

void handle(int signal)
{
    // The first of several wins; the others wait in their threads for the end.
    static std::atomic_flag ending = ATOMIC_FLAG_INIT;
    if (ending.test_and_set())
        for (;;) ::pause();
    remove_temporaries();
    if (const LastWords* words = last_words.load()) leave_report(*words, signal);
    if (signal == SIGXCPU) {
        complain(tool_name.c_str(),
                 "the limit of processor time (ulimit -t) ended the run: expected a higher limit, or less "
                 "work, which --dry-run estimates");
        ::_exit(status_of(signal));
    }

    struct sigaction action = {};
    action.sa_handler = SIG_DFL;
    ::sigaction(signal, &action, nullptr);
    sigset_t these;
    sigemptyset(&these);
    sigaddset(&these, signal);
    ::pthread_sigmask(SIG_UNBLOCK, &these, nullptr);
    ::kill(::getpid(), signal);
    for (;;) ::pause();
}

[[noreturn]] void terminated()
{
    remove_temporaries();
    const char* const scarce = scarcity();
    complain(tool_name.c_str(), scarce ? scarce : "internal error: an exception left its thread; please report it");
    std::_Exit(1);
}

/// Ends a program whose libraries cannot start: log4cplus, which OpenVDB brings, starts threads before main().
[[noreturn]] void not_started()
{
    const bool other = !scarcity() && std::current_exception();
    complain(program_invocation_short_name, other ? "internal error: an exception before the start; please report it"
                                                  : "not enough memory to start; a higher limit would do");
    std::_Exit(1);
}

void before_libraries(int /*argc*/, char** /*argv*/, char** /*environment*/) { std::set_terminate(not_started); }

// The system calls these functions before the constructors of shared libraries.
using Early = void (*)(int, char**, char**);
[[gnu::section(".preinit_array"), gnu::used]] const Early early = before_libraries;

/// The system kills at the hard limit of processor time, so the lower limit, which sends SIGXCPU, must be below it.
void leave_time_to_end()
{
    rlimit time = {};
    if (::getrlimit(RLIMIT_CPU, &time) != 0 || time.rlim_max == RLIM_INFINITY || time.rlim_max < 2) return;
    time.rlim_cur = std::min(time.rlim_cur, time.rlim_max - 1);
    ::setrlimit(RLIMIT_CPU, &time);
}

}  // namespace

void install_signals(const std::string& tool)
{
    tool_name = tool;
    std::set_terminate(terminated);
    ::signal(SIGXFSZ, SIG_IGN);
    leave_time_to_end();
    struct sigaction action = {}, before = {};
    action.sa_handler = handle;
    sigfillset(&action.sa_mask);
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    ::pthread_sigmask(SIG_UNBLOCK, &pipe, nullptr);
    for (const Ending& ending : endings) {
        ::sigaction(ending.signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN && ending.signal != SIGPIPE) continue;
        ::sigaction(ending.signal, &action, nullptr);
    }
}

void report_if_ended(const std::string& path, const std::string& text)
{
    static LastWords words;
    last_words = nullptr;
    const size_t name = text.find("SIGNAL"), status = text.find("\"STATUS\"");
    if (path.empty() || name == std::string::npos || status == std::string::npos || status < name) return;
    struct stat target = {};
    words.path = link_target(path);
    if (::lstat(words.path.c_str(), &target) == 0 && !S_ISREG(target.st_mode))
        return;                                    // never renamed over a device or a link
    words.temporary = temporary_name(words.path);  // now, because a handler cannot draw random numbers
    words.before = text.substr(0, name);
    words.between = text.substr(name + 6, status - name - 6);
    words.after = text.substr(status + 8);
    last_words = &words;
}

void end_by(int signal)
{
    ::raise(signal);
    std::_Exit(128 + signal);
}

}  // namespace vdbcloud::app
