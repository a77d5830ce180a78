// Damped searches in lanes: each runs until it meets its target, stalls or has had its iterations.
#pragma once

#include "damped.hpp"

TWISTARM_BEGIN

/// In place of a clock: never up. What stops a call is anything with bool operator()(); true once, it stays true.
struct never {
    constexpr bool operator()() const { return false; }
};

/// Squared errors of a configuration: [m²], and the rotation's as its target measures it, chord² or [rad²].
template <class V> struct squared_errors {
    V position, rotation;
};

/// An answer: θ inside the limits, and what it was checked to be.
template <class T, int N> struct solution {
    T theta[capacity(N)];
    T position_error, orientation_error;  ///< [m], [rad], counting only what the target constrains
    int iterations;  ///< of the search that won; of all of them where none did
    int restarts;    ///< searches begun; 1 where the first one won
    bool converged;      ///< whether the errors are within the tolerances
    squared_errors<T> start_error;  ///< at θ₀, inside the limits
};

/// The result for a target that is not usable (`is_usable`): θ₀, infinite errors, no search begun.
template <class T, int N> void find_nothing(const T* theta0, int n, solution<T, N>& found) {
    found = {};
    for (int k = 0; k < n; ++k) found.theta[k] = theta0[k];
    found.position_error = found.orientation_error = static_cast<T>(__builtin_inf());
    found.start_error = {found.position_error, found.position_error};
}

/// Errors [m, rad] below which a search has reached its target, whatever is tolerated, and below which it needs no polish.
template <class T> constexpr T exact_error = T(sizeof(T) == 8 ? 1e-6 : 1e-5);
template <class T> constexpr T polished_error = T(sizeof(T) == 8 ? 1e-9 : 1e-6);

/// How many ends of failed searches are kept, at most, for what comes after them.
constexpr int most_ends = 96;

/// One search in each lane. Everything of a lane is its own.
template <class V, int N> struct lane_searches {
    V theta[capacity(N)], position_squared, rotation_squared, error, best, stalls, iterations;
    V reached;  ///< 1 where the search reached its target one step ago, and has been polished since
    squared_errors<V> first;
};

/// Idle lanes. Their contents are computed with the others and ignored.
template <class V, int N> TWISTARM_INLINE lane_searches<V, N> searches_at_rest() {
    const V zero = V(scalar_of<V>(0));
    lane_searches<V, N> lanes;
    for (V& coordinate : lanes.theta) coordinate = zero;
    lanes.position_squared = lanes.rotation_squared = lanes.error = lanes.first.position = lanes.first.rotation = zero;
    lanes.best = lanes.stalls = lanes.iterations = lanes.reached = zero;
    return lanes;
}

/// The start of a search that takes a lane over: written while others run, moved in after their step.
template <class T, int N, int Lanes> struct lane_starts {
    T theta[capacity(N)][Lanes];
    unsigned waiting = 0;
};

