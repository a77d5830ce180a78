// Answer without limits, and the part of it that the limits leave after all.
#pragma once

#include "descent.hpp"
#include "race.hpp"
#include "resume.hpp"

TWISTARM_BEGIN

namespace detail {
/// The number of searches without limits before limits are excluded as the reason, and of roots after which none are
/// begun: six joints reach a pose in at most 16 ways.
constexpr int searches_without_limits = 48, most_searches_without_limits = 96, enough_roots = 48;
/// They are given more patience: a helical joint takes many turns to where it is wanted.
constexpr int iterations_without_limits = 60;
template <class T> constexpr T progress_without_limits = T(0.95);

template <class T> void exchange(T& a, T& b) {
    const T kept = a;
    a = b;
    b = kept;
}

/// Half the range of random starts of a coordinate without limits: 1 m where it slides anything, else π.
template <class T, int N, int M> T usual_half(const chain<T, N, M>& arm, int k) {
    T slide = T(0);
    for (int i = 0; i < arm.joints(); ++i)
        slide = greatest(slide, absolute(arm.coupling[i][k] * arm.links[i].slide));
    return slide > static_cast<T>(whole_turn_tolerance) ? T(1) / slide : static_cast<T>(0.5 * whole_turn);
}
}  // namespace detail

/// The ranges of the same chain without limits.
template <class T, int N, int M> ranges<T, N> without_limits(const chain<T, N, M>& arm, const ranges<T, N>& range) {
    ranges<T, N> free = range;
    free.all_turn = true;
    for (int k = 0; k < arm.coordinates(); ++k) {
        free.upper[k] = static_cast<T>(__builtin_inf());
        free.lower[k] = -free.upper[k];
        free.start_upper[k] = detail::usual_half(arm, k);
        free.start_lower[k] = -free.start_upper[k];
        free.turns[k] = range.periodic[k];
        free.all_turn = free.all_turn && free.turns[k];
    }
    return free;
}

/// θ with every periodic coordinate at its representative nearest to the middle of its limits, in them or not.
template <class T, int N> void bring_toward(const ranges<T, N>& range, int coordinates, T* theta) {
    for (int k = 0; k < coordinates; ++k) {
        if (!range.periodic[k]) continue;
        const double width = static_cast<double>(range.upper[k]) - static_cast<double>(range.lower[k]);
        const double here = static_cast<double>(theta[k]);
        const double middle = width < __builtin_inf() ? static_cast<double>(range.lower[k]) + 0.5 * width : here;
        theta[k] = static_cast<T>(here + whole_turn * __builtin_round((middle - here) / whole_turn));
    }
}

/// Configurations: where searches begin, then where they have ended.
template <class T, int N> struct searched {
    static constexpr int most = detail::most_searches_without_limits;

    T theta[most * capacity(N)];  ///< (count, n)
    bool converged[most];         ///< whether the search has reached its target
    int count;
};

