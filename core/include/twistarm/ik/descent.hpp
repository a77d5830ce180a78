// Newton's method inside the limits, in lanes, with the second level's weight lowered on the way.
#pragma once

#include "levels.hpp"
#include "newton.hpp"

TWISTARM_BEGIN

/// How far down a descent goes. Lengths and angles in m and rad.
template <class T> struct descent_settings {
    T last_epsilon;           ///< what the second level counts in the end
    T shift;                  ///< added to every curvature: what nothing holds stays where it is
    int iterations;
    bool solve_again;         ///< where a step is cut at a bound; surer in the end, and a third slower
    T longest_step = T(0.7);  ///< no coordinate moves farther in one step: beyond, the model is worth little
};

/// A descent in each lane. Everything of a lane is its own.
template <class V, int N> struct descent_lanes {
    V theta[capacity(N)];
    V position, rotation;  ///< ½ ‖position error‖² and f of the rotation error (`turning`) at θ
    V promise;             ///< what a Newton step from θ promises, twice the decrease of F
    V epsilon;             ///< what the second level counts, at first and as it is
};

namespace detail {
template <class T> constexpr T machine_epsilon = T(sizeof(T) == 8 ? 2.220446049250313e-16 : 1.1920929e-7F);

/// The weight of the second level is lowered, to its square, where a step promises less than `lowered_below` · ε.
template <class T> constexpr T lowered_below = T(0.01);
/// A descent ends if a step at the last weight promises less than this, in units of ε, or of 1 m² without a weight.
template <class T> constexpr T arrived = T(sizeof(T) == 8 ? 1e-13 : 1e-6);
template <class T> constexpr T arrived_without_weight = T(sizeof(T) == 8 ? 1e-26 : 1e-13);
/// A curvature below this share of the weight is flat.
template <class T> constexpr T flat = T(1e-3);
/// A step that leads uphill is tried again at a quarter, down to this.
template <class T> constexpr T least_fraction = T(1e-2);
/// The number of steps on the first level alone that lead a step back, and what they add to every curvature beyond the
/// error's own.
template <class T> constexpr T most_returns = T(2);
template <class T> constexpr T returning_shift = T(1e-4);
/// So many iterations pass between two looks at a clock.
constexpr int iterations_between_looks = 8;

/// What `descend` does, iteration by iteration.
template <class V, class T, int N, int M> struct descent {
    using truth = decltype(V() < V());

    const two_levels<V, T, N, M>& objective;
    const ranges<T, N>& range;
    const descent_settings<T>& settings;
    descent_lanes<V, N>& lanes;

    V trial[capacity(N)], step[capacity(N)];  ///< where to look next, and the step from θ, of which `fraction` is taken
    V value, fraction, returns;               ///< F at θ; steps back since a step led uphill
    V here[3], moved[3];                      ///< the tool's origin at θ, and what the step does to it to first order
    V held[3];                                ///< 1 for its components that are held at θ
    truth done;

    TWISTARM_INLINE void begin() {
        const V zero = V(T(0)), infinite = V(static_cast<T>(__builtin_inf()));
        for (int i = 0; i < objective.arm.coordinates(); ++i) {
            trial[i] = lanes.theta[i];
            step[i] = zero;
        }
        for (int k = 0; k < 3; ++k) here[k] = moved[k] = held[k] = zero;
        value = lanes.promise = infinite;
        fraction = V(T(1));
        returns = zero;
        done = fraction < zero;
    }

    /// Looks at the trial points and puts the next ones in their place.
    TWISTARM_INLINE void iterate() {
        const V zero = V(T(0));
        local_errors<V, M> at;
        objective.look(trial, at);
        const V there = objective.value(at, lanes.epsilon);
        const truth accepted = there <= value + T(4) * machine_epsilon<T> * absolute(there);
        const truth returning = (!accepted) & (returns < V(most_returns<T>)) & (fraction > zero);
        lower_weight(accepted);
        V d[capacity(N)];
        const V promised = step_from_trial(at, returning, d);
        keep(accepted, at, d, promised);
        fraction = select(accepted, V(T(1)), select(returning, fraction, T(0.25) * fraction));
        returns = select(returning, returns + T(1), zero);
        const truth stuck = fraction < V(least_fraction<T>);
        const V enough = arrived<T> * lanes.epsilon + arrived_without_weight<T>;
        done = done | ((lanes.epsilon <= V(settings.last_epsilon)) & (stuck | (accepted & (lanes.promise <= enough))));
        fraction = select(done | stuck, zero, fraction);
        set_trial(returning & (fraction > zero), d);
    }

  private:
    TWISTARM_INLINE void lower_weight(const truth& accepted) {
        const truth lower = accepted & ((lanes.promise <= lowered_below<T> * lanes.epsilon) | (fraction <= V(T(0))));
        const V next = greatest(lanes.epsilon * lanes.epsilon, V(settings.last_epsilon));
        lanes.epsilon = select(lower, least(lanes.epsilon, next), lanes.epsilon);
    }

    /// A Newton step on F, or on f₁ alone where the trial is led back.
    ///
    /// The weight of the path's curvature is the position error that the step from θ was to leave. At the end of a step
    /// along a bent valley, the actual error comes mostly from the bend and would give another valley.
    TWISTARM_INLINE V step_from_trial(local_errors<V, M>& at, const truth& returning, V* d) {
        const V epsilon = select(returning, V(T(0)), lanes.epsilon);
        const truth first = !(value < V(static_cast<T>(__builtin_inf())));
        V expected[3], left[3], pull[3];
        for (int k = 0; k < 3; ++k) expected[k] = here[k] + fraction * moved[k];
        objective.hold_at_edges(expected, at);
        objective.beyond(expected, left);
        for (int k = 0; k < 3; ++k) pull[k] = select(first, at.away[k], at.held[k] * held[k] * left[k]);
        quadratic_model<V, N> model;
        objective.slopes(at, epsilon, pull, model.g, model.H);
        const V shift = select(returning, V(returning_shift<T>), flat<T> * epsilon + settings.shift);
        return newton_step(range, trial, model, shift, settings.longest_step, settings.solve_again,
                           objective.arm.coordinates(), d);
    }

    /// The trial becomes θ where it is accepted, d the step from there.
    TWISTARM_INLINE void keep(const truth& accepted, const local_errors<V, M>& at, const V* d, const V& promised) {
        V there[3];
        objective.move(at, d, there);
        for (int k = 0; k < 3; ++k) {
            here[k] = select(accepted, at.p[k], here[k]);
            moved[k] = select(accepted, there[k], moved[k]);
            held[k] = select(accepted, at.held[k], held[k]);
        }
        value = select(accepted, objective.value(at, lanes.epsilon), value);
        lanes.position = select(accepted, at.position, lanes.position);
        lanes.rotation = select(accepted, at.rotation_level.value, lanes.rotation);
        lanes.promise = select(accepted, promised, lanes.promise);
        for (int i = 0; i < objective.arm.coordinates(); ++i) {
            lanes.theta[i] = select(accepted, trial[i], lanes.theta[i]);
            step[i] = select(accepted, d[i], step[i]);
        }
    }

    TWISTARM_INLINE void set_trial(const truth& returning, const V* d) {
        for (int i = 0; i < objective.arm.coordinates(); ++i) {
            trial[i] = select(returning, trial[i] + d[i], lanes.theta[i] + fraction * step[i]);
            if (!range.turns[i]) trial[i] = clamped(trial[i], V(range.lower[i]), V(range.upper[i]));
        }
    }
};
}  // namespace detail

/// Minimises F = f₁ + ε f₂ inside the limits from each lane's θ, ε lowered from where it is to the last.
///
/// A step that leads uphill has usually left the valley of f₁. At most `most_returns` steps on f₁ alone lead it back;
/// if they fail, a shorter step is tried. stopped() is called now and then; true ends the descent. Sources: D.
/// Bertsekas, Projected Newton methods for optimization problems with simple constraints, SIAM J. Control 20, 1982; J.
/// Nocedal & S. Wright, Numerical Optimization, 2nd ed., §17.1 (the weight) and §18.3 (second-order correction).
template <class V, class T, int N, int M, class Stopped>
__attribute__((noinline)) void descend(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range,
                                       const descent_settings<T>& settings, descent_lanes<V, N>& lanes,
                                       Stopped& stopped) {
    detail::descent<V, T, N, M> now{objective, range, settings, lanes, {}, {}, {}, {}, {}, {}, {}, {}, {}};
    now.begin();
    for (int left = settings.iterations; left > 0 && !all(now.done); --left) {
        now.iterate();
        if (left % detail::iterations_between_looks == 0 && stopped()) return;
    }
}

TWISTARM_END
