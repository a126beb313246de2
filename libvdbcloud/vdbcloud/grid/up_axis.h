#pragma once
// Which world axis points up: its word, its vector, its place in a file's metadata.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <optional>
#include <utility>

namespace vdbcloud {

/// The world axis that points up. The value of the enumerator is the index of the coordinate.
enum class UpAxis { Y = 1, Z = 2 };

/// The words for the axes, as metadata has them.
inline constexpr std::array<std::pair<const char*, UpAxis>, 2> up_axis_words{{{"Y", UpAxis::Y}, {"Z", UpAxis::Z}}};

/// "Y" or "Z".
const char* word(UpAxis);

/// The index of the coordinate that grows upwards.
constexpr int index_of(UpAxis up) { return static_cast<int>(up); }

/// Unit, world space.
Vec3d vector_of(UpAxis);

/// What schema::up_axis of a file says, in upper or lower case. Nothing without that metadata; nothing too for any
/// other word, as other programs use the key for words of their own.
/// Throws InputError if the metadata is not text.
std::optional<UpAxis> read_up_axis(const MetaMap&);
void write_up_axis(MetaMap&, UpAxis);

}  // namespace vdbcloud
