#pragma once
// Mathematical constants.

namespace vdbcloud {

inline constexpr double pi = 3.14159265358979323846;
/// Angle between consecutive points of a Fibonacci (sunflower) spiral [radians]: pi (3 - sqrt(5)).
inline constexpr double golden_angle = 2.399963229728653;

}  // namespace vdbcloud
