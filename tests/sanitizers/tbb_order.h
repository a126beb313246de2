#pragma once
// What TBB orders and ThreadSanitizer cannot see, since libtbb is not built with it: a body runs after the thread that
// made or copied it did so, and a call returns after all bodies and joins. The preset "tsan" includes this before every
// source, so that it holds for OpenVDB's headers, too.
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <sanitizer/tsan_interface.h>

#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>

namespace tbb {

/// The two places of a call: every copy of a body releases `begin`, every body and join releases `end`.
struct Order {
    char begin = 0, end = 0;

    static Order* after_copies(Order* order)
    {
        __tsan_acquire(&order->begin);
        return order;
    }
};

template<typename Body>
struct Ordered {
    Order* order;
    Body body;

    Ordered(const Body& from, Order* of) : order(of), body(from) { __tsan_release(&order->begin); }
    Ordered(const Ordered& from) : order(Order::after_copies(from.order)), body(from.body)
    {
        __tsan_release(&order->begin);
    }
    ~Ordered() { __tsan_release(&order->end); }

    template<typename Range>
    void operator()(Range&& range) const  // some bodies take a range that is not const
    {
        __tsan_acquire(&order->begin);
        body(range);
        __tsan_release(&order->end);
    }
};

/// A body of parallel_reduce that is split and joined: `body` is the caller's, or one that this owns.
template<typename Body>
struct OrderedReduction {
    Order* order;
    std::unique_ptr<Body> own;
    Body* body;

    OrderedReduction(Body& from, Order* of) : order(of), body(&from) { __tsan_release(&order->begin); }
    OrderedReduction(OrderedReduction& from, split)
        : order(Order::after_copies(from.order)), own(std::make_unique<Body>(*from.body, split())), body(own.get())
    {
        __tsan_release(&order->begin);
    }

    template<typename Range>
    void operator()(Range&& range)
    {
        __tsan_acquire(&order->begin);
        (*body)(range);
        __tsan_release(&order->end);
    }
    void join(OrderedReduction& right)
    {
        __tsan_acquire(&order->end);
        body->join(*right.body);
        __tsan_release(&order->end);
    }
};

/// parallel_for(range, body, partitioner ...), and parallel_for(first, last, body) where `last` is a number.
template<typename First, typename Second, typename... Rest>
void ordered_parallel_for(const First& first, const Second& second, Rest&&... rest)
{
    Order order;
    if constexpr (std::is_arithmetic_v<Second>) {
        const auto& body = std::get<0>(std::tie(rest...));
        parallel_for(first, First(second), Ordered<std::decay_t<decltype(body)>>{body, &order});
    } else {
        parallel_for(first, Ordered<Second>{second, &order}, std::forward<Rest>(rest)...);
    }
    __tsan_acquire(&order.end);
}

/// parallel_reduce(range, body, partitioner ...). Other forms are as they were.
template<typename Range, typename Body, typename... Rest>
auto ordered_parallel_reduce(const Range& range, Body&& body, Rest&&... rest)
{
    if constexpr (std::is_lvalue_reference_v<Body> && !std::is_const_v<std::remove_reference_t<Body>> &&
                  std::is_constructible_v<std::decay_t<Body>, std::decay_t<Body>&, split>) {
        Order order;
        OrderedReduction<std::decay_t<Body>> ordered(body, &order);
        parallel_reduce(range, ordered, std::forward<Rest>(rest)...);
        __tsan_acquire(&order.end);
    } else {
        return parallel_reduce(range, std::forward<Body>(body), std::forward<Rest>(rest)...);
    }
}

}  // namespace tbb

#define parallel_for ordered_parallel_for
#define parallel_reduce ordered_parallel_reduce
