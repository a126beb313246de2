#pragma once
// The line that tells people what bounds the error of a result.
#include "app.h"

#include "vdbcloud/grid/accuracy.h"

namespace vdbcloud::app {

/// Writes the figures into the metadata of a result and prints them: "accuracy of WHAT: residual 3e-07, ...".
void tell_accuracy(App&, const std::string& what, const Accuracy&, MetaMap& result);

/// Prints the figures in the metadata of a grid that was read; nothing if it has none. Returns the text.
std::string repeat_accuracy(App&, const std::string& what, const MetaMap& read);

}  // namespace vdbcloud::app
