#pragma once
// Numbers of mathematics, written once.

namespace vdbcloud {

inline constexpr double pi = 3.14159265358979323846;
/// Turn between neighbours of a sunflower spiral [radians]: pi (3 - sqrt(5)).
inline constexpr double golden_angle = 2.399963229728653;

}  // namespace vdbcloud
