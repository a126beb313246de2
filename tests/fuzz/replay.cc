// Stands in for libFuzzer where the compiler has none: the seeds, then changes of them by a seeded generator.
//
//   fuzz_NAME FOLDER COUNT [SEED]
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

void run(const std::string& bytes)
{
    LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

/// One change: a bit, a byte, a piece removed, doubled or taken from another seed, a number in place of a byte.
void change(std::string& bytes, const std::string& other, std::mt19937_64& random)
{
    const auto below = [&](size_t n) { return n == 0 ? 0 : size_t(random() % n); };
    static const char* const words[] = {"nan", "inf",     "-1", "1e999", "0", "99999999999999999999", "\"", "\n", "=",
                                        "#",   "\\u0000", "[",  "]",     "-"};
    const size_t at = below(bytes.size() + 1), length = below(std::min<size_t>(bytes.size() - at, 16) + 1);
    switch (below(6)) {
    case 0:
        if (at < bytes.size()) bytes[at] = char(bytes[at] ^ (1 << below(8)));
        break;
    case 1: bytes.insert(at, 1, char(below(256))); break;
    case 2: bytes.erase(at, length); break;
    case 3: bytes.insert(at, bytes.substr(at, length)); break;
    case 4: bytes.insert(at, words[below(std::size(words))]); break;
    default: bytes.replace(at, length, other.substr(below(other.size() + 1), 16)); break;
    }
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc < 3) {
        std::fprintf(stderr, "fuzz: expected FOLDER COUNT [SEED]\n");
        return 2;
    }
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<std::string> seeds;
    for (const auto& file : files) {
        std::ifstream in(file, std::ios::binary);
        seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
        run(seeds.back());
    }
    if (seeds.empty()) return 2;
    std::mt19937_64 random(argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
    const long count = std::strtol(argv[2], nullptr, 10);
    for (long k = 0; k < count; ++k) {
        std::string bytes = seeds[random() % seeds.size()];
        for (uint64_t changes = 1 + random() % 8; changes > 0; --changes)
            change(bytes, seeds[random() % seeds.size()], random);
        run(bytes);
    }
    std::printf("%zu seeds and %ld changes of them\n", seeds.size(), count);
    return 0;
}
