#pragma once
// The error for a value that cannot be used, in the one form that all such errors have.
#include "vdbcloud/core/error.h"

#include <sstream>
#include <string>

namespace vdbcloud {

/// Throws InputError "WHAT = VALUE: expected EXPECTED". `what` names the value and what it belongs to; `value` is
/// anything that a stream prints, cut and cleaned as text from a file is.
template<typename T>
[[noreturn]] void refuse(const std::string& what, const T& value, const std::string& expected)
{
    std::ostringstream text;
    text << value;
    throw InputError(what + " = " + printable(text.str()) + ": expected " + expected);
}

}  // namespace vdbcloud
