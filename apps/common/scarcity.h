#pragma once
// Exceptions that mean that the system gives no more memory or threads.

namespace vdbcloud::app {

/// The sentence for the current exception if it means that memory or threads are missing; else null. Call while
/// handling an exception. Takes no memory itself.
const char* scarcity() noexcept;

}  // namespace vdbcloud::app
