#pragma once
// Temporary redirection of the test's own standard input and output.
#include <fcntl.h>
#include <unistd.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

namespace vdbcloud::test {

/// Redirects descriptor `which` to `other` during the object's lifetime. Takes ownership of `other`.
class Redirect {
public:
    Redirect(int which, int other) : which_(which), kept_(::dup(which))
    {
        if (other < 0 || kept_ < 0 || ::dup2(other, which) < 0) throw std::runtime_error("cannot redirect");
        ::close(other);
    }
    ~Redirect()
    {
        ::dup2(kept_, which_);
        ::close(kept_);
    }
    Redirect(const Redirect&) = delete;
    Redirect& operator=(const Redirect&) = delete;

private:
    int which_, kept_;
};

/// Runs `work` with standard input fed from a real pipe.
inline void with_input(const std::string& bytes, const std::function<void()>& work)
{
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    std::thread feeder([&bytes, end = ends[1]] {
        for (size_t done = 0; done < bytes.size();) {
            const ssize_t n = ::write(end, bytes.data() + done, bytes.size() - done);
            if (n <= 0) break;
            done += size_t(n);
        }
        ::close(end);
    });
    {
        const Redirect redirect(0, ends[0]);
        try {
            work();
        } catch (...) {
            for (char rest[4096]; ::read(0, rest, sizeof rest) > 0;) {
            }  // lets the feeder thread finish
            feeder.join();
            throw;
        }
        for (char rest[4096]; ::read(0, rest, sizeof rest) > 0;) {
        }
    }
    feeder.join();
}

/// The bytes that `work` writes to standard output, through a real pipe.
inline std::string output_of(const std::function<void()>& work)
{
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    std::string bytes;
    std::thread reader([&bytes, end = ends[0]] {
        char part[65536];
        for (ssize_t n; (n = ::read(end, part, sizeof part)) > 0;) bytes.append(part, size_t(n));
        ::close(end);
    });
    {
        const Redirect redirect(1, ends[1]);
        work();
    }
    reader.join();
    return bytes;
}

}  // namespace vdbcloud::test
