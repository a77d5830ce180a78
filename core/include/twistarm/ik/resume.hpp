// Resumed searches: those that came near their target, continued with more patience than a race has.
#pragma once

#include "race.hpp"

TWISTARM_BEGIN

namespace detail {
/// A search with a smaller E was on its way. Near a singularity the last steps are many and short.
template <class T> constexpr T on_its_way = T(1e-3);
constexpr int patience = 200;  ///< iterations, and as many stalls

constexpr int resumed = 8;       ///< ends that are gone on from

/// The width [rad, m] of the random shift of the nearest end, for lanes without an end.
template <class T> constexpr T shake = T(0.1);

/// Where searches are resumed, the nearest first.
template <class T, int N> struct resumed_ends {
    T theta[resumed][capacity(N)];
};

template <class T, int N> void shake_into(const ranges<T, N>& range, int n, int i, resumed_ends<T, N>& starts) {
    const start_sequence<N> sequence = sequence_of<N>(0, n);
    for (int k = 0; k < n; ++k) {
        const T part = spread<T>(sequence.shift[k], static_cast<std::uint64_t>(i), range.start_stride[k]);
        const T shaken = starts.theta[0][k] + shake<T> * (part - T(0.5));
        starts.theta[i][k] = range.turns[k] ? shaken : clamped(shaken, range.lower[k], range.upper[k]);
    }
}

/// E of errors: the squared position error plus the weighted rotation error; to the edge of tolerances, beyond them.
template <class T> T error_of(const search_settings<T>& settings, T position, T orientation) {
    if (settings.to_edge) {
        position = greatest(position - settings.position_tolerance, T(0));
        orientation = greatest(orientation - settings.orientation_tolerance, T(0));
    }
    return position * position + settings.rotation_weight * orientation * orientation;
}

/// The eight ends with the least E, the nearest first. If there are fewer, the nearest is shifted at random.
template <class T, int N, int M>
void take_nearest(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings, const target<T>& asked,
                  const T* ends, int count, resumed_ends<T, N>& starts) {
    T least[resumed];
    int which[resumed];
    int kept = 0;
    for (int e = 0; e < count; ++e) {
        const target_errors<T> errors = errors_at(asked, forward(arm, ends + e * arm.coordinates()));
        const T error = error_of(settings, errors.position, errors.orientation);
        int at = kept < resumed ? kept++ : resumed;
        for (; at > 0 && error < least[at - 1]; --at)
            if (at < resumed) {
                least[at] = least[at - 1];
                which[at] = which[at - 1];
            }
        if (at == resumed) continue;
        least[at] = error;
        which[at] = e;
    }
    for (int i = 0; i < kept; ++i)
        for (int k = 0; k < arm.coordinates(); ++k) starts.theta[i][k] = ends[which[i] * arm.coordinates() + k];
    for (int i = kept; i < resumed; ++i) shake_into(range, arm.coordinates(), i, starts);
}

/// A race of searches from `starts` (settings.searches, n). Replaces `found` if one of them meets the target.
template <target_kind Kind, int Lanes = 0, class T, int N, int M, class Stopped>
void race_from(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, const T* starts, int stride, Stopped& stopped,
               solution<T, N>& found) {
    const auto begins = [&](int search, T* theta, int step) {
        for (int k = 0; k < arm.coordinates(); ++k) theta[k * step] = starts[search * stride + k];
    };
    solution<T, N> raced{};
    T* nowhere = nullptr;
    using V = pack<T, Lanes != 0 ? Lanes : lanes_at_once<T, searches_in_round>>;
    if (!race_to<V, Kind>(arm, range, settings, asked, begins, theta0, nowhere, 0, stopped, raced)) return;
    raced.restarts = found.restarts;
    raced.start_error = found.start_error;
    found = raced;
}

/// The settings of searches that are resumed.
template <class T> search_settings<T> patient(search_settings<T> settings) {
    settings.searches = resumed;
    settings.iterations = settings.stalls = patience;
    settings.head_start = 0;
    return settings;
}
}  // namespace detail

/// What follows searches of which none has reached the target itself, from their ends (count, n), and `found`, the best.
///
/// If that was on its way, the nearest go on with more patience. If the target itself is still not reached, and nothing is
/// within the tolerances, searches from all ends look for their edge. Replaces `found` if one succeeds.
template <int Lanes = 0, class T, int N, int M, class Target, class Stopped>
void resume(const chain<T, N, M>& arm, const ranges<T, N>& range, search_settings<T> settings, const Target& asked,
            const T* theta0, const T* ends, int count, Stopped& stopped, solution<T, N>& found) {
    const auto on_its_way = [&] {
        return detail::error_of(settings, found.position_error, found.orientation_error) < detail::on_its_way<T>;
    };
    with_kind(asked, [&](auto kind) {
        if (on_its_way()) {
            detail::resumed_ends<T, N> starts;
            detail::take_nearest(arm, range, settings, asked, ends, count, starts);
            detail::race_from<kind(), Lanes>(arm, range, detail::patient(settings), asked, theta0, starts.theta[0],
                                             capacity(N), stopped, found);
        }
        settings.to_edge = true;
        settings.searches = count;
        if (!found.converged && detail::is_loose(settings) && on_its_way())
            detail::race_from<kind(), Lanes>(arm, range, settings, asked, theta0, ends, arm.coordinates(), stopped,
                                             found);
    });
}

/// `solve`, and where none of its searches meets the target itself, `resume`: every search that there is for a target.
template <int Lanes = 0, class T, int N, int M, class Target, class Stopped>
void search_all(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                const Target& asked, const T* theta0, std::uint64_t seed, Stopped& stopped, solution<T, N>& found) {
    const int n = arm.coordinates();
    T ends[most_ends * capacity(N)], start[capacity(N)];
    solve<Lanes>(arm, range, settings, asked, theta0, seed, found, ends, most_ends, stopped);
    if (is_exact(found, settings)) return;
    for (int k = 0; k < n; ++k) start[k] = theta0[k];
    bring_inside(range, n, start);
    const int count = found.restarts < most_ends ? found.restarts : most_ends;
    resume<Lanes>(arm, range, settings, asked, start, ends, count, stopped, found);
}

TWISTARM_END
