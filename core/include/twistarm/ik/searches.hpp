// Damped searches in lanes: each runs until it meets its target, stalls or has had its iterations.
#pragma once

#include "damped.hpp"

TWISTARM_BEGIN

/// In place of a clock: never up. What stops a call is anything with bool operator()(); true once, it stays true.
struct never {
    constexpr bool operator()() const { return false; }
};

/// An answer: θ inside the limits, and what it was checked to be.
template <class T, int N> struct solution {
    T theta[capacity(N)];
    T position_error, orientation_error;  ///< [m], [rad], counting only what the target constrains
    int iterations;  ///< of the search that won; of all of them where none did
    int restarts;    ///< searches begun; 1 where the first one won
    bool converged;
    T start_error;  ///< E (`run_searches`) at θ₀, inside the limits
};

/// What is found of a target that cannot be used (`is_usable`): θ₀ as it is, infinitely far, no search begun.
template <class T, int N> void find_nothing(const T* theta0, int n, solution<T, N>& found) {
    found = {};
    for (int k = 0; k < n; ++k) found.theta[k] = theta0[k];
    found.position_error = found.orientation_error = found.start_error = static_cast<T>(__builtin_inf());
}

/// How many ends of failed searches are kept, at most, for what comes after them.
constexpr int most_ends = 96;

/// One search in each lane. Everything of a lane is its own.
template <class V, int N> struct lane_searches {
    V theta[capacity(N)], position_squared, rotation_squared, error, first_error, best, stalls, iterations;
};

/// Lanes in which nothing runs yet; what stands there is worked on all the same, and never looked at.
template <class V, int N> TWISTARM_INLINE lane_searches<V, N> searches_at_rest() {
    const V zero = V(scalar_of<V>(0));
    lane_searches<V, N> lanes;
    for (V& coordinate : lanes.theta) coordinate = zero;
    lanes.position_squared = lanes.rotation_squared = lanes.error = lanes.first_error = zero;
    lanes.best = lanes.stalls = lanes.iterations = zero;
    return lanes;
}

/// Where a search begins that takes a lane over: written while others go on, put in place after their step.
template <class T, int N, int Lanes> struct lane_starts {
    T theta[capacity(N)][Lanes];
    unsigned waiting = 0;
};

namespace detail {
/// A search goes this much below the tolerances, so that the rounding of wrapped angles cannot undo its verdict.
constexpr double margin = 0.9;

/// Squared errors below which a search has met its target; the rotation's as a chord, 2 sin(φ/2), or an angle.
template <class T> struct thresholds {
    T position, rotation;
};

template <class T> thresholds<T> thresholds_of(const search_settings<T>& settings, target_kind kind) {
    const double position = margin * static_cast<double>(settings.position_tolerance);
    double angle = margin * static_cast<double>(settings.orientation_tolerance);
    if (angle > 3.14159265358979323846) angle = 3.14159265358979323846;
    const double rotation = kind == target_kind::task ? angle : 2.0 * __builtin_sin(0.5 * angle);
    return {static_cast<T>(position * position), static_cast<T>(rotation * rotation)};
}

template <class V, class T, int N>
TWISTARM_INLINE void begin_waiting(lane_searches<V, N>& lanes, lane_starts<T, N, number<V>::lanes>& starts, int n) {
    for (unsigned left = starts.waiting; left != 0U; left &= left - 1U) {
        const int i = __builtin_ctz(left);
        for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], i, starts.theta[k][i]);
        set_lane(lanes.best, i, static_cast<T>(__builtin_inf()));
        set_lane(lanes.stalls, i, T(0));
        set_lane(lanes.iterations, i, T(0));
    }
    starts.waiting = 0U;
}
}  // namespace detail

