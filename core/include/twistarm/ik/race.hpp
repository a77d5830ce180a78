// Race of searches for one target: several starts in the lanes, and the rule that chooses the winner.
#pragma once

#include "searches.hpp"
#include "starts.hpp"

TWISTARM_BEGIN

/// Searches in a round of a race, on every instruction set.
constexpr int searches_in_round = 4;

namespace detail {
/// The searches of one target. Search 0 begins at θ₀ or where it is resumed, search k where `Starts` puts it. Round r
/// has the searches 4 r to 4 r + 3.
///
/// The winner is search 0 if it converges in its head start. Otherwise it is in the first round in which a search
/// converges: the one with the fewest iterations, then the lowest number. A free lane takes the next search of any
/// round at once. A search depends on its start alone, so the winner is the same in every order.
template <class V, class T, int N, int M, class Starts, class Stopped> struct race_of_one final : search_owner<V, T, N> {
    static constexpr int lane_count = number<V>::lanes;
    static constexpr int none = -1;
    static constexpr int looks_for_a_clock = 8;  ///< a clock costs a tenth of an iteration

    const chain<T, N, M>& arm;
    const ranges<T, N>& range;
    const search_settings<T>& settings;
    const target<T>& asked;
    const Starts& begins;  ///< begins(k, theta, stride) writes the start of search k
    const T* theta0;
    solution<T, N>& found;
    T* ends;   ///< (room, n): where those that failed ended; nullptr if nobody asks
    int room;  ///< for the ends of so many searches, the first
    Stopped& stopped;

    int search[lane_count] = {};
    unsigned fresh = 0;  ///< lanes whose search has not been looked at yet: their iterations are another's
    int begun = 0, iterations = 0, winner = none, looks = 0;
    T least_error = static_cast<T>(__builtin_inf());
    squared_errors<T> start_error = {least_error, least_error};
    bool over = false;

    race_of_one(const chain<T, N, M>& chain, const ranges<T, N>& within, const search_settings<T>& how,
                const target<T>& what, const Starts& from, const T* start, solution<T, N>& into, T* failed_ends,
                int failed_room, Stopped& time_is_up)
        : search_owner<V, T, N>(aim_in_every_lane<V>(aim_at(chain, what))), arm(chain), range(within), settings(how),
          asked(what), begins(from), theta0(start), found(into), ends(failed_ends), room(failed_room),
          stopped(time_is_up) {}

    static constexpr int round_of(int k) { return k / searches_in_round; }
    bool in_head_start(int k, int steps) const { return k == 0 && steps <= settings.head_start; }

    /// Whether search k would win with `steps` iterations.
    bool beats(int k, int steps) const {
        if (winner == none || in_head_start(k, steps)) return true;
        if (in_head_start(winner, found.iterations)) return false;
        if (round_of(k) != round_of(winner)) return round_of(k) < round_of(winner);
        return steps < found.iterations || (steps == found.iterations && k < winner);
    }

    void begin(lane_starts<T, N, lane_count>& starts, int i) {
        search[i] = none;
        if (begun >= settings.searches || !beats(begun, 0)) return;
        search[i] = begun++;
        begins(search[i], &starts.theta[0][i], lane_count);
        starts.waiting |= 1U << i;
        fresh |= 1U << i;
    }

    void failed(const lane_searches<V, N>& lanes, int i) {
        const T error = lane(lanes.error, i);
        const bool keep = winner == none && error < least_error;
        if (keep) least_error = error;
        for (int k = 0; k < arm.coordinates(); ++k) {
            const T theta = lane(lanes.theta[k], i);
            if (keep) found.theta[k] = theta;
            if (ends != nullptr && search[i] < room) ends[search[i] * arm.coordinates() + k] = theta;
        }
    }

    bool converged(const lane_searches<V, N>& lanes, int i) {
        solution<T, N> candidate{};
        if (!accept(lanes, i, range, arm.coordinates(), asked.kind, theta0, candidate)) return false;
        found = candidate;
        winner = search[i];
        return true;
    }

    void collect(const lane_searches<V, N>& lanes, lane_starts<T, N, lane_count>& starts, unsigned ended,
                unsigned reached) override {
        for (; ended != 0U; ended &= ended - 1U) {
            const int i = __builtin_ctz(ended), steps = static_cast<int>(lane(lanes.iterations, i));
            if (search[i] == none) continue;
            iterations += steps;
            if (beats(search[i], steps) && !((reached >> i & 1U) != 0U && converged(lanes, i))) failed(lanes, i);
            begin(starts, i);
        }
        over = true;
        for (int i = 0; i < lane_count; ++i) over = over && search[i] == none;
    }

    /// Searches that are still running fail where they are.
    void cut_short(const lane_searches<V, N>& lanes) {
        over = true;
        for (int i = 0; i < lane_count; ++i)
            if (search[i] != none) failed(lanes, i);
    }

    /// The fewest iterations with which the search in a lane can still converge.
    int least_steps(const lane_searches<V, N>& lanes, int i, unsigned unseen) const {
        return (unseen >> i & 1U) != 0U ? 0 : static_cast<int>(lane(lanes.iterations, i)) + 1;
    }

    /// The race is over if no running or later search can win, or the time is up.
    bool finished(const lane_searches<V, N>& lanes) override {
        const unsigned unseen = fresh;
        fresh = 0U;
        if (looks == 0) start_error = lane_of<T>(lanes.position_squared, lanes.rotation_squared, 0);
        if (++looks % looks_for_a_clock == 0 && stopped()) cut_short(lanes);
        if (winner == none || over) return over;
        if (begun < settings.searches && beats(begun, 0)) return false;
        for (int i = 0; i < lane_count; ++i)
            if (search[i] != none && beats(search[i], least_steps(lanes, i, unseen))) return false;
        return true;
    }
};

/// Runs the race. `found` is the winner, or else what `failed` has put there. Returns whether there is a winner.
template <class V, target_kind Kind, class T, int N, int M, class Starts, class Stopped>
bool race_to(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
             const target<T>& asked, const Starts& begins, const T* theta0, T* ends, int room, Stopped& stopped,
             solution<T, N>& found) {
    race_of_one<V, T, N, M, Starts, Stopped> race(arm, range, settings, asked, begins, theta0, found, ends, room,
                                                  stopped);
    lane_searches<V, N> lanes = searches_at_rest<V, N>();
    lane_starts<T, N, number<V>::lanes> starts;
    for (int i = 0; i < number<V>::lanes; ++i) race.begin(starts, i);
    run_searches<V, Kind, T, N, M>(arm, range, settings, lanes, starts, race);
    const bool won = race.winner != race.none;
    if (won && !settings.to_edge) polish_as<Kind>(arm, range, settings, asked, theta0, found);
    found.restarts = race.winner == 0 ? 1 : race.begun;
    found.start_error = race.start_error;
    if (!won) found.iterations = race.iterations;
    return won;
}
}  // namespace detail

