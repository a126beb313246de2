#pragma once
// The world axis that points up: as a word, as a vector, as file metadata.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/core/words.h"

#include <optional>

namespace vdbcloud {

/// The world axis that points up. The value of the enumerator is the index of the coordinate.
enum class UpAxis { Y = 1, Z = 2 };

/// The words for the axes in metadata. Options take them in lower case.
inline constexpr auto up_axis_words = words<UpAxis>("up axis", {{UpAxis::Y, "Y"}, {UpAxis::Z, "Z"}});

/// The index of the coordinate that increases upwards.
constexpr int index_of(UpAxis up) { return static_cast<int>(up); }

/// Unit vector in world space.
Vec3d vector_of(UpAxis);

/// The up axis in metadata schema::up_axis: "Y" or "Z", upper or lower case. Empty if the key is absent, or has any
/// other text, because other programs store other words under this key. Throws InputError if the metadata is not text.
std::optional<UpAxis> read_up_axis(const MetaMap&);
void write_up_axis(MetaMap&, UpAxis);

}  // namespace vdbcloud
