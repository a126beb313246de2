#include "progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace vdbcloud::app {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }

void put(const std::string& text)
{
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

int columns()
{
    winsize size = {};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

std::string bar(const std::string& label, double fraction, double seconds)
{
    char tail[64];
    const double left = fraction > 0.01 ? seconds / fraction - seconds : 0;
    std::snprintf(tail, sizeof tail, " %3.0f %% %5.0f s%s", 100 * fraction, left > 0 ? left : seconds,
                  left > 0 ? " left" : "");
    const int width = std::clamp(columns() - 40, 10, 40);
    const int full = int(fraction * width);
    std::string text = label.substr(0, 14);
    text.resize(15, ' ');
    return "\r" + text + "[" + std::string(full, '#') + std::string(width - full, '.') + "]" + tail + "\033[K";
}

}  // namespace

struct Meter::Task {
    std::string label;
    Clock::time_point start = Clock::now();
    Clock::time_point drawn = start;
    int tenths = -1;
    bool ended = false;
};

void Meter::set(Mode mode, const std::string& tool)
{
    mode_ = mode;
    tool_ = tool;
}

Progress Meter::of(const std::string& label)
{
    if (mode_ == Off) return {};
    auto task = std::make_shared<Task>();
    task->label = one_line(label, 60);
    return [this, task](double fraction) {
        update(*task, fraction);
        return true;
    };
}

void Meter::update(Task& task, double fraction)
{
    const std::lock_guard<std::mutex> lock(mutex_);
    fraction = std::clamp(fraction, 0.0, 1.0);
    const bool end = fraction >= 1;
    if (task.ended) return;
    task.ended = end;
    const double seconds = seconds_since(task.start);
    char text[200];
    if (mode_ == Lines) {
        const int tenths = int(fraction * 10);
        if (tenths <= task.tenths) return;
        task.tenths = tenths;
        std::snprintf(text, sizeof text, "%s: %s %d %%\n", tool_.c_str(), task.label.c_str(), tenths * 10);
        put(text);
        return;
    }
    const double period = mode_ == Bar ? 0.1 : 1.0;
    if (!end && seconds_since(task.drawn) < period) return;
    task.drawn = Clock::now();
    if (mode_ == Bar) {
        put(end ? "\r\033[K" : bar(task.label, fraction, seconds));
        bar_shown_ = !end;
    } else {
        std::string label;
        for (char c : task.label) label += c == '"' || c == '\\' ? '\'' : c;
        std::snprintf(text, sizeof text, "{\"tool\":\"%s\",\"phase\":\"%s\",\"fraction\":%.4f,\"seconds\":%.2f}\n",
                      tool_.c_str(), label.c_str(), fraction, seconds);
        put(text);
    }
}

void Meter::line(const std::string& text)
{
    const std::lock_guard<std::mutex> lock(mutex_);
    put((bar_shown_ ? "\r\033[K" : "") + text + "\n");
    bar_shown_ = false;
}

void Meter::clear()
{
    const std::lock_guard<std::mutex> lock(mutex_);
    if (bar_shown_) put("\r\033[K");
    bar_shown_ = false;
}

std::string one_line(const std::string& text, size_t most)
{
    std::string out = text.substr(0, most);
    for (char& c : out) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\n')
            c = ' ';
        else if (byte < 0x20 || byte == 0x7f)
            c = '?';
    }
    return text.size() > most ? out + "..." : out;
}

bool coloured()
{
    const char* no_color = std::getenv("NO_COLOR");
    return ::isatty(STDERR_FILENO) && !(no_color && *no_color);
}

}  // namespace vdbcloud::app