namespace detail {
/// A search from each configuration, which its end replaces. They go in rounds of `searches_in_group`, so that the
/// number of lanes changes no answer; no round begins once enough have reached the target.
template <class V, class T, int N, class Stopped> struct searches_from_each final : search_owner<V, T, N> {
    static constexpr int lane_count = number<V>::lanes, none = -1;

    searched<T, N>& set;
    int n, enough;
    Stopped& stopped;
    int search[lane_count], begun = 0, end_of_round = 0, running = 0, solved = 0, nearest = 0;
    T least_error = static_cast<T>(__builtin_inf());

    searches_from_each(const aim<V>& aims, searched<T, N>& from, int size, int wanted, Stopped& time_is_up)
        : search_owner<V, T, N>(aims), set(from), n(size), enough(wanted), stopped(time_is_up) {
        for (int k = 0; k < set.count; ++k) set.converged[k] = false;
        for (int& slot : search) slot = none;
    }

    /// Gives the idle lanes the next searches of the round, or of the next one where none is running.
    void begin(lane_starts<T, N, lane_count>& starts) {
        const int most = solved > 0 ? set.count : least(set.count, searches_without_limits);
        if (running == 0 && solved < enough) end_of_round = least(begun + searches_in_group, most);
        for (int i = 0; i < lane_count && begun < end_of_round; ++i) {
            if (search[i] != none) continue;
            search[i] = begun++;
            ++running;
            for (int k = 0; k < n; ++k) starts.theta[k][i] = set.theta[search[i] * n + k];
            starts.waiting |= 1U << i;
        }
    }

    void collect(const lane_searches<V, N>& lanes, lane_starts<T, N, lane_count>& starts, unsigned ended,
                unsigned there) override {
        for (; ended != 0U; ended &= ended - 1U) {
            const int i = __builtin_ctz(ended), which = search[i];
            if (which == none) continue;
            search[i] = none;
            --running;
            for (int k = 0; k < n; ++k) set.theta[which * n + k] = lane(lanes.theta[k], i);
            set.converged[which] = (there >> i & 1U) != 0U;
            solved += set.converged[which] ? 1 : 0;
            if (lane(lanes.error, i) < least_error) {
                least_error = lane(lanes.error, i);
                nearest = which;
            }
        }
        begin(starts);
    }
    bool finished(const lane_searches<V, N>&) override { return running == 0 || stopped(); }
};

/// Runs a search from each configuration. If none meets the target, the nearest go on with more patience. Returns how
/// many have reached it; these come first.
template <target_kind Kind, class T, int N, int M, class Stopped>
int search_from_each_as(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                        const target<T>& asked, int enough, Stopped& stopped, searched<T, N>& set) {
    using V = pack<T, lanes_at_once<T, searches_in_round>>;
    const int n = arm.coordinates();
    searches_from_each<V, T, N, Stopped> owner(aim_in_every_lane<V>(aim_at(arm, asked)), set, n, enough, stopped);
    lane_searches<V, N> lanes = searches_at_rest<V, N>();
    lane_starts<T, N, number<V>::lanes> starts;
    owner.begin(starts);
    run_searches<V, Kind, T, N, M>(arm, range, settings, lanes, starts, owner);
    if (owner.solved == 0 && owner.least_error < on_its_way<T> && !stopped()) {
        resumed_ends<T, N> starts;
        take_nearest(arm, range, settings, asked, set.theta, owner.begun, starts);
        search_settings<T> how = patient(settings);
        solution<T, N> end{};
        for (int more = is_loose(settings) && !settings.to_edge; more >= 0 && !end.converged; --more, how.to_edge = true)
            race_from<Kind>(arm, range, how, asked, set.theta + owner.nearest * n, starts.theta[0], capacity(N), stopped, end);
        for (int k = 0; k < n && end.converged; ++k) set.theta[k] = end.theta[k];
        return end.converged ? 1 : 0;
    }
    int kept = 0;
    for (int r = 0; r < owner.begun; ++r) {
        if (!set.converged[r]) continue;
        for (int k = 0; k < n; ++k) set.theta[kept * n + k] = set.theta[r * n + k];
        ++kept;
    }
    return kept;
}

template <class T, int N, int M, class Stopped>
int search_from_each(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                     const target<T>& asked, int enough, Stopped& stopped, searched<T, N>& set) {
    int solved = 0;
    with_kind(asked, [&](auto kind) {
        solved = search_from_each_as<kind()>(arm, range, settings, asked, enough, stopped, set);
    });
    return solved;
}

/// ‖θ − clamped θ‖².
template <class T, int N> T squared_outside(const ranges<T, N>& range, int n, const T* theta) {
    T sum = T(0);
    for (int k = 0; k < n; ++k) {
        const T over = theta[k] - clamped(theta[k], range.lower[k], range.upper[k]);
        sum += over * over;
    }
    return sum;
}

/// The least outside the limits to the front, as many as there are lanes.
template <class T, int N> void sort_by_distance_outside(const ranges<T, N>& range, int n, searched<T, N>& roots) {
    for (int first = 0; first < roots.count && first < searches_in_group; ++first)
        for (int r = first + 1; r < roots.count; ++r) {
            T *here = roots.theta + first * n, *there = roots.theta + r * n;
            if (!(squared_outside(range, n, there) < squared_outside(range, n, here))) continue;
            for (int k = 0; k < n; ++k) exchange(here[k], there[k]);
        }
}
}  // namespace detail

