// Nearest configuration: the least position error, and with the position held, the least rotation error.
#pragma once

#include "nearest_to_start.hpp"

TWISTARM_BEGIN

namespace detail {
/// Minima from this many starts agree if the f of their rotations differs by a smaller part. In a sharp bend of a
/// valley, a second-order model promises too much, but several starts end at the same place.
constexpr int enough_agree = 2;
template <class T> constexpr T agreeing = T(1e-2);

/// Whether other starts lead to as little as `found` has.
template <class T, int N> bool is_agreed(const minimum<T, N>* minima, int count, const minimum<T, N>& found) {
    int others = 0;
    for (int i = 0; i < count; ++i) {
        bool fresh = minima[i].start >= 0 && minima[i].start != found.start;
        for (int j = 0; j < i && fresh; ++j) fresh = minima[j].start != minima[i].start;
        others += fresh && absolute(minima[i].distance - found.distance) <= same_position<T> &&
                  absolute(minima[i].rotation - found.rotation) <= agreeing<T> * found.rotation;
    }
    return others >= enough_agree;
}
}  // namespace detail

/// The best minimum inside the limits that the starts lead to: the least distance, then the least rotation error, then
/// the nearest to θ₀ (n,). Differences within the tolerances do not count.
///
/// Its rotation is also stationary if several starts agree. `field` holds the starts and is used up. The weight of the
/// position grows to 1/`last_epsilon`; at the end the position is minimised alone.
template <class V, class T, int N, int M, class Stopped>
void nearest_from(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                  const target<T>& asked, const T* theta0, detail::field_of_starts<T, N>& field, Stopped& stopped,
                  nearest_configuration<T, N>& found) {
    static_assert(detail::most_finalists == number<V>::lanes, "The finalists go side by side.");
    const two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked))};
    const int n = arm.coordinates();
    int all[detail::most_starts], chosen[detail::most_followed], last[detail::most_finalists];
    detail::spread_out(range, n, field);
    for (int i = 0; i < field.count; ++i) all[i] = i;
    const int begun = detail::follow(objective, range, detail::approaching<T>, all, field.count, field, stopped);
    const int followed = detail::most_promising(field, all, begun, detail::most_followed, chosen);
    if (!stopped()) detail::follow(objective, range, detail::following<T>, chosen, followed, field, stopped);
    int count = detail::most_promising(field, chosen, followed, detail::most_finalists, last);
    detail::minimum<T, N> minima[3 * detail::most_finalists];
    detail::finish(objective, range, detail::finishing<T>, last, count, field, stopped, minima);
    if (const int left = detail::not_converged(minima, count, last); left != 0 && !stopped()) {
        detail::finish(objective, range, detail::refining<T>, last, left, field, stopped, minima + count);
        count += left;
    }
    const detail::minimum<T, N>& best = detail::nearest_of(minima, count);
    found = best.at;
    if (stopped()) return;
    count += detail::draw_to(objective, range, theta0, best, field, stopped, minima + count);
    const detail::minimum<T, N>& closest = detail::nearest_to(arm, range, settings, asked, theta0, minima, count);
    found = closest.at;
    found.rotation_stationary = found.rotation_stationary || detail::is_agreed(minima, count, closest);
}

TWISTARM_END
