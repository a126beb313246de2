#include "scarcity.h"

#include <cstring>
#include <exception>
#include <new>
#include <system_error>

namespace vdbcloud::app {

namespace {

constexpr const char* no_memory = "not enough memory for this; a smaller grid, or a higher limit, would do";
constexpr const char* no_thread = "not enough memory for another thread; --threads 1, or a higher limit, would do";

}  // namespace

const char* scarcity() noexcept
{
    try {
        if (std::current_exception()) throw;
    } catch (const std::bad_alloc&) {
        return no_memory;
    } catch (const std::system_error& error) {
        if (error.code() == std::errc::not_enough_memory) return no_memory;
        if (error.code() == std::errc::resource_unavailable_try_again) return no_thread;
    } catch (const std::exception& error) {
        if (std::strstr(error.what(), "pthread_create")) return no_thread;  // TBB has no type of its own for it
    } catch (...) {
        return nullptr;
    }
    return nullptr;
}

}  // namespace vdbcloud::app