/// Configurations that meet the target without limits, searched from `theta` (n,) and from random starts of `seed`. The
/// first root is the one that exceeds the limits least.
template <class T, int N, int M, class Stopped>
void meet_without_limits(const chain<T, N, M>& arm, const ranges<T, N>& range, search_settings<T> settings,
                         const target<T>& asked, const T* theta, std::uint64_t seed, int enough,
                         Stopped& stopped, searched<T, N>& roots) {
    const int n = arm.coordinates();
    settings.iterations = detail::iterations_without_limits;
    settings.progress = detail::progress_without_limits<T>;
    const ranges<T, N> free = without_limits(arm, range);
    roots.count = searched<T, N>::most;
    for (int k = 0; k < n; ++k) roots.theta[k] = theta[k];
    for (int r = 1; r < roots.count; ++r) random_start(free, n, seed, r, roots.theta + r * n);
    roots.count = detail::search_from_each(arm, free, settings, asked, enough, stopped, roots);
    for (int r = 0; r < roots.count; ++r) bring_toward(range, n, roots.theta + r * n);
    detail::sort_by_distance_outside(range, n, roots);
}

namespace detail {
/// Weight of a squared radian or metre outside the limits beside a squared metre, while a root is drawn inside.
template <class T> constexpr T outside_beside_position = T(0.1);
/// The weight ε of that cost. Without a second level it only decides when a descent has arrived.
template <class T> constexpr T drawn_inside_with = T(sizeof(T) == 8 ? 1e-6 : 1e-3);
template <class T> constexpr descent_settings<T> drawing_inside = {drawn_inside_with<T>, T(0), 20, false};

/// Draws each root toward the limits along the configurations that meet the target. The limits are open on the way:
/// least squares of both finds a corner of the limits if the target allows no more.
template <class T, int N, int M, class Stopped>
void draw_inside(const chain<T, N, M>& arm, const ranges<T, N>& range, const target<T>& asked, Stopped& stopped,
                 searched<T, N>& roots) {
    using V = pack<T, searches_in_group>;
    const int n = arm.coordinates();
    const ranges<T, N> free = without_limits(arm, range);
    two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked)), levels::both};
    objective.limits = &range;
    objective.nu = outside_beside_position<T> / drawn_inside_with<T>;
    for (int first = 0; first < roots.count && !stopped(); first += searches_in_group) {
        descent_lanes<V, N> lanes;
        lanes.epsilon = V(drawn_inside_with<T>);
        const auto root = [&](int l) { return roots.theta + (first + l < roots.count ? first + l : first) * n; };
        for (int l = 0; l < searches_in_group; ++l)
            for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], l, root(l)[k]);
        descend(objective, free, drawing_inside<T>, lanes, stopped);
        for (int l = 0; l < searches_in_group; ++l)
            for (int k = 0; k < n; ++k) root(l)[k] = lane(lanes.theta[k], l);
    }
    sort_by_distance_outside(range, n, roots);
}
}  // namespace detail

/// Tries to meet the target inside the limits: from the first root, from all roots drawn to the limits, and by searches
/// from the nearest of these. Replaces `found` if one succeeds.
template <class T, int N, int M, class Stopped>
void meet_inside(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                 const target<T>& asked, const T* theta0, searched<T, N> roots, Stopped& stopped,
                 solution<T, N>& found) {
    const int n = arm.coordinates();
    solution<T, N> inside = found;
    const auto is_answer = [&] {
        for (int k = 0; k < n; ++k) inside.theta[k] = roots.theta[k];
        if (judge(arm, range, settings, asked, theta0, inside)) found = inside;
        return inside.converged;
    };
    if (roots.count == 0 || is_answer()) return;
    detail::draw_inside(arm, range, asked, stopped, roots);
    roots.count = roots.count < searches_in_group ? roots.count : searches_in_group;
    for (int r = 0; r < roots.count; ++r) bring_inside(range, n, roots.theta + r * n);
    if (detail::search_from_each(arm, range, settings, asked, 1, stopped, roots) > 0) is_answer();
}

TWISTARM_END
