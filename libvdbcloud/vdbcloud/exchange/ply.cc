// The vertices of .ply files, in Greg Turk's format: a header of text, then elements as text or bytes.
#include "vdbcloud/core/error.h"
#include "vdbcloud/exchange/particles.h"
#include "vdbcloud/file/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr uint64_t most_bytes = uint64_t(4) << 30;

enum class Type { I1, U1, I2, U2, I4, U4, F4, F8 };

constexpr size_t bytes_of(Type type)
{
    constexpr size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[size_t(type)];
}

struct Property {
    std::string name;
    Type type = Type::F4;
    bool list = false;
    Type count = Type::U1;  // of a list
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;
};

class Ply {
public:
    explicit Ply(const std::string& path) : path_(path), bytes_(read_bytes(path, most_bytes, ".ply file"))
    {
        read_header();
    }

    Particles vertices(const ParticleNames& chosen)
    {
        for (const Element& element : elements_) {
            if (element.name == "vertex") return read(element, chosen);
            skip(element);
        }
        fail("no element vertex");
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw InputError(printable(path_, 4096) + ": " + what); }
    [[noreturn]] void fail_header(const std::string& line) const
    {
        fail("damaged .ply header: '" + printable(line, 80) + "'");
    }

    Type type_of(const std::string& word, const std::string& line) const
    {
        static const std::vector<std::pair<const char*, Type>> all = {
            {"char", Type::I1},  {"uchar", Type::U1},  {"short", Type::I2},   {"ushort", Type::U2},
            {"int", Type::I4},   {"uint", Type::U4},   {"float", Type::F4},   {"double", Type::F8},
            {"int8", Type::I1},  {"uint8", Type::U1},  {"int16", Type::I2},   {"uint16", Type::U2},
            {"int32", Type::I4}, {"uint32", Type::U4}, {"float32", Type::F4}, {"float64", Type::F8}};
        for (const auto& [known, type] : all)
            if (word == known) return type;
        fail_header(line);
    }

    std::string header_line()
    {
        const size_t end = bytes_.find('\n', at_);
        if (end == std::string::npos || end - at_ > 4096) fail("damaged .ply header: it has no end");
        std::string line = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (!line.empty() && line.back() == '\r') line.pop_back();
        return line;
    }

    void read_header()
    {
        if (header_line() != "ply") fail("not a .ply file (wrong magic number)");
        for (;;) {
            const std::string line = header_line();
            std::istringstream words(line);
            std::string key, word;
            words >> key >> word;
            if (key == "end_header") break;
            if (key == "format")
                set_format(word, line);
            else if (key == "element")
                add_element(word, words, line);
            else if (key == "property")
                add_property(word, words, line);
            else if (key != "comment" && key != "obj_info")
                fail_header(line);
        }
        if (!has_format_) fail("damaged .ply header: no format");
    }

    void set_format(const std::string& word, const std::string& line)
    {
        if (word != "ascii" && word != "binary_little_endian" && word != "binary_big_endian") fail_header(line);
        ascii_ = word == "ascii";
        swap_ = word == "binary_big_endian";
        has_format_ = true;
    }

    void add_element(const std::string& name, std::istringstream& words, const std::string& line)
    {
        Element element{name, 0, {}};
        std::string count;
        words >> count;
        const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (error != std::errc() || end != count.data() + count.size()) fail_header(line);
        elements_.push_back(element);
    }

    void add_property(const std::string& word, std::istringstream& words, const std::string& line)
    {
        if (elements_.empty()) fail_header(line);
        Property property;
        std::string type = word;
        if (word == "list") {
            std::string count;
            words >> count >> type;
            property.list = true;
            property.count = type_of(count, line);
        }
        property.type = type_of(type, line);
        if (!(words >> property.name)) fail_header(line);
        elements_.back().properties.push_back(property);
    }

    double number(Type type)
    {
        if (ascii_) return word();
        const size_t size = bytes_of(type);
        if (bytes_.size() - at_ < size) fail("ends too early, at " + std::to_string(bytes_.size()) + " bytes");
        char one[8];
        std::memcpy(one, bytes_.data() + at_, size);
        at_ += size;
        if (swap_) std::reverse(one, one + size);
        switch (type) {
        case Type::I1: return as<int8_t>(one);
        case Type::U1: return as<uint8_t>(one);
        case Type::I2: return as<int16_t>(one);
        case Type::U2: return as<uint16_t>(one);
        case Type::I4: return as<int32_t>(one);
        case Type::U4: return as<uint32_t>(one);
        case Type::F4: return double(as<float>(one));
        case Type::F8: return as<double>(one);
        }
        return 0;
    }

    template<typename T>
    static T as(const char* bytes)
    {
        T value;
        std::memcpy(&value, bytes, sizeof value);
        return value;
    }

    double word()
    {
        at_ = std::min(bytes_.find_first_not_of(" \t\r\n", at_), bytes_.size());
        const size_t end = std::min(bytes_.find_first_of(" \t\r\n", at_), bytes_.size());
        const char* const first = bytes_.data() + at_ + (at_ < end && bytes_[at_] == '+');
        double value = 0;
        const auto [rest, error] = std::from_chars(first, bytes_.data() + end, value);
        if (at_ == end) fail("ends too early, at " + std::to_string(bytes_.size()) + " bytes");
        if (error != std::errc() || rest != bytes_.data() + end)
            fail("'" + printable(bytes_.substr(at_, end - at_), 40) + "': expected a number");
        at_ = end;
        return value;
    }

    double value_of(const Property& property)
    {
        if (!property.list) return number(property.type);
        const double count = number(property.count);
        if (!(count >= 0 && count <= double(bytes_.size())))
            fail("list of " + std::to_string(count) + " numbers in '" + printable(property.name, 40) + "'");
        for (double k = 0; k < count; ++k) number(property.type);
        return 0;
    }

    void skip(const Element& element)
    {
        if (element.properties.empty()) return;  // takes no bytes, however many there are
        for (uint64_t row = 0; row < element.count; ++row)
            for (const Property& property : element.properties) value_of(property);
    }

    Particles read(const Element& element, const ParticleNames& chosen)
    {
        std::vector<std::string> names;
        for (const Property& property : element.properties) names.push_back(property.list ? "" : property.name);
        std::array<int, 10> columns{};
        try {
            columns = particle_columns(names, chosen);
        } catch (const InputError& e) {
            fail(e.what());
        }
        Particles particles;
        std::vector<double> row(element.properties.size());
        std::array<double, 10> values{};
        for (uint64_t k = 0; k < element.count; ++k) {
            for (size_t p = 0; p < row.size(); ++p) row[p] = value_of(element.properties[p]);
            for (size_t c = 0; c < columns.size(); ++c) values[c] = columns[c] < 0 ? 0 : row[size_t(columns[c])];
            add_particle(particles, columns, values,
                         [&] { return printable(path_, 4096) + ": vertex " + std::to_string(k) + ": "; });
        }
        return particles;
    }

    std::string path_, bytes_;
    size_t at_ = 0;
    bool ascii_ = false, swap_ = false, has_format_ = false;
    std::vector<Element> elements_;
};

}  // namespace

Particles read_ply(const std::string& path, const ParticleNames& chosen) { return Ply(path).vertices(chosen); }

}  // namespace vdbcloud
