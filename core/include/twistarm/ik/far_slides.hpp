// Slides without real limits, moved to where a far target is before the search.
//
// A search starts within about a metre of a slide's position and moves in limited steps. It cannot cover a kilometre.
#pragma once

#include "../numeric/ldl.hpp"
#include "levels.hpp"
#include "ranges.hpp"

TWISTARM_BEGIN

namespace detail {
/// A target beyond this [m] is far.
template <class T> constexpr T far_away = T(10);

/// Whether coordinate k only slides, farther than random starts go.
template <class T, int N, int M> bool slides_far(const chain<T, N, M>& arm, const ranges<T, N>& range, int k) {
    for (int i = 0; i < arm.joints(); ++i)
        if (arm.coupling[i][k] != T(0) && arm.links[i].turn != T(0)) return false;
    return range.lower[k] < range.start_lower[k] || range.upper[k] > range.start_upper[k];
}
}  // namespace detail

/// Moves the slides of θ (n,) without real limits, and the random starts of `range` with them, so that the tool comes
/// as near to the target as they can. The motion is the least one, −Vᵀ(V Vᵀ)⁻¹ e, which is exact for slides. Returns
/// whether the target was far and a slide moved farther than random starts reach.
template <class T, int N, int M>
bool bring_slides_near(const chain<T, N, M>& arm, const target<T>& asked, ranges<T, N>& range, T* theta) {
    const int n = arm.coordinates();
    const two_levels<T, T, N, M> objective{arm, asked.kind, aim_at(arm, asked)};
    local_errors<T, M> at;
    objective.look(theta, at);
    if (!(T(2) * at.position > detail::far_away<T> * detail::far_away<T>)) return false;
    T H[3][3] = {}, pull[3], V[capacity(N)][3] = {};
    bool moved = false;
    for (int k = 0; k < n; ++k) {
        if (!detail::slides_far(arm, range, k)) continue;
        for (int i = 0; i < arm.joints(); ++i)
            for (int a = 0; a < 3; ++a) V[k][a] += at.held[a] * arm.coupling[i][k] * at.moved[i].v[a];
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b <= a; ++b) H[a][b] += V[k][a] * V[k][b];
    }
    for (int a = 0; a < 3; ++a) {
        pull[a] = at.away[a];
        H[a][a] += T(sizeof(T) == 8 ? 1e-9 : 1e-5);
    }
    solve_ldl(H, pull, 3);
    for (int k = 0; k < n; ++k) {
        if (!detail::slides_far(arm, range, k)) continue;
        const T there = clamped(theta[k] - dot(V[k], pull), range.lower[k], range.upper[k]);
        const T half = T(0.5) * (range.start_upper[k] - range.start_lower[k]);
        moved = moved || absolute(there - theta[k]) > half;
        theta[k] = there;
        range.start_lower[k] = greatest(theta[k] - half, range.lower[k]);
        range.start_upper[k] = least(theta[k] + half, range.upper[k]);
    }
    if (moved) see_starts(arm, range);
    return moved;
}

TWISTARM_END
