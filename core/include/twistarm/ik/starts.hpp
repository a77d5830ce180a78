// Which random starts the searches for a pose begin at: first those near it.
#pragma once

#include "ranges.hpp"

TWISTARM_BEGIN

constexpr int near_starts = 8;

/// Searches 1, 2, … begin at the starts of seed 0 that `near` lists, then at those that nobody has seen.
struct start_order {
    int near[near_starts];
    int operator[](int search) const { return search <= near_starts ? near[search - 1] : seen_starts + search - near_starts; }
};

/// Each of `near` is the nearest of an eighth of the starts seen, by ‖p − p_goal‖² + rotation_weight (3 − tr RᵀR_goal).
template <class T, int N>
start_order order_of_starts(const ranges<T, N>& range, const frame<T>& goal, T rotation_weight) {
    using row = pack<float, near_starts>;
    row least = row(__builtin_inff()), which = row(0.0F), rank = row(0.0F), wanted[12];
    T rows[16];
    frame_to_rows(goal, rows);
    for (int r = 0; r < 12; ++r) wanted[r] = row(static_cast<float>(r % 4 == 3 ? rows[r] : rotation_weight * rows[r]));
    for (int s = 0; s < seen_starts; s += near_starts) {
        row off = row(0.0F), there[12];
        TWISTARM_UNROLL
        for (int i = 0; i < 3; ++i) {
            TWISTARM_UNROLL
            for (int r = 4 * i; r < 4 * i + 4; ++r) {
                __builtin_memcpy(&there[r], &range.seen[r][s], sizeof there[r]);
                off = r % 4 == 3 ? off + (there[r] - wanted[r]) * (there[r] - wanted[r]) : off - there[r] * wanted[r];
            }
        }
        const auto nearer = off < least;
        least = select(nearer, off, least);
        which = select(nearer, row(static_cast<float>(s + 1)), which);
    }
    for (int l = 0; l < near_starts; ++l) rank = rank + select(row(lane(least, l)) < least, row(1.0F), row(0.0F));
    start_order order{};  // of equals one is left out, and start 0 takes its place
    for (int l = 0; l < near_starts; ++l) order.near[static_cast<int>(lane(rank, l))] = static_cast<int>(lane(which, l)) + l;
    return order;
}

TWISTARM_END