/// Inverse kinematics of one target of this kind, with at most settings.searches ≥ 1 searches. The first starts from
/// `theta0` (n,) inside the limits, the others from random starts of `seed` (`start_order`). Equal calls give equal bits. `Lanes`
/// searches run side by side, by default as many as a register holds; the number changes no answer.
///
/// Each search aims at the target itself, and the answer is polished. If none meets it, `found` is the end with the
/// least error, which may be within the tolerances. `ends` (room, n), if not null, takes the ends of the first failed searches; all of them without a winner.
/// stopped() is called now and then; true ends the searches.
template <target_kind Kind, int Lanes = 0, class T, int N, int M, class Stopped>
void solve_kind(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                const target<T>& asked, const T* theta0, std::uint64_t seed, solution<T, N>& found, T* ends, int room,
                Stopped& stopped) {
    constexpr int lanes = Lanes != 0 ? Lanes : lanes_at_once<T, searches_in_round>;
    const int n = arm.coordinates();
    T start[capacity(N)];
    for (int k = 0; k < n; ++k) start[k] = found.theta[k] = theta0[k];
    bring_inside(range, n, start);
    const start_sequence<N> sequence = sequence_of<N>(seed, n);
    const bool near_first = Kind == target_kind::pose && seed == 0;
    const start_order order = near_first ? order_of_starts(range, asked.goal, settings.rotation_weight) : start_order{};
    const auto begins = [&](int search, T* theta, int stride) {
        if (search > 0) return start_at(range, n, sequence, near_first ? order[search] : search, theta, stride);
        for (int k = 0; k < n; ++k) theta[k * stride] = start[k];
    };
    if (detail::race_to<pack<T, lanes>, Kind>(arm, range, settings, asked, begins, start, ends, room, stopped, found))
        return;
    judge_end(arm, range, settings, asked, start, found);
}

/// The same for the kind of the target's type. A plain target<T> may have any kind and compiles all four solvers.
template <int Lanes = 0, class T, int N, int M, class Target, class Stopped>
void solve(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
           const Target& asked, const T* theta0, std::uint64_t seed, solution<T, N>& found, T* ends, int room,
           Stopped& stopped) {
    with_kind(asked, [&](auto kind) {
        solve_kind<kind(), Lanes>(arm, range, settings, asked, theta0, seed, found, ends, room, stopped);
    });
}

/// The same without a clock; `ends` (settings.searches, n) or null.
template <int Lanes = 0, class T, int N, int M, class Target>
void solve(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
           const Target& asked, const T* theta0, std::uint64_t seed, solution<T, N>& found, T* ends = nullptr) {
    never stopped;
    solve<Lanes>(arm, range, settings, asked, theta0, seed, found, ends, settings.searches, stopped);
}

TWISTARM_END
