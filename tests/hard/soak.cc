#include "hard/soak.h"

#include "support/run.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

std::string frame_of(const std::string& pattern, int number)
{
    char digits[16];
    std::snprintf(digits, sizeof digits, "%04d", number);
    std::string name = pattern;
    return name.replace(name.find("%04d"), 4, digits);
}

/// Largest resident memory of a process so far [bytes]; 0 once it has ended.
double peak_memory(pid_t process)
{
    std::ifstream in("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(in, line);)
        if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::stod(line.substr(6));
    return 0;
}

int open_files(pid_t process)
{
    std::error_code gone;
    std::filesystem::directory_iterator files("/proc/" + std::to_string(process) + "/fd", gone), end;
    int count = 0;
    for (; !gone && files != end; files.increment(gone)) ++count;
    return count;
}

int hidden_in(const std::string& folder)
{
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        count += entry.path().filename().string()[0] == '.';
    return count;
}

pid_t start(const std::string& path, const Words& arguments, const std::string& folder, const std::string& temporary)
{
    const pid_t process = ::fork();
    if (process != 0) return process;
    std::vector<char*> words{const_cast<char*>(path.c_str())};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    ::setenv("TMPDIR", temporary.c_str(), 1);
    const int log = ::open((folder + "/stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ::dup2(log, 2);
    if (::chdir(folder.c_str()) == 0) ::execv(words[0], words.data());
    ::_exit(127);
}

}  // namespace

Growth watch(const std::string& path, const Words& arguments, const std::string& folder, const std::string& output,
             int frames)
{
    const std::string temporary = folder + "/temporary";
    std::filesystem::create_directories(temporary);
    const pid_t process = start(path, arguments, folder, temporary);
    Growth growth;
    double half = 0, end = 0;
    int files[2] = {0, 0}, status = 0;
    rusage used{};
    while (::wait4(process, &status, WNOHANG, &used) == 0) {
        // Frame n is there once frame n + 1 has begun.
        if (half == 0 && std::filesystem::exists(folder + "/" + frame_of(output, std::max(1, frames / 2))))
            half = peak_memory(process);
        if (half > 0) end = std::max(end, peak_memory(process));
        int& most = files[half > 0];
        most = std::max(most, open_files(process));
        ::usleep(1000);
    }
    growth.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    growth.memory = half > 0 ? end / half - 1 : 0;  // ru_maxrss is that of the parent, before exec
    growth.descriptors = files[1] - files[0];
    growth.left = hidden_in(folder) + int(std::distance(std::filesystem::directory_iterator(temporary), {}));
    growth.seconds = double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                     1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    for (int n = 1; n <= frames; ++n)
        if (growth.status == 0 && !std::filesystem::exists(folder + "/" + frame_of(output, n)))
            throw std::runtime_error(path + " ended with status 0 without frame " + std::to_string(n));
    if (growth.status == 0 && half == 0) throw std::runtime_error(path + " ended before it was looked at");
    return growth;
}

std::vector<Row> soak(int frames, const std::string& folder)
{
    const std::string numbers = "1-" + std::to_string(frames),
                      each = " -q --threads 1 --trust-input --frames " + numbers;
    // Frame 0 of cloudsim is the first air, without smoke.
    const std::string air = "--preset smoke --cells 16 --minutes " + std::to_string(frames) +
                            " --every 1min --grids density -q --threads 1";
    const struct {
        const char* name;
        std::string options, output;
    } programs[] = {
        {"cloudsim", air, "air.%04d.vdb"},
        {"fractalgen", "--envelope-from air.%04d.vdb --size 16" + each, "cloud.%04d.vdb"},
        {"illuminate", "air.%04d.vdb --sun 0.3,1,0.2" + each, "lit.%04d.vdb"},
        {"p1solve", "lit.%04d.vdb --reentry-rays 200" + each, "solved.%04d.vdb"},
        {"render", "solved.%04d.vdb --resolution 16 --camera 4000,1000,0 --look-at 0,1000,0" + each,
         "picture.%04d.exr"},
    };
    std::vector<Row> rows;
    for (const auto& one : programs) {
        Words words = split(one.options);
        words.insert(words.end(), {"-o", one.output});
        const Growth g = watch(program(one.name), words, folder, one.output, frames);
        const std::string group = std::string("soak: ") + one.name;
        const std::string where =
            g.status == 0 ? "" : "status " + std::to_string(g.status) + ": " + read_text(folder + "/stderr");
        const auto row = [&](const char* invariant, double worst, double limit) {
            const bool good = g.status == 0 && worst <= limit;
            rows.push_back({group, invariant, worst, limit, frames, good ? 0 : 1, where, ""});
        };
        // The allocator's pools fill over the first frames: of few frames the second half has some of this, too.
        row("memory growth", g.memory, frames < 50 ? 0.1 : 0.03);
        // A look may meet a file that is open for a moment; a leak of each frame is half as many as there are frames.
        row("descriptors", g.descriptors, frames < 50 ? 3 : 8);
        row("files left", g.left, 0);
    }
    return rows;
}

}  // namespace vdbcloud::test
