// Preloaded into a program: the program loads its libraries once, then runs main() once for each request, each time in
// a new process. Most of the time of a short run is the loading of libraries.
//
// Requests come on standard input: a uint32 of the number of bytes, then words that end with a null byte: folder,
// processor seconds, bytes of address space, file of standard input, then the arguments. The answer on standard output
// is an Answer. A run writes its output to the files `stdout` and `stderr` of the folder, which is its working folder.
#include "hard/start_once.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

namespace {

using Main = int (*)(int, char**, char**);
Main program_main = nullptr;

bool read_all(void* to, size_t bytes)
{
    for (char* at = static_cast<char*>(to); bytes > 0;) {
        const ssize_t n = ::read(0, at, bytes);
        if (n <= 0) return false;
        at += n;
        bytes -= size_t(n);
    }
    return true;
}

void redirect(int file, const char* path, int flags)
{
    const int opened = ::open(path, flags, 0666);
    ::dup2(opened, file);
    ::close(opened);
}

[[noreturn]] void run_main(std::vector<char*> words, char** environment)
{
    if (::chdir(words[0]) != 0) ::_exit(126);
    redirect(0, words[3], O_RDONLY);
    redirect(1, "stdout", O_WRONLY | O_CREAT | O_TRUNC);
    redirect(2, "stderr", O_WRONLY | O_CREAT | O_TRUNC);
    const rlim_t seconds = std::strtoull(words[1], nullptr, 10), bytes = std::strtoull(words[2], nullptr, 10);
    const rlimit processor = {std::max<rlim_t>(seconds, 2) - 1, seconds + 1}, memory = {bytes, bytes};
    ::setrlimit(RLIMIT_CPU, &processor);
    ::setrlimit(RLIMIT_AS, &memory);
    ::alarm(unsigned(10 * seconds));  // a program that waits for ever
    words.erase(words.begin(), words.begin() + 4);
    const int count = int(words.size());
    words.push_back(nullptr);
    const int status = program_main(count, words.data(), environment);
    std::cout.flush();
    std::fflush(nullptr);
    ::_exit(status);  // destructors of libraries would wait for threads that this process does not have
}

int serve(int, char**, char** environment)
{
    ::unsetenv("LD_PRELOAD");
    ::unsetenv("LD_BIND_NOW");
    for (uint32_t size = 0; read_all(&size, sizeof size);) {
        std::string text(size, '\0');
        if (!read_all(text.data(), size)) return 1;
        std::vector<char*> words;
        for (size_t k = 0; k < size; k += std::char_traits<char>::length(&text[k]) + 1) words.push_back(&text[k]);
        const pid_t child = ::fork();
        if (child == 0) run_main(words, environment);
        int status = 0;
        rusage used{};
        ::wait4(child, &status, 0, &used);
        vdbcloud::test::Answer answer;
        answer.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
        answer.seconds = double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                         1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
        answer.bytes = 1024.0 * double(used.ru_maxrss);
        if (::write(1, &answer, sizeof answer) != sizeof answer) return 1;
    }
    return 0;
}

}  // namespace

extern "C" int __libc_start_main(Main main, int count, char** words, void (*init)(), void (*fini)(), void (*rtld)(),
                                 void* stack)
{
    program_main = main;
    const auto start = reinterpret_cast<decltype(&__libc_start_main)>(::dlsym(RTLD_NEXT, "__libc_start_main"));
    return start(serve, count, words, init, fini, rtld, stack);
}
