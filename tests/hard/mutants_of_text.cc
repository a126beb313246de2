#include "hard/mutants.h"

#include "vdbcloud/grid/digest.h"

#include <cstdint>
#include <vector>

namespace vdbcloud::test {

namespace {

const char* bad_word(Dice& dice)
{
    return dice.one_of({"nan",    "inf",   "-inf",  "1e999",      "-1e308",      "1e-320", "0x7f",
                        "-0",     "1e",    "+",     "1,2,3,4",    "'",           "\"",     "[1, 2, 3",
                        "[[[[[[", "{}",    "#",     "1979-05-27", "\x1b[31m",    "\xff",   "99999999999999999999999",
                        "1e9",    "-1",    "2.5.5", "true",       "\"\\u0000\"", "''' ",   "4294967296",
                        "1e300",  "1e-30", "0",     "\"\"\"",     "_",           "1_000",  "\\"});
}

uint32_t crc_of(const std::string& bytes)
{
    uint32_t crc = 0xffffffffu;
    for (const char c : bytes) {
        crc ^= uint8_t(c);
        for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

void put_big_endian(std::string& bytes, size_t at, uint32_t value)
{
    for (size_t k = 0; k < 4; ++k) bytes[at + k] = char(value >> (24 - 8 * k));
}

/// The header is the first part of a PNG: width, height, depth, colours, three methods.
std::string hostile_png(std::string bytes, Dice& dice)
{
    if (bytes.size() < 33) return bytes;
    const auto size = [&] { return dice.one_of<uint32_t>({0, 1, 65535, 100000, 0x7fffffff, 0xffffffff, 16384}); };
    if (dice.chance(0.7)) put_big_endian(bytes, 16, size());
    if (dice.chance(0.7)) put_big_endian(bytes, 20, size());
    if (dice.chance(0.3)) bytes[24] = dice.one_of({char(1), char(16), char(0), char(64)});
    if (dice.chance(0.3)) bytes[25] = dice.one_of({char(0), char(2), char(3), char(4), char(6), char(7)});
    put_big_endian(bytes, 29, crc_of(bytes.substr(12, 17)));
    return bytes;
}

/// Attributes of an OpenEXR file: name, type, size, value.
std::string hostile_exr(std::string bytes, Dice& dice)
{
    const std::string window = dice.one_of({"dataWindow", "displayWindow"});
    const size_t at = bytes.find(window + std::string("\0box2i\0", 7));
    if (at == std::string::npos) return bytes;
    const size_t box = at + window.size() + 7 + 4;
    const int far = dice.one_of({0x7fffffff, 0x3fffffff, 1 << 20, 100000, -1, 0, int(0x80000000u)});
    for (size_t k = 0; k < 4; ++k)
        if (dice.chance(0.5)) put(bytes, box + 4 * k, int32_t(k < 2 ? 0u - uint32_t(far) : uint32_t(far)));
    if (const size_t packing = bytes.find(std::string("compression\0compression\0", 24));
        packing != std::string::npos && dice.chance(0.3))
        bytes[packing + 28] = char(dice.below(12));
    return bytes;
}

/// "-Y 4 +X 8" of a .hdr, "8 4" of a .ppm.
std::string hostile_head(std::string bytes, Dice& dice, const std::string& head)
{
    const char* size = dice.one_of({"0", "-1", "1", "100000", "2147483647", "99999999999999", "16384", "x"});
    const size_t at = bytes.find(head);
    if (at == std::string::npos) return bytes;
    const bool width = dice.chance(0.5);
    const std::string other = dice.chance(0.5) ? size : "8";
    bytes.replace(at, head.size(),
                  head[0] == '-' ? "-Y " + (width ? other : size) + " +X " + (width ? size : other)
                                 : other + " " + size);
    return bytes;
}

}  // namespace

std::string hostile_text(const std::string& text, Dice& dice, std::string& what)
{
    std::vector<std::string> lines(1);
    for (const char c : text)
        if (c == '\n')
            lines.emplace_back();
        else
            lines.back() += c;
    for (size_t more = 1 + dice.below(4); more > 0; --more) {
        std::string& line = lines[dice.below(lines.size())];
        const size_t equals = line.find("= ");
        switch (dice.below(10)) {
        case 0: line = bad_word(dice); break;
        case 1: line += std::string(" ") + bad_word(dice); break;
        case 2: lines.insert(lines.begin() + std::ptrdiff_t(dice.below(lines.size())), line); break;
        case 3:
            line = std::string(dice.one_of<size_t>({100000, 1 << 22}), dice.one_of({'[', '1', ' ', '\0', 'a'}));
            break;
        case 4: lines[0] = "\xef\xbb\xbf" + lines[0]; break;
        default:
            // A value: after "= " of a configuration, else a word; a comment becomes a value.
            if (equals != std::string::npos) {
                if (line[0] == '#') line.erase(0, 1);
                line = line.substr(0, line.find("= ") + 2) + bad_word(dice);
            } else {
                const size_t begin = line.find_first_not_of(' ', dice.below(line.size() + 1));
                if (begin != std::string::npos) line.replace(begin, line.find(' ', begin) - begin, bad_word(dice));
            }
        }
    }
    std::string all;
    for (const std::string& line : lines) all += line + dice.one_of({"\n", "\n", "\n", "\n", "\r\n", "\r"});
    what = "text";
    return all;
}

std::string hostile_picture(const std::string& bytes, const std::string& extension, Dice& dice, std::string& what)
{
    if (extension != "png" && extension != "exr" && extension != "hdr" && extension != "ppm")
        return what = "damaged", damaged(bytes, dice);
    what = "claims of a ." + extension;
    if (extension == "png") return hostile_png(bytes, dice);
    if (extension == "exr") return hostile_exr(bytes, dice);
    return hostile_head(bytes, dice, extension == "hdr" ? "-Y 4 +X 8" : "8 4");
}

std::string hostile_checkpoint(std::string bytes, Dice& dice, std::string& what)
{
    what = "a value of the state";
    constexpr size_t checksum = 32;
    if (bytes.size() < 64 + checksum) return bytes;
    const size_t at = dice.below(bytes.size() - checksum - 8);
    if (dice.chance(0.3))
        put(bytes, at, dice.one_of<int32_t>({0, -1, 0x7fffffff, int32_t(0x80000000u), 1 << 20}));
    else if (dice.chance(0.5))
        put(bytes, at, dice.one_of({double(NAN), double(INFINITY), 1e300, -1.0, 1e-300}));
    else
        put(bytes, at, dice.one_of({NAN, INFINITY, 1e38f, -1e38f}));
    Digest digest;
    digest.add(bytes.data(), bytes.size() - checksum);
    bytes.replace(bytes.size() - checksum, checksum, digest.hex());
    return bytes;
}

}  // namespace vdbcloud::test
