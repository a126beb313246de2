#pragma once
// The horizontal wind where only one of its components is known. Private to sim/.
#include "vdbcloud/sim/air.h"

namespace vdbcloud::sim {

/// On the row (j, k) of faces of one horizontal component, the other one: the mean of the four faces around each.
/// Winds over the ground. Uniform ones are exact, and the Coriolis force does no work on periodic air.
template<typename T>
class CrossWind {
public:
    CrossWind(const Air<T>& air, int axis, int in, int j, int k)
    {
        const Variable<T>& wind = air.wind[size_t(1 - axis)];
        const Field<T>& other = wind.a[air.wind_at(in)];
        if (!other) return;
        frame_ = T(air.reference(wind.quantity));
        lower_ = other.row(j, k), upper_ = lower_ + other.stride(1 - axis);
        behind_ = air.lattice.flat(axis) ? 0 : other.stride(axis);
    }

    /// 0 along an axis of one cell, which has no wind.
    T at(int i) const
    {
        if (!lower_) return T(0);
        return frame_ + T(0.25) * ((lower_[i] + upper_[i]) + (lower_[i - behind_] + upper_[i - behind_]));
    }

private:
    const T *lower_ = nullptr, *upper_ = nullptr;
    T frame_ = 0;  // velocity of the box
    ptrdiff_t behind_ = 0;
};

/// A horizontal component over the ground at the centres of row (j, k): the mean of both faces of a cell.
template<typename T>
class CentredWind {
public:
    CentredWind(const Air<T>& air, int axis, int in, int j, int k)
    {
        const Variable<T>& v = air.wind[size_t(axis)];
        const Field<T>& wind = v.a[air.wind_at(in)];
        if (wind) lower_ = wind.row(j, k), upper_ = lower_ + wind.stride(axis), frame_ = T(air.reference(v.quantity));
    }
    T at(int i) const { return lower_ ? frame_ + T(0.5) * (lower_[i] + upper_[i]) : T(0); }

private:
    const T *lower_ = nullptr, *upper_ = nullptr;
    T frame_ = 0;
};

}  // namespace vdbcloud::sim
