#pragma once
// Readers of other people's libraries, run in a guarded process that sends back plain numbers. Private to exchange/.
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace vdbcloud {

/// Numbers and texts in a row, in memory that two processes share.
class ByteChannel {
public:
    ByteChannel();
    ~ByteChannel();
    ByteChannel(const ByteChannel&) = delete;
    ByteChannel& operator=(const ByteChannel&) = delete;

    template<typename T>
    void put(const std::vector<T>& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        put_size(values.size());
        write(values.data(), values.size() * sizeof(T));
    }
    void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
    void put(const std::vector<std::string>& texts);

    /// Reads in the order of put(), from the first value on. Throws InputError where fewer bytes are there.
    template<typename T>
    std::vector<T> get()
    {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<T> values(get_size(sizeof(T)));
        read(values.data(), values.size() * sizeof(T));
        return values;
    }
    std::string get_text();
    std::vector<std::string> get_texts();

private:
    void put_size(uint64_t count);
    uint64_t get_size(uint64_t bytes_each);
    void write(const void* bytes, uint64_t count);
    void read(void* bytes, uint64_t count);

    int descriptor_ = -1;
    uint64_t at_ = 0;
};

/// Runs `work` in a forked process with limits of memory and processor time that grow with the size of the file. `work`
/// puts what it finds into a ByteChannel, from which this process then reads. A library that a damaged file breaks ends
/// that process alone. Throws InputError, beginning with the path: what `work` threw, or the limit or signal that ended
/// the process; IoError if the path is no file that can be read.
void read_guarded(const std::string& path, const std::function<void()>& work);

}  // namespace vdbcloud
