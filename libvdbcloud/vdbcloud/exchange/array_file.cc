#include "vdbcloud/exchange/array_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/file/text.h"

#include <openvdb/Types.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <type_traits>

namespace vdbcloud {

namespace {

constexpr uint64_t most_bytes = uint64_t(1) << 31;
constexpr uint64_t most_numbers = uint64_t(1) << 28;

template<typename T>
void convert(const char* bytes, size_t count, bool swap, std::vector<float>& to)
{
    to.resize(count);
    for (size_t k = 0; k < count; ++k) {
        char one[sizeof(T)];
        std::memcpy(one, bytes + k * sizeof(T), sizeof(T));
        if (swap) std::reverse(one, one + sizeof(T));
        T value;
        std::memcpy(static_cast<void*>(&value), one, sizeof(T));
        to[k] = static_cast<float>(value);
    }
}

/// `count` numbers of a type of ArrayLayout as floats, in the file's order.
std::vector<float> numbers(const std::string& type, const char* bytes, size_t count, bool swap)
{
    std::vector<float> to;
    if (type == "b1" || type == "u1") convert<uint8_t>(bytes, count, swap, to);
    if (type == "i1") convert<int8_t>(bytes, count, swap, to);
    if (type == "u2") convert<uint16_t>(bytes, count, swap, to);
    if (type == "i2") convert<int16_t>(bytes, count, swap, to);
    if (type == "u4") convert<uint32_t>(bytes, count, swap, to);
    if (type == "i4") convert<int32_t>(bytes, count, swap, to);
    if (type == "u8") convert<uint64_t>(bytes, count, swap, to);
    if (type == "i8") convert<int64_t>(bytes, count, swap, to);
    if (type == "f2") convert<openvdb::math::half>(bytes, count, swap, to);
    if (type == "f4") convert<float>(bytes, count, swap, to);
    if (type == "f8") convert<double>(bytes, count, swap, to);
    return to;
}

[[noreturn]] void refuse_file(const std::string& path, const std::string& what)
{
    throw InputError(printable(path, 4096) + ": " + what);
}

std::string by(const std::array<size_t, 3>& n)
{
    return std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]);
}

/// The numbers from `offset` on to the end, x fastest.
Array in_order(const std::string& path, const std::string& bytes, size_t offset, const ArrayLayout& layout)
{
    size_t count = 1;
    for (const size_t n : layout.shape) {
        if (n == 0) refuse_file(path, by(layout.shape) + " numbers: expected one or more along each axis");
        if (n > most_numbers / count) refuse_file(path, by(layout.shape) + " numbers: expected at most 2^28");
        count *= n;
    }
    const size_t expected = count * bytes_of_type(layout.type);
    if (bytes.size() - offset != expected)
        refuse_file(path, std::to_string(bytes.size() - offset) + " bytes of numbers: expected " +
                              std::to_string(expected) + ", as " + by(layout.shape) + " of type " + layout.type +
                              " take");
    const std::vector<float> read = numbers(layout.type, bytes.data() + offset, count, layout.big_endian);
    std::array<size_t, 3> stride{};
    size_t step = 1;
    for (size_t k = 3; k-- > 0;) {
        const auto axis = size_t(layout.axes[k] - 'x');
        stride[axis] = step;
        step *= layout.shape[axis];
    }
    Array array{layout.shape, std::vector<float>(count)};
    size_t at = 0;
    for (size_t z = 0; z < layout.shape[2]; ++z)
        for (size_t y = 0; y < layout.shape[1]; ++y)
            for (size_t x = 0; x < layout.shape[0]; ++x, ++at)
                array.values[at] = read[x * stride[0] + y * stride[1] + z * stride[2]];
    return array;
}

