#pragma once
// --source and --collider: bodies and masks in the world of the files, from words or from .vdb files.
#include "options.h"

namespace vdbcloud::app {

/// The sources asked for, for a box of the preset. Reads files. Throws UsageError for words that are no source.
std::vector<sim::FieldSource> sources_of(App&, const Options&, const sim::Lattice&);

/// The bodies that air flows around. Throws UsageError for words that are no body, and for a file without a level set.
std::vector<std::shared_ptr<const sim::Shape>> colliders_of(App&, const Options&, const sim::Lattice&);

}  // namespace vdbcloud::app
