#pragma once
// What TBB orders and ThreadSanitizer cannot see, since libtbb is not built with it: parallel_for's body runs after the
// call began, and the call returns after all bodies. The preset "tsan" includes this before every source, so that it
// holds for OpenVDB's headers, too.
#include <tbb/parallel_for.h>

#include <sanitizer/tsan_interface.h>

#include <tuple>
#include <type_traits>
#include <utility>

namespace tbb {

template<typename Body>
struct Ordered {
    Body body;
    char *begin, *end;

    template<typename Range>
    void operator()(Range&& range) const  // some bodies take a range that is not const
    {
        __tsan_acquire(begin);
        body(range);
        __tsan_release(end);
    }
};

/// parallel_for(range, body, partitioner ...), and parallel_for(first, last, body) where `last` is a number.
template<typename First, typename Second, typename... Rest>
void ordered_parallel_for(const First& first, const Second& second, Rest&&... rest)
{
    char begin = 0, end = 0;
    __tsan_release(&begin);
    if constexpr (std::is_arithmetic_v<Second>) {
        const auto& body = std::get<0>(std::tie(rest...));
        parallel_for(first, First(second), Ordered<std::decay_t<decltype(body)>>{body, &begin, &end});
    } else {
        parallel_for(first, Ordered<Second>{second, &begin, &end}, std::forward<Rest>(rest)...);
    }
    __tsan_acquire(&end);
}

}  // namespace tbb

#define parallel_for ordered_parallel_for