/// The header of a .npy: a dictionary of Python with three keys, in any order.
class NpyHeader {
public:
    NpyHeader(const std::string& path, const std::string& bytes) : path_(path)
    {
        if (bytes.size() < 10 || bytes.compare(0, 6, "\x93NUMPY", 6) != 0)
            refuse_file(path, "not a .npy file (wrong magic number)");
        const int version = uint8_t(bytes[6]);
        const auto byte = [&](size_t k) { return uint64_t(uint8_t(bytes[k])); };
        const size_t begin = version == 1 ? 10 : 12;
        if (version < 1 || version > 3 || bytes.size() < begin) damaged();
        const uint64_t length = byte(8) + 256 * byte(9) + (version == 1 ? 0 : 65536 * (byte(10) + 256 * byte(11)));
        if (length > bytes.size() - begin) damaged();
        text_ = bytes.substr(begin, length);
        offset = begin + length;
    }

    /// What follows the key up to the end of its value.
    std::string value(const std::string& key) const
    {
        for (const char quote : {'\'', '"'}) {
            const size_t at = text_.find(quote + key + quote);
            if (at == std::string::npos) continue;
            const size_t from = text_.find_first_not_of(" :", at + key.size() + 2);
            if (from == std::string::npos) damaged();
            const size_t to = text_.find_first_of(text_[from] == '(' ? ")" : ",}", from);
            if (to == std::string::npos) damaged();
            return text_.substr(from, to - from);
        }
        damaged();
    }

    /// The numbers of "(4, 3, 2".
    std::vector<size_t> shape() const
    {
        const std::string text = value("shape");
        std::vector<size_t> all;
        for (size_t at = text.find_first_of("0123456789"); at != std::string::npos;
             at = text.find_first_of("0123456789", at)) {
            size_t n = 0;
            const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), n);
            if (error != std::errc()) damaged();
            all.push_back(n);
            at = size_t(end - text.data());
        }
        return all;
    }

    [[noreturn]] void damaged() const { refuse_file(path_, "damaged .npy file: its header is not one of an array"); }

    size_t offset = 0;

private:
    std::string path_, text_;
};

}  // namespace

size_t bytes_of_type(const std::string& type)
{
    if (type.size() != 2) return 0;
    const auto known = [&](const char* sizes) { return std::string(sizes).find(type[1]) != std::string::npos; };
    const bool fine = (type[0] == 'b' && known("1")) || (type[0] == 'f' && known("248")) ||
                      ((type[0] == 'i' || type[0] == 'u') && known("1248"));
    return fine ? size_t(type[1] - '0') : 0;
}

Array read_raw(const std::string& path, const ArrayLayout& layout)
{
    return in_order(path, read_bytes(path, most_bytes, "array"), 0, layout);
}

Array read_npy(const std::string& path, const std::string& axes)
{
    const std::string bytes = read_bytes(path, most_bytes, "array");
    const NpyHeader header(path, bytes);
    ArrayLayout layout;
    std::string type = header.value("descr");
    type.erase(std::remove_if(type.begin(), type.end(), [](char c) { return c == '\'' || c == '"' || c == ' '; }),
               type.end());
    if (!type.empty() && std::string("<>|=").find(type[0]) != std::string::npos) {
        layout.big_endian = type[0] == '>';
        type.erase(0, 1);
    }
    layout.type = type;
    if (bytes_of_type(type) == 0)
        refuse_file(path, "numbers of type '" + printable(type, 40) + "': expected whole or floating-point numbers");
    const std::vector<size_t> shape = header.shape();
    if (shape.size() != 3)
        refuse_file(path, std::to_string(shape.size()) + " dimensions: expected three, named by --axes " + axes);
    for (size_t k = 0; k < 3; ++k) layout.shape[size_t(axes[k] - 'x')] = shape[k];
    layout.axes = axes;
    if (header.value("fortran_order").rfind("True", 0) == 0) std::reverse(layout.axes.begin(), layout.axes.end());
    return in_order(path, bytes, header.offset, layout);
}

}  // namespace vdbcloud
