#pragma once
// Typed access to the metadata of files and grids.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud {

/// get_* return `otherwise` if the key is absent. Throw InputError if the value has an unsuitable type or is not
/// finite. set_* replace a value of any type.
double get_number(const MetaMap&, const std::string& key, double otherwise);
Vec3d get_vector(const MetaMap&, const std::string& key, const Vec3d& otherwise);
std::string get_text(const MetaMap&, const std::string& key, const std::string& otherwise);
bool has_meta(const MetaMap&, const std::string& key);
void set_number(MetaMap&, const std::string& key, double);
void set_vector(MetaMap&, const std::string& key, const Vec3d&);
void set_text(MetaMap&, const std::string& key, const std::string&);

}  // namespace vdbcloud
