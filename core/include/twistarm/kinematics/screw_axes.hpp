// A twist as the axis, the turn and the slide of a joint.
#pragma once

#include "frame.hpp"

TWISTARM_BEGIN

/// A joint's twist ξ = (v, w): exp(ξ̂ x) = B Rz(turn x) Tz(slide x) B⁻¹ with B = `axis` and its z along the screw axis.
struct screw_axis {
    frame<double> axis;
    double turn, slide;
};

namespace detail {
/// Below this [rad/rad, m/rad] a component of a twist is the rounding of none.
constexpr double no_motion = 1e-12;

inline double length(const double v[3]) { return sqrt(dot(v, v)); }

/// The length of a direction. It is exactly 1 if that is so to rounding, because a joint may turn far.
inline double length_of_axis(const double v[3]) {
    const double size = length(v);
    return absolute(size - 1.0) <= 1e-15 ? 1.0 : size;
}

/// The rotation of g completed to right-handed orthonormal axes from its unit z.
inline void complete(frame<double>& g) {
    int smallest = 0;
    for (int k = 1; k < 3; ++k)
        if (absolute(g.z[k]) < absolute(g.z[smallest])) smallest = k;
    const double unit[3] = {smallest == 0 ? 1.0 : 0.0, smallest == 1 ? 1.0 : 0.0, smallest == 2 ? 1.0 : 0.0};
    cross(unit, g.z, g.x);
    const double size = length(g.x);
    for (double& component : g.x) component /= size;
    cross(g.z, g.x, g.y);
}
}  // namespace detail

/// The axis of ξ = (v, w), its origin the point nearest to `near` (3,) [m], so that offsets stay small.
///
/// turn = ‖w‖, slide = wᵀv/‖w‖, a point of the axis w × v/‖w‖². Without w: turn 0, slide ‖v‖, through `near`.
/// Source: MLS §2.3.3.
inline screw_axis screw_axis_of(const double v[3], const double w[3], const double near[3]) {
    screw_axis screw{identity_frame<double>(), detail::length_of_axis(w), 0.0};
    const bool turns = screw.turn > detail::no_motion;
    const double* direction = turns ? w : v;
    const double size = detail::length_of_axis(direction);
    for (int k = 0; k < 3; ++k) screw.axis.p[k] = near[k];
    if (size <= detail::no_motion) return {identity_frame<double>(), 0.0, 0.0};
    for (int k = 0; k < 3; ++k) screw.axis.z[k] = direction[k] / size;
    detail::complete(screw.axis);
    if (!turns) {
        screw.turn = 0.0;
        screw.slide = size;
        return screw;
    }
    screw.slide = dot(w, v) / size;
    if (absolute(screw.slide) <= detail::no_motion * size) screw.slide = 0.0;
    double point[3];
    cross(w, v, point);
    double along = 0.0;
    for (int k = 0; k < 3; ++k) along += screw.axis.z[k] * (near[k] - point[k] / (size * size));
    for (int k = 0; k < 3; ++k) screw.axis.p[k] = point[k] / (size * size) + screw.axis.z[k] * along;
    return screw;
}

TWISTARM_END
