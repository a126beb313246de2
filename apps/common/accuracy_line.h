#pragma once
// The line that tells people what bounds the error of a result.
#include "app.h"

#include "vdbcloud/grid/accuracy.h"

namespace vdbcloud::app {

/// Writes the figures into the metadata of a result and prints them: "accuracy of WHAT: residual 3e-07, ...".
void tell_accuracy(App&, const std::string& what, const Accuracy&, MetaMap& result);

}  // namespace vdbcloud::app
