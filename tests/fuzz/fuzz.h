#pragma once
// Bytes of a stranger for what vdbcloud parses itself. Each source of this folder defines judge() for one parser.
#include "vdbcloud/core/error.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace vdbcloud::test {

/// Parses `bytes` and checks what came out with demand(). What the parser throws for text that is none of its own is
/// right, if its message is a sentence.
void judge(std::string_view bytes);

/// Ends the program, which a fuzzer takes for a find.
inline void demand(bool holds, const char* what)
{
    if (holds) return;
    std::fprintf(stderr, "fuzz: expected %s\n", what);
    std::abort();
}

inline void judge_guarded(std::string_view bytes)
{
    const auto sentence = [](const char* what) {
        const std::string_view text = what;
        demand(!text.empty() && text.size() < 8192, "a message of 1 to 8191 bytes");
        for (const char c : text) demand(c >= ' ' && c <= '~', "a message of printable characters, in one line");
    };
    try {
        judge(bytes);
    } catch (const InputError& e) {
        sentence(e.what());
    } catch (const IoError& e) {
        sentence(e.what());
    } catch (const UsageError& e) {
        sentence(e.what());
    }
}

}  // namespace vdbcloud::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    vdbcloud::test::judge_guarded({reinterpret_cast<const char*>(data), size});
    return 0;
}