namespace detail {
/// Of a tolerance: what a search to its edge takes for no error, and what it then has to come within, so that the
/// rounding of wrapped angles cannot change its verdict.
constexpr double allowed = 0.999, edge = 0.9999;

/// Squared errors below which a search has reached its target; the rotation's as a chord, 2 sin(φ/2), or an angle.
template <class T> struct thresholds {
    T position, rotation;
};

/// An angle as a target of this kind measures its error: the chord 2 sin(φ/2), or the angle itself.
inline double measured(double angle, target_kind kind) {
    if (angle > 3.14159265358979323846) angle = 3.14159265358979323846;
    return kind == target_kind::task ? angle : 2.0 * __builtin_sin(0.5 * angle);
}

/// Whether the tolerances allow more than a search for the target itself leaves.
template <class T> bool is_loose(const search_settings<T>& settings) {
    return greatest(settings.position_tolerance, settings.orientation_tolerance) > exact_error<T>;
}

/// Takes out of an error what its loose tolerances allow; E of what is left.
template <target_kind Kind, class V, class T, int N, int K>
TWISTARM_INLINE V allow_tolerances(const search_settings<T>& settings, residual<V, N, K>& at, int n) {
    V left = at.position_squared;
    if (settings.position_tolerance > exact_error<T>)
        left = allow(at, 0, 3, static_cast<T>(allowed) * settings.position_tolerance, n);
    if constexpr (Kind == target_kind::position) return left;
    if (!(settings.orientation_tolerance > exact_error<T>))
        return left + settings.rotation_weight * at.rotation_squared;
    const double angle = measured(allowed * static_cast<double>(settings.orientation_tolerance), Kind);
    return left + allow(at, 3, K, sqrt(settings.rotation_weight) * static_cast<T>(angle), n);
}

/// The thresholds of errors within the tolerances and `enough`, or, for searches `to_edge`, within loose tolerances.
template <class T> thresholds<T> thresholds_of(const search_settings<T>& settings, target_kind kind, T enough) {
    const auto most = [&](T tolerance) {
        if (!settings.to_edge || tolerance <= exact_error<T>) return least(tolerance, enough);
        return static_cast<T>(edge) * tolerance;
    };
    const T position = most(settings.position_tolerance);
    const T rotation = static_cast<T>(measured(static_cast<double>(most(settings.orientation_tolerance)), kind));
    return {position * position, rotation * rotation};
}

template <class V, class T, int N>
TWISTARM_INLINE void begin_waiting(lane_searches<V, N>& lanes, lane_starts<T, N, number<V>::lanes>& starts, int n) {
    for (unsigned left = starts.waiting; left != 0U; left &= left - 1U) {
        const int i = __builtin_ctz(left);
        for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], i, starts.theta[k][i]);
        set_lane(lanes.best, i, static_cast<T>(__builtin_inf()));
        set_lane(lanes.stalls, i, T(0));
        set_lane(lanes.iterations, i, T(0));
        set_lane(lanes.reached, i, T(0));
    }
    starts.waiting = 0U;
}
}  // namespace detail

/// Whom searches are run for. One interface for a race and a batch, so that the searches are compiled once for both.
template <class V, class T, int N> struct search_owner {
    using starts = lane_starts<T, N, number<V>::lanes>;

    aim<V> aims;  ///< what each lane is after
    /// Receives the lanes that have ended and those that have reached their target. May put new searches into `next`.
    virtual void collect(const lane_searches<V, N>& lanes, starts& next, unsigned ended, unsigned reached) = 0;
    /// Asked after each evaluation; true ends the run.
    virtual bool finished(const lane_searches<V, N>& lanes) = 0;

protected:
    explicit search_owner(const aim<V>& asked) : aims(asked) {}
    ~search_owner() = default;
};

/// Runs searches until `owner` has what it wants. E = ‖position error‖² + rotation_weight ‖rotation error‖²; to the edge
/// of loose tolerances only what is beyond them. A search that has reached its target goes one step on.
template <class V, target_kind Kind, class T, int N, int M>
void run_searches(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                  lane_searches<V, N>& lanes, lane_starts<T, N, number<V>::lanes>& starts,
                  search_owner<V, T, N>& owner) {
    const int n = arm.coordinates();
    const detail::thresholds<T> enough = detail::thresholds_of(settings, Kind, exact_error<T>);
    const detail::thresholds<T> finest = detail::thresholds_of(settings, Kind, polished_error<T>);
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
        if (settings.to_edge) lanes.error = detail::allow_tolerances<Kind>(settings, at, n);
        const auto reached = (at.position_squared <= V(enough.position)) & (at.rotation_squared <= V(enough.rotation));
        lanes.stalls = lanes.stalls + select(lanes.best * settings.progress < lanes.error, V(T(1)), V(T(0)));
        lanes.best = least(lanes.best, lanes.error);
        const auto begins = lanes.iterations < V(T(1));
        lanes.first.position = select(begins, at.position_squared, lanes.first.position);
        lanes.first.rotation = select(begins, at.rotation_squared, lanes.first.rotation);
        const auto fine = (at.position_squared <= V(finest.position)) & (at.rotation_squared <= V(finest.rotation));
        const auto over = fine | (reached & (lanes.reached > V(T(0)))) | (lanes.stalls >= V(static_cast<T>(settings.stalls))) |
                          (lanes.iterations >= V(static_cast<T>(settings.iterations)));
        lanes.reached = select(reached, V(T(1)), V(T(0)));
        const unsigned ended = bits(over);
        if (ended != 0U) owner.collect(lanes, starts, ended, bits(reached));
        if (owner.finished(lanes)) return;
        const V lambda = settings.damping * lanes.error + settings.least_damping;
        bounded_step(range, lambda, n, at, lanes.theta);
        lanes.iterations = lanes.iterations + T(1);
        if (starts.waiting != 0U) detail::begin_waiting(lanes, starts, n);
    }
}

