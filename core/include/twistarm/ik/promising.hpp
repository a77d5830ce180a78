// Promising starts: those on their way down to the nearest configuration that are worth following.
#pragma once

#include "descent.hpp"
#include "searches.hpp"

TWISTARM_BEGIN

namespace detail {
/// Numbers of starts in the search for the nearest: ends of searches and random configurations in all, the most
/// promising that are followed, and those followed to the end side by side. A position that leaves several joints free
/// has many local minima.
constexpr int most_starts = 112, most_followed = 32, most_finalists = 8;

/// Of the random starts among them.
constexpr std::uint64_t random_starts_seed = 1;

/// The first weights of a radian beside a square metre, from start to start. If the position can be reached, large ones
/// find minima with a small rotation error. If it cannot, the weight must not draw a start away from the nearest.
template <class T> constexpr T first_epsilons[4] = {T(1e-1), T(1e-3), T(1e-1), T(sizeof(T) == 8 ? 1e-9 : 1e-5)};

/// What the rotation counts in the choice of the most promising: less than where any of them stands.
template <class T> constexpr T rotation_in_choice = T(sizeof(T) == 8 ? 1e-7 : 1e-5);

/// Starts on their way down.
template <class T, int N> struct field_of_starts {
    T theta[most_starts * capacity(N)];  ///< (count, n)
    T position[most_starts], rotation[most_starts], epsilon[most_starts];  ///< as in `descent_lanes`
    int count;
};

/// Fills the field with random starts and gives each its first weight. Every fourth start is random too and looks
/// almost only for the position, because searches for a whole pose mostly end elsewhere.
template <class T, int N> void spread_out(const ranges<T, N>& range, int n, field_of_starts<T, N>& field) {
    for (int i = 0; i < most_starts; ++i) {
        if (i >= field.count || i % 4 == 3) random_start(range, n, random_starts_seed, i, field.theta + i * n);
        field.epsilon[i] = first_epsilons<T>[i % 4];
    }
    field.count = most_starts;
}

/// One start of `which` per lane. If fewer are `left`, the first is repeated.
template <class V, class T, int N>
void gather(const field_of_starts<T, N>& field, const int* which, int left, int n, descent_lanes<V, N>& lanes) {
    for (int l = 0; l < number<V>::lanes; ++l) {
        const int start = which[l < left ? l : 0];
        for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], l, field.theta[start * n + k]);
        set_lane(lanes.epsilon, l, field.epsilon[start]);
    }
}

template <class V, class T, int N>
void scatter(const descent_lanes<V, N>& lanes, const int* which, int left, int n, field_of_starts<T, N>& field) {
    for (int l = 0; l < left; ++l) {
        for (int k = 0; k < n; ++k) field.theta[which[l] * n + k] = lane(lanes.theta[k], l);
        field.position[which[l]] = lane(lanes.position, l);
        field.rotation[which[l]] = lane(lanes.rotation, l);
        field.epsilon[which[l]] = lane(lanes.epsilon, l);
    }
}

/// How near a start stands, the position first.
template <class T, int N> T nearness(const field_of_starts<T, N>& field, int i) {
    return field.position[i] + rotation_in_choice<T> * field.rotation[i];
}

/// The rotation f₂ that a start may reach at the least position f₁*: f₂ + 2 (f₁ − f₁*)/ε at a minimum of f₁ + ε f₂, to
/// first order in ε. It may still be on its way from √ε to ε.
template <class T, int N> T rotation_to_come(const field_of_starts<T, N>& field, T least_position, int i) {
    return field.rotation[i] + T(2) * (field.position[i] - least_position) / sqrt(field.epsilon[i]);
}

/// Whether two starts stand at the same minimum.
template <class T, int N> bool is_same(const field_of_starts<T, N>& field, int i, int j) {
    return absolute(field.position[i] - field.position[j]) <= T(1e-7) * (T(1e-3) + field.position[j]) &&
           absolute(field.rotation[i] - field.rotation[j]) <= T(1e-5) * (T(1e-1) + field.rotation[j]);
}

/// Appends to `chosen` (count,) at most `most` of the starts `from` with the least key(start), each minimum once.
template <class T, int N, class Key>
void choose(const field_of_starts<T, N>& field, const int* from, int candidates, int most, Key key, int* chosen,
            int& count) {
    T keys[most_starts];
    const int first = count;
    for (int c = 0; c < candidates; ++c) {
        const T here = key(from[c]);
        if (count == first + most && !(here < keys[count - 1])) continue;
        int same = 0;
        while (same < count && !is_same(field, from[c], chosen[same])) ++same;
        if (same < first || (same < count && !(here < keys[same]))) continue;
        if (same == count && count < first + most) ++count;
        int place = same < count ? same : count - 1;
        for (; place > first && here < keys[place - 1]; --place) {
            keys[place] = keys[place - 1];
            chosen[place] = chosen[place - 1];
        }
        keys[place] = here;
        chosen[place] = from[c];
    }
}

/// At most `most` promising starts of `from`: some are the nearest, the others may end with the least rotation error.
/// Returns their number.
template <class T, int N>
int most_promising(const field_of_starts<T, N>& field, const int* from, int candidates, int most, int* chosen) {
    T least_position = static_cast<T>(__builtin_inf());
    for (int c = 0; c < candidates; ++c) least_position = least(least_position, field.position[from[c]]);
    int count = 0;
    choose(field, from, candidates, 3 * most / 8, [&](int i) { return nearness(field, i); }, chosen, count);
    choose(field, from, candidates, most - count,
           [&](int i) { return rotation_to_come(field, least_position, i); }, chosen, count);
    return count;
}
}  // namespace detail

TWISTARM_END