/// Whom searches are run for. One interface for a race and a batch, so that the searches are compiled once for both.
template <class V, class T, int N> struct search_owner {
    using starts = lane_starts<T, N, number<V>::lanes>;

    aim<V> aims;  ///< what each lane is after
    /// Hears which lanes have ended and which of them have met their target; may put new searches into `next`.
    virtual void settle(const lane_searches<V, N>& lanes, starts& next, unsigned ended, unsigned met) = 0;
    /// Asked after each evaluation; true ends the run.
    virtual bool finished(const lane_searches<V, N>& lanes) = 0;

protected:
    explicit search_owner(const aim<V>& asked) : aims(asked) {}
    ~search_owner() = default;
};

/// Runs searches until `owner` has what it wants. E = ‖position error‖² + rotation_weight ‖rotation error‖².
template <class V, target_kind Kind, class T, int N, int M>
void run_searches(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                  lane_searches<V, N>& lanes, lane_starts<T, N, number<V>::lanes>& starts,
                  search_owner<V, T, N>& owner) {
    const int n = arm.coordinates();
    const detail::thresholds<T> enough = detail::thresholds_of(settings, Kind);
    const T rotation_scale = sqrt(settings.rotation_weight);
    residual<V, N, rows_of(Kind)> at;
    column<V> columns[capacity(N)];
    detail::begin_waiting(lanes, starts, n);
    for (;;) {
        frame<V> g;
        walk_with_columns(arm, owner.aims.base, owner.aims.tip, lanes.theta, g, columns);
        residual_of<Kind, N>(g, columns, n, owner.aims, rotation_scale, at);
        lanes.position_squared = at.position_squared;
        lanes.rotation_squared = at.rotation_squared;
        lanes.error = at.position_squared + settings.rotation_weight * at.rotation_squared;
        const auto met = (at.position_squared <= V(enough.position)) & (at.rotation_squared <= V(enough.rotation));
        lanes.stalls = lanes.stalls + select(lanes.best * settings.progress < lanes.error, V(T(1)), V(T(0)));
        lanes.best = least(lanes.best, lanes.error);
        lanes.first_error = select(lanes.iterations < V(T(1)), lanes.error, lanes.first_error);
        const auto over = met | (lanes.stalls >= V(static_cast<T>(settings.stalls))) |
                          (lanes.iterations >= V(static_cast<T>(settings.iterations)));
        const unsigned ended = bits(over);
        if (ended != 0U) owner.settle(lanes, starts, ended, bits(met));
        if (owner.finished(lanes)) return;
        const V lambda = settings.damping * lanes.error + settings.least_damping;
        bounded_step(range, lambda, n, at, lanes.theta);
        lanes.iterations = lanes.iterations + T(1);
        if (starts.waiting != 0U) detail::begin_waiting(lanes, starts, n);
    }
}

/// The answer in a lane that has met its target: θ wrapped near `near`, and the errors of the evaluation at θ, which
/// whole turns change by rounding alone.
template <class V, class T, int N>
inline bool accept(const lane_searches<V, N>& lanes, int i, const ranges<T, N>& range, int n, target_kind kind,
                   const T* near, solution<T, N>& found) {
    for (int k = 0; k < n; ++k) found.theta[k] = lane(lanes.theta[k], i);
    wrap_near(range, n, near, found.theta);
    const T turned = sqrt(lane(lanes.rotation_squared, i));
    found.position_error = sqrt(lane(lanes.position_squared, i));
    found.orientation_error = kind == target_kind::task ? turned : T(2) * arcsine(T(0.5) * turned);
    found.iterations = static_cast<int>(lane(lanes.iterations, i));
    found.converged = is_inside(range, n, found.theta);
    return found.converged;
}

/// θ wrapped near `near` and judged anew by forward kinematics in scalars: whether it is an answer.
template <class T, int N, int M>
inline bool judge(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                  const target<T>& asked, const T* near, solution<T, N>& found) {
    const int n = arm.coordinates();
    wrap_near(range, n, near, found.theta);
    const target_errors<T> errors = errors_at(asked, forward(arm, found.theta));
    found.position_error = errors.position;
    found.orientation_error = errors.orientation;
    found.converged = errors.position <= settings.position_tolerance &&
                      errors.orientation <= settings.orientation_tolerance && is_inside(range, n, found.theta);
    return found.converged;
}

TWISTARM_END
