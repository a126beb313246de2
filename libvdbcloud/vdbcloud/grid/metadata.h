#pragma once
// Typed access to the metadata of files and grids.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// get_* return `otherwise` if the key is absent. A value of an unsuitable type, one that is not finite, or one out of
/// the key's range (schema::meta_keys()) is refused by InputError, which names the grid if the map is a grid's; under a
/// key that other programs write too it is passed over instead, as if absent (passed_over()). set_* replace a value of
/// any type.
double get_number(const MetaMap&, const std::string& key, double otherwise);
Vec3d get_vector(const MetaMap&, const std::string& key, const Vec3d& otherwise);
std::string get_text(const MetaMap&, const std::string& key, const std::string& otherwise);
/// Finite numbers of a text, separated by blanks; none if the key is absent.
std::vector<double> get_numbers(const MetaMap&, const std::string& key);
/// "grid 'phi': metadata 'KEY'": for messages.
std::string meta_name(const MetaMap&, const std::string& key);
bool has_meta(const MetaMap&, const std::string& key);
void set_number(MetaMap&, const std::string& key, double);
void set_vector(MetaMap&, const std::string& key, const Vec3d&);
void set_text(MetaMap&, const std::string& key, const std::string&);
/// Text that get_numbers() reads as the same doubles.
void set_numbers(MetaMap&, const std::string& key, const std::vector<double>&);

/// A sentence "metadata 'KEY' = VALUE is passed over: expected ..." for each key of a file's metadata that other
/// programs write too and whose value get_*() pass over. Sorted by key.
std::vector<std::string> passed_over(const MetaMap& file_metadata);

}  // namespace vdbcloud
