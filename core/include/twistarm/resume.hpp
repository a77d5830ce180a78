// Searches that have come near their target, resumed with more patience than a race has.
#pragma once

#include "searches.hpp"

TWISTARM_BEGIN

namespace detail {
/// Below this E a search was on its way: where the arm is near a singularity the last steps are many and short.
template <class T> constexpr T on_its_way = T(1e-3);
constexpr int patience = 200;  ///< iterations, and as many stalls

/// One search in each lane, until all have ended; the answer is that with the fewest iterations, then the lowest lane.
template <class V, class T, int N, class Stopped> struct resumed_searches final : search_owner<V, T, N> {
    static constexpr int lane_count = number<V>::lanes;

    const ranges<T, N>& range;
    const target<T>& asked;
    const T* theta0;
    int n;
    Stopped& stopped;
    solution<T, N>& found;
    unsigned running = (1U << lane_count) - 1U;

    resumed_searches(const aim<V>& aims, const ranges<T, N>& within, const target<T>& what, const T* start, int size,
                     Stopped& time_is_up, solution<T, N>& into)
        : search_owner<V, T, N>(aims), range(within), asked(what), theta0(start), n(size), stopped(time_is_up),
          found(into) {}

    void settle(const lane_searches<V, N>& lanes, lane_starts<T, N, lane_count>&, unsigned ended,
                unsigned met) override {
        for (unsigned left = ended & met & running; left != 0U && !found.converged; left &= left - 1U) {
            solution<T, N> candidate = found;
            if (accept(lanes, __builtin_ctz(left), range, n, asked.kind, theta0, candidate)) found = candidate;
        }
        running &= ~ended;
    }
    bool finished(const lane_searches<V, N>&) override { return running == 0U || found.converged || stopped(); }
};

/// The width [rad, m] in which the nearest end is shaken for the lanes that have none of their own.
template <class T> constexpr T shake = T(0.1);

template <class T, int N, int Lanes>
void shake_into(const ranges<T, N>& range, int n, int i, lane_starts<T, N, Lanes>& starts) {
    const start_sequence<N> sequence = sequence_of<N>(0, n);
    for (int k = 0; k < n; ++k) {
        const T part = spread<T>(sequence.shift[k], static_cast<std::uint64_t>(i), range.start_stride[k]);
        const T shaken = starts.theta[k][0] + shake<T> * (part - T(0.5));
        starts.theta[k][i] = range.turns[k] ? shaken : clamped(shaken, range.lower[k], range.upper[k]);
    }
}

/// The ends with the least E, eight of them, the nearest first; where there are fewer, the nearest is shaken.
template <class V, class T, int N, int M>
void take_nearest(const chain<T, N, M>& arm, const ranges<T, N>& range, const target<T>& asked, T weight, const T* ends,
                  int count, lane_starts<T, N, number<V>::lanes>& starts) {
    constexpr int lane_count = number<V>::lanes;
    T least[lane_count];
    int which[lane_count];
    int kept = 0;
    for (int e = 0; e < count; ++e) {
        const target_errors<T> errors = errors_at(asked, forward(arm, ends + e * arm.coordinates()));
        const T error = errors.position * errors.position + weight * errors.orientation * errors.orientation;
        int at = kept < lane_count ? kept++ : lane_count;
        for (; at > 0 && error < least[at - 1]; --at)
            if (at < lane_count) {
                least[at] = least[at - 1];
                which[at] = which[at - 1];
            }
        if (at == lane_count) continue;
        least[at] = error;
        which[at] = e;
    }
    for (int i = 0; i < kept; ++i)
        for (int k = 0; k < arm.coordinates(); ++k) starts.theta[k][i] = ends[which[i] * arm.coordinates() + k];
    for (int i = kept; i < lane_count; ++i) shake_into(range, arm.coordinates(), i, starts);
    starts.waiting = (1U << lane_count) - 1U;
}

template <target_kind Kind, class T, int N, int M, class Stopped>
void resume_as(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, const T* ends, int count, Stopped& stopped,
               solution<T, N>& found) {
    using V = pack<T, lanes_in_round>;
    search_settings<T> patient = settings;
    patient.iterations = patient.stalls = patience;
    lane_searches<V, N> lanes = searches_at_rest<V, N>();
    lane_starts<T, N, lanes_in_round> starts;
    take_nearest<V>(arm, range, asked, settings.rotation_weight, ends, count, starts);
    resumed_searches<V, T, N, Stopped> owner(aim_in_every_lane<V>(aim_at(arm, asked)), range, asked, theta0,
                                             arm.coordinates(), stopped, found);
    run_searches<V, Kind, T, N, M>(arm, range, patient, lanes, starts, owner);
}
}  // namespace detail

/// Goes on from the ends (count, n) of searches that failed, if `found`, the best of them, was on its way; `found` is
/// replaced where that meets the target.
template <class T, int N, int M, class Stopped>
void resume(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
            const target<T>& asked, const T* theta0, const T* ends, int count, Stopped& stopped,
            solution<T, N>& found) {
    const T error = found.position_error * found.position_error +
                    settings.rotation_weight * found.orientation_error * found.orientation_error;
    if (!(error < detail::on_its_way<T>)) return;
    const auto as = [&](auto kind) {
        detail::resume_as<kind()>(arm, range, settings, asked, theta0, ends, count, stopped, found);
    };
    switch (asked.kind) {
        case target_kind::pose: return as(std::integral_constant<target_kind, target_kind::pose>{});
        case target_kind::position: return as(std::integral_constant<target_kind, target_kind::position>{});
        case target_kind::approach: return as(std::integral_constant<target_kind, target_kind::approach>{});
        case target_kind::task: return as(std::integral_constant<target_kind, target_kind::task>{});
    }
}

TWISTARM_END
