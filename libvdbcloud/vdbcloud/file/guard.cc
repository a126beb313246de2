#include "vdbcloud/file/guard.h"

#include "vdbcloud/core/error.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>
#include <thread>

#if defined(__SANITIZE_ADDRESS__)
#include <chrono>
#include <filesystem>
#include <fstream>
#endif

namespace vdbcloud {

namespace {

enum Ending { Fine = 0, Threw = 10, OutOfMemory = 11, NoThread = 12 };

void limit(int resource, rlim_t most)
{
    rlimit now = {};
    ::getrlimit(__rlimit_resource(resource), &now);
    now.rlim_cur = std::min(most, now.rlim_max);
    if (resource == RLIMIT_CPU) now.rlim_max = std::min(most + 1, now.rlim_max);  // SIGKILL at the hard limit
    ::setrlimit(__rlimit_resource(resource), &now);
}

/// Bytes of address space that this process has mapped.
uint64_t mapped_bytes()
{
    unsigned long long pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
        if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
        std::fclose(file);
    }
    return uint64_t(pages) * uint64_t(::sysconf(_SC_PAGESIZE));
}

/// True if the user's own limit of address space (ulimit -v) is lower than `wanted`.
bool memory_is_limited(uint64_t wanted)
{
    rlimit now = {};
    return ::getrlimit(RLIMIT_AS, &now) == 0 && now.rlim_max != RLIM_INFINITY && now.rlim_max < wanted;
}

/// In builds with the address sanitizer waits until no other thread runs, a second at most. The sanitizer's runtime has
/// locks that a fork does not release. Threads that a library starts as it is loaded, such as the four of OpenVDB's
/// log4cplus, hold one for a moment: the forked process would then wait without an end.
void let_threads_start()
{
#if defined(__SANITIZE_ADDRESS__)
    const auto at_work = [] {
        for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
            if (task.path().filename() == std::to_string(::gettid())) continue;
            std::string stat;
            std::ifstream in(task.path() / "stat");
            std::getline(in, stat);
            const size_t name = stat.rfind(") ");
            if (name != std::string::npos && stat[name + 2] != 'S') return true;
        }
        return false;
    };
    for (int k = 0; k < 1000 && at_work(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
#endif
}

/// Confines the forked process: default signal handlers, no output, limits on memory and processor time.
void confine(const GuardLimits& limits, uint64_t mapped)
{
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    // The program's signal handlers would remove temporary files of the parent process.
    for (const int signal :
         {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGALRM, SIGXCPU, SIGABRT, SIGSEGV, SIGBUS, SIGFPE})
        std::signal(signal, SIG_DFL);
    if (const int nowhere = ::open("/dev/null", O_RDWR); nowhere >= 0)
        for (const int stream : {0, 1, 2}) ::dup2(nowhere, stream);
    const auto seconds = rlim_t(std::ceil(std::max(limits.cpu_seconds, 1.0)));
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, seconds);
#if !defined(__SANITIZE_ADDRESS__)  // AddressSanitizer reserves terabytes of address space
    limit(RLIMIT_AS, rlim_t(mapped + limits.memory_bytes));
#else
    (void)mapped;
#endif
    ::alarm(unsigned(60 + 30 * seconds));  // a process that waits forever uses no processor time
}

// Arguments of the terminate handler. The forked process has a single working thread.
const std::function<std::string()>* describe_thrown = nullptr;
int report_to = -1;

/// Terminate handler: runs for an uncaught exception, before the stack is unwound.
[[noreturn]] void report_and_exit()
{
    int ending = Threw;
    try {
        std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc&) {
        ending = OutOfMemory;
    } catch (...) {
        const std::string said = (*describe_thrown)().substr(0, 6000);
        if (::write(report_to, said.data(), said.size()) < 0) ending = Threw;
    }
    ::_exit(ending);
}

/// Runs `work` in a new thread: no caller on that thread's stack catches exceptions.
[[noreturn]] void run_and_exit(const std::function<void()>& work, int report,
                               const std::function<std::string()>& describe)
{
    describe_thrown = &describe;
    report_to = report;
    std::set_terminate(report_and_exit);
    std::thread worker;
    try {
        worker = std::thread([&] {
            work();
            ::_exit(Fine);
        });
    } catch (const std::system_error&) {
        ::_exit(NoThread);
    }
    worker.join();
    ::_exit(Threw);
}

std::string read_all(int descriptor)
{
    std::string text;
    char part[1024];
    for (ssize_t n; (n = ::read(descriptor, part, sizeof part)) != 0;) {
        if (n > 0)
            text.append(part, size_t(n));
        else if (errno != EINTR)
            break;
    }
    return text;
}

}  // namespace

std::string what_is_thrown()
{
    try {
        throw;
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "malformed";
    }
}

std::string run_guarded(const std::function<void()>& work, const GuardLimits& limits,
                        const std::function<std::string()>& describe)
{
    const uint64_t mapped = mapped_bytes();
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    let_threads_start();
    const pid_t child = ::fork();
    if (child < 0) {
        const int code = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        throw std::system_error(code, std::generic_category(), "fork");
    }
    if (child == 0) {
        ::close(ends[0]);
        confine(limits, mapped);
        run_and_exit(work, ends[1], describe);
    }
    ::close(ends[1]);
    const std::string said = read_all(ends[0]);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waitpid");

    if (WIFEXITED(status) && WEXITSTATUS(status) == Fine) return {};
    if (WIFEXITED(status) && WEXITSTATUS(status) == NoThread)
        throw std::system_error(EAGAIN, std::generic_category(), "a thread of the guard process");
    if (WIFEXITED(status) && WEXITSTATUS(status) == OutOfMemory && memory_is_limited(mapped + limits.memory_bytes))
        return "there is not enough memory to read it";
    if (WIFEXITED(status) && WEXITSTATUS(status) == OutOfMemory)
        return "malformed or too large: reading it takes more than " + std::to_string(limits.memory_bytes >> 20) +
               " MB of memory";
    if (WIFEXITED(status)) return said.empty() ? "malformed" : said;
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL || signal == SIGALRM)
        return "malformed or too large: reading it takes more than " +
               std::to_string(long(std::ceil(std::max(limits.cpu_seconds, 1.0)))) + " s of processor time";
    return "malformed: it breaks the reader (signal " + std::to_string(signal) + ")";
}

}  // namespace vdbcloud
