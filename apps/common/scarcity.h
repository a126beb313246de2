#pragma once
// Exceptions that mean that the system gives no more memory or threads.
#include <string>

namespace vdbcloud::app {

/// The sentence for the current exception if it means that memory or threads are missing; else empty. Call while
/// handling an exception.
std::string scarcity() noexcept;

}  // namespace vdbcloud::app
