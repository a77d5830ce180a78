// The least value of a smooth function of many numbers, from its gradients.
//
// L-BFGS with steps that are shortened until the value falls: Nocedal & Wright, Numerical Optimization (2006), §7.2 and §3.5.
// Where none does it begins anew, along the gradient.
#pragma once

#include "lanes.hpp"

TWISTARM_BEGIN

namespace detail {
/// Pairs of steps and changes of the gradient that are remembered.
constexpr int remembered_steps = 8;

/// No step, and the first one nearly, moves any number farther than this.
template <class T> constexpr T longest_step = T(0.7);
template <class T> constexpr T first_step = T(0.3);

/// The part of the predicted decrease that is enough, the smallest part that a step is shortened to, and how often.
template <class T> constexpr T enough_fall = T(1e-4);
template <class T> constexpr T shortened_to = T(0.1);
constexpr int most_shortenings = 16;

template <class T> T inner(int n, const T* a, const T* b) {
    T sum = T(0);
    for (int i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

template <class T> T farthest(int n, const T* a) {
    T most = T(0);
    for (int i = 0; i < n; ++i)
        if (a[i] > most || -a[i] > most) most = a[i] > T(0) ? a[i] : -a[i];
    return most;
}

/// What is remembered of the last steps, the latest at `(count - 1) % remembered_steps`.
template <class T> struct step_memory {
    int n, count;
    T *steps, *changes, curvature[remembered_steps];

    T* step(int k) { return steps + (k % remembered_steps) * n; }
    T* change(int k) { return changes + (k % remembered_steps) * n; }
    int first() const { return count > remembered_steps ? count - remembered_steps : 0; }

    /// direction = −H gradient, H the inverse of the Hessian as the steps tell it.
    void direct(const T* gradient, T* direction) {
        T share[remembered_steps];
        for (int i = 0; i < n; ++i) direction[i] = -gradient[i];
        for (int k = count - 1; k >= first(); --k) {
            share[k % remembered_steps] = inner(n, step(k), direction) / curvature[k % remembered_steps];
            for (int i = 0; i < n; ++i) direction[i] -= share[k % remembered_steps] * change(k)[i];
        }
        const int last = count - 1;
        const T size = count ? curvature[last % remembered_steps] / inner(n, change(last), change(last))
                             : first_step<T> / farthest(n, gradient);
        for (int i = 0; i < n; ++i) direction[i] *= size;
        for (int k = first(); k < count; ++k) {
            const T back = inner(n, change(k), direction) / curvature[k % remembered_steps];
            for (int i = 0; i < n; ++i) direction[i] += (share[k % remembered_steps] - back) * step(k)[i];
        }
    }
};
}  // namespace detail

/// How many numbers `least_value` needs for n unknowns.
inline int least_value_room(int n) { return (2 * detail::remembered_steps + 4) * n; }

/// Moves x (n) to a nearby minimum of value_of(x, gradient): at most `most` steps, until one gains less than `gain`.
template <class T, class F> void least_value(int n, F&& value_of, T* x, int most, T gain, T* room) {
    T *gradient = room, *next = gradient + n, *there = next + n, *direction = there + n;
    detail::step_memory<T> memory{n, 0, direction + n, direction + n * (1 + detail::remembered_steps), {}};
    T value = value_of(x, gradient);
    for (int taken = 0; taken < most && detail::farthest(n, gradient) > T(0); ++taken) {
        memory.direct(gradient, direction);
        T slope = detail::inner(n, gradient, direction);
        if (!(slope < T(0))) {
            memory.count = 0;
            memory.direct(gradient, direction);
            slope = detail::inner(n, gradient, direction);
        }
        const T reach = detail::farthest(n, direction);
        T part = reach > detail::longest_step<T> ? detail::longest_step<T> / reach : T(1), fallen = T(0);
        for (int shortened = 0; shortened < detail::most_shortenings; ++shortened) {
            for (int i = 0; i < n; ++i) there[i] = x[i] + part * direction[i];
            fallen = value - value_of(there, next);
            if (fallen >= -detail::enough_fall<T> * part * slope) break;
            // To the lowest point of the parabola through what is known.
            const T lowest = T(0.5) * slope * part / (slope * part + fallen);
            part *= lowest > detail::shortened_to<T> ? lowest : detail::shortened_to<T>;
            fallen = T(0);
        }
        if (!(fallen > T(0))) {
            if (memory.count == 0) return;
            memory.count = 0;
            continue;
        }
        T* const step = memory.step(memory.count);
        T* const change = memory.change(memory.count);
        for (int i = 0; i < n; ++i) {
            step[i] = there[i] - x[i];
            change[i] = next[i] - gradient[i];
            x[i] = there[i];
            gradient[i] = next[i];
        }
        const T curvature = detail::inner(n, step, change);
        if (curvature > T(0)) memory.curvature[memory.count++ % detail::remembered_steps] = curvature;
        value -= fallen;
        if (fallen < gain) return;
    }
}

TWISTARM_END