/// The squared errors in a lane.
template <class T, class V> TWISTARM_INLINE squared_errors<T> lane_of(const V& position, const V& rotation, int i) {
    return {lane(position, i), lane(rotation, i)};
}

namespace detail {
/// The errors of squared ones, as a target of this kind measures them.
template <class T, int N> void set_errors(const squared_errors<T>& squared, target_kind kind, solution<T, N>& found) {
    const T turned = sqrt(squared.rotation);
    found.position_error = sqrt(squared.position);
    found.orientation_error = kind == target_kind::task ? turned : T(2) * arcsine(T(0.5) * turned);
}

/// The most steps that polish an answer, and how many of them may gain nothing.
constexpr int most_polish = 20, polish_in_vain = 2;
}  // namespace detail

/// The answer in a lane that has reached its target: θ wrapped near `near`, and the errors computed before wrapping, which
/// changes them only by rounding.
template <class V, class T, int N>
inline bool accept(const lane_searches<V, N>& lanes, int i, const ranges<T, N>& range, int n, target_kind kind,
                   const T* near, solution<T, N>& found) {
    for (int k = 0; k < n; ++k) found.theta[k] = lane(lanes.theta[k], i);
    wrap_near(range, n, near, found.theta);
    detail::set_errors(lane_of<T>(lanes.position_squared, lanes.rotation_squared, i), kind, found);
    found.iterations = static_cast<int>(lane(lanes.iterations, i));
    found.converged = is_inside(range, n, found.theta);
    return found.converged;
}

/// Whether an answer meets the target itself, not only within loose tolerances.
template <class T, int N> bool is_exact(const solution<T, N>& found, const search_settings<T>& settings) {
    return found.converged && found.position_error <= least(settings.position_tolerance, exact_error<T>) &&
           found.orientation_error <= least(settings.orientation_tolerance, exact_error<T>);
}

/// Goes on from an answer that meets the target itself, by steps of a search, until its errors are those of rounding or
/// two steps have gained nothing. The best θ is wrapped near `near` (n,).
template <target_kind Kind, class T, int N, int M>
void polish_as(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* near, solution<T, N>& found) {
    if (greatest(found.position_error, found.orientation_error) <= polished_error<T>) return;
    const int n = arm.coordinates();
    const aim<T> aims = aim_at(arm, asked);
    const T rotation_scale = sqrt(settings.rotation_weight);
    residual<T, N, rows_of(Kind)> at;
    column<T> columns[capacity(N)];
    solution<T, N> moved = found;
    T theta[capacity(N)], best = static_cast<T>(__builtin_inf());
    for (int k = 0; k < n; ++k) theta[k] = found.theta[k];
    for (int step = 0, in_vain = 0; step <= detail::most_polish && in_vain < detail::polish_in_vain; ++step) {
        frame<T> g;
        walk_with_columns(arm, aims.base, aims.tip, theta, g, columns);
        residual_of<Kind, N>(g, columns, n, aims, rotation_scale, at);
        const T error = at.position_squared + settings.rotation_weight * at.rotation_squared;
        in_vain += !(error < settings.progress * best);
        if (error < best) {
            best = error;
            for (int k = 0; k < n; ++k) moved.theta[k] = theta[k];
            detail::set_errors({at.position_squared, at.rotation_squared}, Kind, moved);
        }
        if (greatest(moved.position_error, moved.orientation_error) <= polished_error<T>) break;
        bounded_step(range, settings.damping * error + settings.least_damping, n, at, theta);
    }
    wrap_near(range, n, near, moved.theta);
    if (is_inside(range, n, moved.theta)) found = moved;
}

/// The same for the kind of the target.
template <class T, int N, int M>
void polish(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
            const target<T>& asked, const T* near, solution<T, N>& found) {
    with_kind(asked, [&](auto kind) { polish_as<kind()>(arm, range, settings, asked, near, found); });
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

/// What is left of searches of which none has reached the target itself: their best end, `found`, or θ₀ (n,) if only that
/// is within the tolerances.
template <class T, int N, int M>
void judge_end(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, solution<T, N>& found) {
    if (judge(arm, range, settings, asked, theta0, found)) return;
    solution<T, N> start = found;
    for (int k = 0; k < arm.coordinates(); ++k) start.theta[k] = theta0[k];
    if (judge(arm, range, settings, asked, theta0, start)) found = start;
}

TWISTARM_END
