// Servo step: a pure function from a command to joint rates.
//
// The bounds of an arm stand in the header that `twistarm bake -o FILE.hpp` writes, beside its chain:
//
//     twistarm::servo_state<double, 6> state{};  // at rest, where the arm was measured to be
//     for (int k = 0; k < 6; ++k) state.theta[k] = measured[k];
//     twistarm::servo_command<double, 6> command{};
//     command.kind = twistarm::servo_kind::twist;
//     command.twist[0] = 0.05;                                     // m/s along the tool's x
//     command.held[3] = command.held[4] = command.held[5] = true;  // as it is turned now
//     twistarm::servo_output<double> out;
//     twistarm::servo_step(arm, bounds, command, 0.01, state, out);  // every 10 ms
//     send(state.theta, state.theta_dot);
#pragma once

#include "resolved_rates.hpp"

TWISTARM_BEGIN

enum class servo_kind { none = 0, jog = 1, twist = 2, pose = 3 };

/// What holds the arm back most.
/// unusable: the command, dt or the state is not finite, or dt not positive; the arm comes to rest, with a bad dt or state at once.
enum class servo_cause { none = 0, singularity = 1, velocity = 2, lower = 3, upper = 4, unusable = 5, near = 6 };

/// What to do: joint rates; a twist (v, w) in tool axes or (dp/dt, ω) in base axes, some components held; or a pose.
///
/// twist: of a pose, how the pose itself moves. Speeds [m/s, rad/s] bound the way to a pose.
template <class T, int N> struct servo_command {
    servo_kind kind;
    bool base_axes, held[6];
    T rates[capacity(N)], twist[6];
    frame<T> goal;
    T linear_speed, angular_speed;
};

/// Where the commanded arm is and how it moves; the pose of which some components are held, along which axes. period [s]:
/// what steps took of late, 0 at the start.
template <class T, int N> struct servo_state {
    T theta[capacity(N)], theta_dot[capacity(N)], period;
    bool holding[6], holding_base_axes;
    frame<T> held;
};

/// Pairs of bodies that come near each other: pair i approaches by rows[i] · rates [m/s], and may by room[i] [m] yet;
/// a room below 0 moves it apart. It may take its room within time[i] [s], 0: as a joint takes that to its limit.
template <class T, int N> struct near_pairs {
    int count;
    T rows[most_half_spaces][capacity(N)], room[most_half_spaces], time[most_half_spaces];
};

/// row: of the limits or near pairs that cause it, or the joint that a singularity concerns, −1 for none. At an even speed the tool moves
/// by scale · (asked − lost); lost_share: |lost| / |asked|, scaled. remaining: how far a pose to reach is [m, rad].
template <class T> struct servo_output {
    servo_cause cause;
    int row;
    T scale, lost[6], lost_share, remaining[2];
    bool halted;
};

namespace servo_detail {
constexpr double halted_below = 3e-2;  // rates below this share of the command's are a standstill
template <class T> constexpr T rounding = T(sizeof(T) == 8 ? 1e-12 : 1e-6);  // an error of a pose below this is none
constexpr double noticed = 0.01;       // a slow-down by a smaller share is not worth a word
constexpr double no_room = 0.01;       // a joint at its limit may move on at a smaller share of the scaled twist
template <class T> constexpr T look_ahead = T(0.01);   // how far ahead a course is looked at [scaled rad]
template <class T> constexpr T period_time = T(8);     // how slowly the period follows what steps take [s]
template <class T> constexpr T astray_by = T(2e-4);    // an error of what is held at which half of the rest is done [scaled]
template <class T> constexpr T one_round = T(2);         // a change of rates is at most so many times what the first round shows
template <class T> constexpr T near_enough = T(3e-4);  // a pair may come so much nearer while the arm stops [m]
constexpr int slowings = 4;            // how often it is looked whether joints that take over for others are too fast

inline bool is_position(servo_cause cause) {
    return cause == servo_cause::lower || cause == servo_cause::upper || cause == servo_cause::near;
}

/// The bounds of an arm with near pairs as further motors' rows, which no motor limits but by position.
template <class T, int N>
servo_bounds<T, N> with_near(const servo_bounds<T, N>& bounds, const near_pairs<T, N>& near, int count, const T* theta) {
    servo_bounds<T, N> all = bounds;
    motion_limits<T, N>& motion = all.motion;
    T* const limits[] = {motion.lower, motion.upper, motion.velocity, motion.acceleration};
    for (T* const limit : limits)
        for (int r = motion.rows() - 1; r >= motion.motors; --r) limit[r + count] = limit[r];
    for (int i = 0; i < count; ++i) {
        const int r = motion.motors + i;
        motion.c[r] = T(0);
        for (int k = 0; k < motion.coordinates; ++k) {
            motion.C[r][k] = near.rows[i][k];
            motion.c[r] -= near.rows[i][k] * theta[k];
        }
        motion.lower[r] = -detail::infinite<T>;
        // The law keeps a pair to its room. What the witness points turn on the way does not stop the arm.
        motion.upper[r] = greatest(near.room[i], T(0)) + near_enough<T>;
        motion.velocity[r] = motion.acceleration[r] = detail::infinite<T>;
    }
    motion.motors += count;
    return all;
}

/// log R (3,), |log R| ≤ π, by way of the quaternion.
template <class T> void rotation_vector(const frame<T>& g, T out[3]) {
    const T R[3][3] = {{g.x[0], g.y[0], g.z[0]}, {g.x[1], g.y[1], g.z[1]}, {g.x[2], g.y[2], g.z[2]}};
    const T trace = R[0][0] + R[1][1] + R[2][2];
    T q[4];  // x, y, z, w, the largest component from the diagonal
    int i = 0;
    for (int k = 1; k < 3; ++k)
        if (R[k][k] > R[i][i]) i = k;
    if (trace > R[i][i]) {
        q[3] = T(1) + trace;
        q[0] = R[2][1] - R[1][2];
        q[1] = R[0][2] - R[2][0];
        q[2] = R[1][0] - R[0][1];
    } else {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        q[i] = T(1) + T(2) * R[i][i] - trace;
        q[j] = R[j][i] + R[i][j];
        q[k] = R[k][i] + R[i][k];
        q[3] = R[k][j] - R[j][k];
    }
    const T sine = norm(q, 3);
    const T angle = T(2) * static_cast<T>(__builtin_atan2(static_cast<double>(sine), static_cast<double>(absolute(q[3]))));
    const T factor = sine > T(0) ? (q[3] < T(0) ? -angle : angle) / sine : T(0);
    for (int k = 0; k < 3; ++k) out[k] = factor * q[k];
}

/// (p_target − p, log(R_target Rᵀ)) in base axes, or turned into the tool's.
template <class T> void pose_error(const frame<T>& g, const frame<T>& target, bool base_axes, T error[6]) {
    frame<T> rotated = product(target, inverse(g));
    for (int k = 0; k < 3; ++k) error[k] = target.p[k] - g.p[k];
    rotation_vector(rotated, error + 3);
    if (base_axes) return;
    rotate_back(g, error, error);
    rotate_back(g, error + 3, error + 3);
}

/// The entry (i, j) of [a], for which [a] b = a × b.
template <class T> T cross_entry(const T* a, int i, int j) {
    if (i == j) return T(0);
    const T entry = a[3 - i - j];
    return (j - i + 3) % 3 == 1 ? -entry : entry;
}

template <class T, int N> void scale_twist(const servo_bounds<T, N>& bounds, const T* twist, T* scaled) {
    for (int k = 0; k < 3; ++k) {
        scaled[k] = twist[k] / bounds.length;
        scaled[k + 3] = twist[k + 3];
    }
}

inline servo_levels levels_of(const bool* held) {
    servo_levels levels{};
    const auto add = [&](int begin, int end, bool wanted) {
        const int level = levels.count;
        for (int k = begin; k < end; ++k)
            if (held[k] == wanted) levels.component[level][levels.size[level]++] = k;
        if (levels.size[level] > 0) ++levels.count;
    };
    for (int k = 0; k < 6; ++k) levels.held[k] = held[k];
    add(0, 6, true);
    levels.holds = levels.count > 0;
    add(0, 3, false);
    add(3, 6, false);
    return levels;
}

/// The rates between which a stop that takes twice as long as one from `rates` ends inside the limits: to keep to a bound
/// that falls with the distance takes half of the acceleration.
template <class T, int N> struct position_bounds {
    T least[capacity(N)], most[capacity(N)], time;

    position_bounds(const motion_limits<T, N>& motion, const T* theta, const T* rates, T dt, T period, bool gently) {
        time = greatest(steps_damped<T> * period, dt) + (gently ? T(2) : T(1)) * stopping_time(motion, rates);
        for (int k = 0; k < motion.coordinates; ++k) {
            most[k] = greatest(motion.upper[motion.motors + k] - theta[k], T(0)) / time;
            least[k] = -greatest(theta[k] - motion.lower[motion.motors + k], T(0)) / time;
        }
    }
    /// By how much the worst joint is over, and which it is.
    T over(const T* rates, int n, int& worst) const {
        T largest = T(0);
        for (int k = 0; k < n; ++k) {
            const T beyond = greatest(rates[k] - most[k], least[k] - rates[k]);
            if (beyond > largest) {
                largest = beyond;
                worst = k;
            }
        }
        return largest;
    }
};

template <class T, int N> void let_go(servo_state<T, N>& state) {
    for (bool& component : state.holding) component = false;
}

template <class T> bool usable(T value) { return absolute(value) <= T(1e6); }
template <class T> bool usable(const T* values, int count) {
    for (int k = 0; k < count; ++k)
        if (!usable(values[k])) return false;
    return true;
}
template <class T> bool usable(const frame<T>& g) {
    return usable(g.x, 3) && usable(g.y, 3) && usable(g.z, 3) && usable(g.p, 3);
}
/// Whether what the command's kind reads is finite and moderate, so that no square overflows.
template <class T, int N> bool usable(const servo_command<T, N>& command, int n) {
    switch (command.kind) {
        case servo_kind::none: return true;
        case servo_kind::jog: return usable(command.rates, n);
        case servo_kind::twist: return usable(command.twist, 6);
        case servo_kind::pose:
            return usable(command.twist, 6) && usable(command.goal) && command.linear_speed > T(0) &&
                   command.angular_speed > T(0) && usable(command.linear_speed) && usable(command.angular_speed);
    }
    return false;
}
/// The slow measure of what steps take, after one of dt: a loop that jitters is damped evenly.
template <class T> T period_after(T period, T dt) {
    if (!(period > T(0)) || !usable(period)) return dt;
    return period + (dt - period) * least(dt / period_time<T>, T(1));
}
template <class T, int N> bool usable_hold(const servo_state<T, N>& state, const servo_command<T, N>& command) {
    bool any = false;
    for (int k = 0; k < 6; ++k) any = any || (command.kind == servo_kind::twist && command.held[k] && state.holding[k]);
    return !any || usable(state.held);
}

template <class T, int N, int M> struct servo {
    const chain<T, N, M>& arm;
    const servo_bounds<T, N>& bounds;
    servo_state<T, N>& state;
    const servo_command<T, N>& command;
    servo_output<T>& out;
    T dt;
    const near_pairs<T, N>* near;
    int near_count;  // the last of the motors' rows

    int n() const { return arm.coordinates(); }
    int first_near() const { return bounds.motion.motors - near_count; }

    T most_approach(const position_bounds<T, N>& room, int i) const {
        return near->room[i] / (near->time[i] > T(0) ? near->time[i] : room.time);
    }

    /// What near pairs let the scaled rates be: they come closer no faster than lets them stop as joints do.
    void limit_approach(const position_bounds<T, N>& room, half_spaces<T, capacity(N)>& rows) const {
        rows.count = near_count;
        for (int i = 0; i < near_count; ++i) {
            rows.most[i] = most_approach(room, i);
            rows.on[i] = false;
            for (int k = 0; k < n(); ++k) rows.normal[i][k] = near->rows[i][k] * bounds.unit[k];
        }
    }

    /// By how much the worst near pair comes closer too fast at these rates, and which it is.
    T too_close(const position_bounds<T, N>& room, const T* rates, int& worst) const {
        T largest = T(0);
        for (int i = 0; i < near_count; ++i) {
            const T beyond = bounds.motion.rate(first_near() + i, rates) - most_approach(room, i);
            if (!(beyond > largest)) continue;
            largest = beyond;
            worst = i;
        }
        return largest;
    }

    /// The rates that the limits let the arm have, and where they lead.
    void move(T* rates) {
        const motion_limits<T, N>& motion = bounds.motion;
        T wanted[capacity(N)] = {};
        for (int k = 0; k < n(); ++k) wanted[k] = rates[k];
        const int row = keep_within(motion, state.theta, state.theta_dot, dt, rates);
        if (row >= 0 && !is_position(out.cause))
            blame(row >= first_near() && row < motion.motors ? servo_cause::near
                  : motion.rate(row, wanted) > T(0)          ? servo_cause::upper
                                                             : servo_cause::lower,
                  row);
        for (int k = 0; k < n(); ++k) {
            // Rounding may not carry a joint beyond its limit; one that was outside stays no farther out than it was.
            const T upper = greatest(motion.upper[motion.motors + k], state.theta[k]);
            const T lower = least(motion.lower[motion.motors + k], state.theta[k]);
            state.theta_dot[k] = rates[k];
            state.theta[k] = clamped(state.theta[k] + dt * rates[k], lower, upper);
        }
    }

    void jog() {
        T rates[capacity(N)] = {};
        int row, joint = 0;
        const T share = velocity_share(bounds.motion, command.rates, row);
        for (int k = 0; k < n(); ++k) rates[k] = share * command.rates[k];
        if (share < T(1)) blame(servo_cause::velocity, row);
        const position_bounds<T, N> room(bounds.motion, state.theta, rates, dt, state.period, false);
        if (room.over(rates, n(), joint) > nothing<T>)
            blame(rates[joint] > T(0) ? servo_cause::upper : servo_cause::lower, bounds.motion.motors + joint);
        for (int k = 0; k < n(); ++k) rates[k] = clamped(rates[k], room.least[k], room.most[k]);
        if (too_close(room, rates, joint) > nothing<T>) {
            blame(servo_cause::near, first_near() + joint);
            jog_limiting_approach(room, rates);
        }
        const T size = norm(command.rates, n());
        move(rates);
        out.halted = is_position(out.cause) && norm(state.theta_dot, n()) <= T(halted_below) * share * size;
        T beside[capacity(N)] = {};
        for (int k = 0; k < n(); ++k) beside[k] = state.theta_dot[k] - command.rates[k];
        set_scale(norm(beside, n()), norm(state.theta_dot, n()), size, size);
    }

    /// The rates nearest to those of a jog that keep near pairs apart: each joint at most as fast, and none backwards.
    void jog_limiting_approach(const position_bounds<T, N>& room, T* rates) const {
        constexpr int most = capacity(N);
        T H[most][most], wanted[most], lower[most], upper[most], x[most];
        sides<most> at;
        half_spaces<T, most> rows;
        limit_approach(room, rows);
        for (int a = 0; a < n(); ++a) {
            for (int b = 0; b < n(); ++b) H[a][b] = T(a == b ? 1 : 0);
            wanted[a] = rates[a] / bounds.unit[a];
            lower[a] = least(wanted[a], T(0));
            upper[a] = greatest(wanted[a], T(0));
            x[a] = T(0);
            at[a] = 0;
        }
        least_within(H, wanted, lower, upper, n(), at, x, &rows);
        for (int k = 0; k < n(); ++k) rates[k] = x[k] * bounds.unit[k];
    }

    /// 1 − |done − reachable| over the longer of the two, at least 0: 1 where all of it is done and nothing beside it.
    void set_scale(T beside, T done, T reachable, T asked) {
        if (reachable > T(halted_below) * asked)
            out.scale = greatest(T(1) - beside / greatest(reachable, done), T(0));
        else out.scale = T(asked > T(0) ? 0 : 1);
    }

    void blame(servo_cause cause, int row) {
        out.cause = cause;
        out.row = row;
    }

    void follow() {
        T ahead[capacity(N)], asked[6];
        for (int k = 0; k < n(); ++k) ahead[k] = state.theta[k] + T(0.5) * dt * state.theta_dot[k];
        const bool goal = command.kind == servo_kind::pose, base_axes = goal || command.base_axes;
        bool held[6];
        for (int k = 0; k < 6; ++k) held[k] = !goal && command.held[k];
        const servo_levels levels = levels_of(held);
        T error[6];
        held_rows<T> astray;
        const bool any = look_at(goal, base_axes, held, error, astray);
        rate_solver<T, N, M> solver(arm, bounds, levels, astray, base_axes, ahead, state.period);
        scale_twist(bounds, command.twist, asked);
        if (any && !goal) wait_for(held, error, asked);
        if (any) add_error(solver, goal, error, asked);
        reach(solver, asked);
    }

    /// The error of a pose to reach, or of the components that are held. Answers whether there is any such.
    bool look_at(bool goal, bool base_axes, const bool* held, T* error, held_rows<T>& astray) {
        bool any = false, same = state.holding_base_axes == base_axes;
        for (int k = 0; k < 6; ++k) {
            any = any || held[k];
            same = same && state.holding[k] == held[k];
            state.holding[k] = held[k];
        }
        state.holding_base_axes = base_axes;
        astray.mixed = false;
        if (!goal && !any) return false;
        const frame<T> g = forward(arm, state.theta);
        if (any && !same) state.held = g;
        pose_error(g, goal ? command.goal : state.held, base_axes, error);
        astray.mixed = !goal && (held[0] != held[1] || held[1] != held[2] || held[3] != held[4] || held[4] != held[5]);
        if (astray.mixed) rows_of(error, base_axes, astray);
        for (int k = 0; k < 6; ++k) error[k] = goal || held[k] ? error[k] : T(0);
        for (int half = 0; half < 2 && goal; ++half) out.remaining[half] = norm(error + 3 * half, 3);
        return true;
    }

    /// Where what is held has gone astray, the rest waits until it is back.
    void wait_for(const bool* held, const T* error, T* asked) const {
        T off[6];
        scale_twist(bounds, error, off);
        const T much = norm(off, 6) / astray_by<T>, share = T(1) / (T(1) + much * much);
        for (int k = 0; k < 6; ++k)
            if (!held[k]) asked[k] *= share;
    }

    /// −d(error)/dt for twists: v + ω × e in the tool's axes, v in the base's; ω by the inverse of the exponential's
    /// Jacobian at φ, I ∓ ½ [φ] + c [φ]², c = (1 − ½ |φ| cot ½ |φ|) / |φ|². J. Solà et al., arXiv:1812.01537, eq. 144.
    void rows_of(const T* error, bool base_axes, held_rows<T>& astray) const {
        const T* const phi = error + 3;
        const T angle = norm(phi, 3), half = T(0.5) * angle;
        T sine, cosine;
        sincos(half, sine, cosine);
        const T c = angle > T(0.01) ? (T(1) - half * cosine / sine) / (angle * angle) : T(1) / T(12);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const T unit = T(i == j ? 1 : 0), turn = cross_entry(phi, i, j);
                astray.rows[i][j] = unit;
                astray.rows[i][j + 3] = base_axes ? T(0) : -cross_entry(error, i, j) / bounds.length;
                astray.rows[i + 3][j] = T(0);
                astray.rows[i + 3][j + 3] =
                    unit + (base_axes ? T(0.5) : T(-0.5)) * turn + c * (phi[i] * phi[j] - unit * angle * angle);
            }
    }

    /// As much of error / dt as lets the arm stop at the goal, straight on: s dt + s² T/2 ≤ dt. What is held is taken back
    /// in two periods at least, whatever dt is: a pull that varied with dt would shake an arm at rest.
    void add_error(rate_solver<T, N, M>& solver, bool goal, const T* error, T* asked) {
        T largest = T(0);
        for (int k = 0; k < 6; ++k) largest = greatest(largest, absolute(error[k]));
        if (!(largest > rounding<T>)) return;
        T wanted[6], rates[capacity(N)];
        scale_twist(bounds, error, wanted);
        if (goal) free_rates(solver, wanted, rates);
        else solver.take_back_held(wanted, rates);
        const T period = state.period, most = goal ? T(1) : least(T(1), T(0.5) * dt / period);
        for (int k = 0; k < 6; ++k) wanted[k] = wanted[k] / dt;
        for (int k = 0; k < n(); ++k) rates[k] = rates[k] * bounds.unit[k];
        const T stop = stopping_time(bounds.motion, rates);
        T share = least(most, T(2) * dt / (period + sqrt(period * period + T(2) * stop)));
        if (goal) {
            share = least(share, command.linear_speed * dt / greatest(norm(error, 3), nothing<T>));
            share = least(share, command.angular_speed * dt / greatest(norm(error + 3, 3), nothing<T>));
        }
        for (int k = 0; k < 6; ++k) asked[k] += share * wanted[k];
    }

    /// The scaled rates for what is asked where joints have no limits.
    void free_rates(const rate_solver<T, N, M>& solver, const T* asked, T* x) {
        T lower[capacity(N)], upper[capacity(N)];
        sides<capacity(N)> at;
        unbounded(lower, upper);
        solver(asked, lower, upper, at, x);
    }
    void unbounded(T* lower, T* upper) const {
        for (int k = 0; k < n(); ++k) {
            upper[k] = detail::infinite<T>;
            lower[k] = -upper[k];
        }
    }

    /// The rates for what is asked, and the share that they are for.
    T resolve(rate_solver<T, N, M>& solver, const T* asked, T* rates) {
        T x[capacity(N)], left[6];
        int row = 0, worst = 0;
        free_rates(solver, asked, x);
        solver.rest(solver.J, asked, x, left);
        const T size = greatest(norm(asked, 6), nothing<T>), lost = norm(left, 6) / size;
        const bool steady = command.kind == servo_kind::twist && command.base_axes && !solver.levels.holds;
        if (lost > missed<T> && solver.look_beside(asked, left, lost, steady)) {
            int joint = -1;
            if (solver.singular_part(left, joint) > T(noticed) * size * size) blame(servo_cause::singularity, joint);
            free_rates(solver, asked, x);
            if (solver.take_back(x)) free_rates(solver, asked, x);
        }
        for (int k = 0; k < n(); ++k) rates[k] = x[k] * bounds.unit[k];
        T share = velocity_share(bounds.motion, rates, row);
        T followable = T(1), lower[capacity(N)], upper[capacity(N)];
        unbounded(lower, upper);
        if (solver.levels.holds && may_bend(solver, x, rates)) followable = followable_share(solver, asked, lower, upper, x);
        if (followable < share) {
            share = followable;
            if (out.cause == servo_cause::none && share < T(1 - noticed)) blame(servo_cause::singularity, -1);
        } else if (share < T(1)) blame(servo_cause::velocity, row);
        for (int k = 0; k < n(); ++k) rates[k] *= share;
        const position_bounds<T, N> room(bounds.motion, state.theta, rates, dt, state.period, solver.levels.holds);
        if (!(share < T(1)) && !bounds.stops && !(room.over(rates, n(), worst) > nothing<T>) &&
            !(too_close(room, rates, worst) > nothing<T>))
            return share;
        for (int round = 1; round <= slowings; ++round) {
            within(solver, asked, share, room, round == slowings, rates);
            const T slower = velocity_share(bounds.motion, rates, row);
            if (!(slower < T(1)) || round == slowings) break;
            // Others have taken over for the joints at their limits.
            if (!is_position(out.cause)) blame(servo_cause::velocity, row);
            share *= slower;
        }
        return share;
    }

    /// The rates for a share of what is asked within the bounds of position of each joint, and of velocity too.
    void within(const rate_solver<T, N, M>& solver, const T* asked, T share, const position_bounds<T, N>& room,
                bool velocities, T* rates) {
        const T* const fastest = bounds.motion.velocity + bounds.motion.motors;
        T lower[capacity(N)], upper[capacity(N)], scaled[6], x[capacity(N)], end[capacity(N)], worst = T(-1);
        int joint = -1, closest = -1;
        sides<capacity(N)> at;
        half_spaces<T, capacity(N)> rows, *const approach = near_count > 0 ? &rows : nullptr;
        if (approach != nullptr) limit_approach(room, rows);
        for (int i = 0; i < 6; ++i) scaled[i] = share * asked[i];
        for (int k = 0; k < n(); ++k) {
            lower[k] = (velocities ? greatest(room.least[k], -fastest[k]) : room.least[k]) / bounds.unit[k];
            upper[k] = (velocities ? least(room.most[k], fastest[k]) : room.most[k]) / bounds.unit[k];
        }
        solver(scaled, lower, upper, at, x, approach);
        const T size = norm(scaled, 6);
        for (int k = 0; k < n(); ++k) {
            end[k] = at[k] < 0 ? room.least[k] : room.most[k];
            const T beyond = absolute(rates[k] - end[k]) / bounds.unit[k];
            if (at[k] == 0 || absolute(end[k]) >= fastest[k] || !(beyond > T(noticed) * size)) continue;
            // Where all stop, it is for the one that has the least way left.
            const T weight = bounds.stops ? beyond / (absolute(end[k]) / bounds.unit[k] + T(no_room) * size) : beyond;
            if (!(weight > worst)) continue;
            worst = weight;
            joint = k;
            blame(at[k] > 0 ? servo_cause::upper : servo_cause::lower, bounds.motion.motors + k);
        }
        const T too_fast = too_close(room, rates, closest) / bounds.length;
        if (too_fast > T(noticed) * size) {
            const T left = greatest(most_approach(room, closest), T(0)) / bounds.length;
            if ((bounds.stops ? too_fast / (left + T(no_room) * size) : too_fast) > worst) {
                joint = -1;
                blame(servo_cause::near, first_near() + closest);
            }
        }
        if (bounds.stops) {
            hold_course(solver, scaled, lower, upper, at, x, approach);
            // Nobody is at a limit: one would have to be too fast for the course.
            if (joint >= 0 && absolute(end[joint]) / bounds.unit[joint] > T(no_room) * size &&
                norm(x, n()) <= T(halted_below) * size)
                blame(servo_cause::singularity, joint);
        }
        for (int k = 0; k < n(); ++k) {
            end[k] = at[k] < 0 ? room.least[k] : room.most[k];
            rates[k] = at[k] == 0 || absolute(end[k]) >= fastest[k] ? x[k] * bounds.unit[k] : end[k];
        }
    }

    /// The share of what is asked at which the joints can keep to its course: with x the rates for all of it and x' how
    /// they change on the way, s² x' takes at most a quarter of the accelerations; a twelfth where something is held.
    T followable_share(const rate_solver<T, N, M>& solver, const T* asked, const T* lower, const T* upper, const T* x) {
        const T size = norm(x, n());
        if (!(size > nothing<T>)) return T(1);
        T farther[capacity(N)], then[capacity(N)];
        sides<capacity(N)> at = {};
        for (int k = 0; k < n(); ++k) {
            farther[k] = solver.posture[k] + look_ahead<T> / size * x[k] * bounds.unit[k];
            then[k] = x[k];
        }
        rate_solver<T, N, M> ahead(arm, bounds, solver.levels, solver.held, solver.base_axes, farther, state.period);
        ahead.leave_as(solver);
        const auto time = [&] { return (solver.levels.holds ? T(12) : T(4)) * time_to_change(x, then, size); };
        ahead.go_on(asked, lower, upper, 1, at, then);
        if (!(one_round<T> * time() > T(1))) return T(1);
        ahead.go_on(asked, lower, upper, most_rounds, at, then);
        return T(1) / sqrt(greatest(time(), T(1)));
    }

    /// The time [s] that the accelerations take for the change x' of rates x of that size, on the way to `then`.
    T time_to_change(const T* x, const T* then, T size) const {
        T along = T(0), change[capacity(N)];
        for (int k = 0; k < n(); ++k) along += (then[k] - x[k]) * x[k] / (size * size);
        // Rates that shrink on the way may stay as they are: the tool speeds up then.
        for (int k = 0; k < n(); ++k)
            change[k] = (then[k] - x[k] - least(along, T(0)) * x[k]) * bounds.unit[k] * size / look_ahead<T>;
        return stopping_time(bounds.motion, change);
    }

    /// Whether rates that change by up to |x|² / (3 σ) on the way may take a twelfth of the accelerations.
    bool may_bend(const rate_solver<T, N, M>& solver, const T* x, const T* rates) const {
        const T most = T(4) * norm(x, n()) * stopping_time(bounds.motion, rates);
        return most > T(0) && most > smallest_about<T, N>(solver.J, 6, n());
    }

    /// Slows what is asked until the rates x do it without leaving its course: by halves, the largest share that does.
    void hold_course(const rate_solver<T, N, M>& solver, const T* asked, const T* lower, const T* upper,
                     sides<capacity(N)>& at, T* x, half_spaces<T, capacity(N)>* approach) {
        T kept = T(0), slower[6], step = followable_share(solver, asked, lower, upper, x);
        for (bool first = true; step > T(1e-6); first = false) {
            for (int i = 0; i < 6; ++i) slower[i] = (kept + step) * asked[i];
            solver(slower, lower, upper, at, x, approach);
            if (solver.keeps_course(slower, x)) {
                if (first) return;
                kept += step;
            }
            step = T(0.5) * step;
        }
        for (int i = 0; i < 6; ++i) slower[i] = kept * asked[i];
        solver(slower, lower, upper, at, x, approach);
    }

    void reach(rate_solver<T, N, M>& solver, const T* asked) {
        T rates[capacity(N)], scaled[capacity(N)], reachable[6];
        const T share = resolve(solver, asked, rates), size = norm(asked, 6);
        for (int k = 0; k < n(); ++k) scaled[k] = rates[k] / bounds.unit[k];
        for (int i = 0; i < 6; ++i) {
            reachable[i] = solver.times(solver.J, i, scaled) / share;
            out.lost[i] = asked[i] - reachable[i];
        }
        out.lost_share = norm(out.lost, 6) / greatest(size, nothing<T>);
        // Arms below six joints turn the tool on their way, and lose turns that they have nowhere.
        T off[6];
        solver.without_ways_out(out.lost, off);
        const bool astray = norm(off, n() < 6 ? 3 : 6) > T(noticed) * size;
        for (int i = 0; i < 3; ++i) out.lost[i] *= bounds.length;
        move(rates);
        for (int k = 0; k < n(); ++k) scaled[k] = rates[k] / bounds.unit[k];
        out.halted = is_position(out.cause) && norm(scaled, n()) <= T(halted_below) * share * size;
        T done[6], beside[6];
        for (int i = 0; i < 6; ++i) {
            done[i] = solver.times(solver.J, i, scaled);
            beside[i] = done[i] - reachable[i];
        }
        const T whole = norm(reachable, 6);
        set_scale(norm(beside, 6), norm(done, 6), whole, size);
        if (out.cause == servo_cause::none && size > T(0) && (astray || whole <= T(halted_below) * size))
            out.cause = servo_cause::singularity;
    }
};

template <class T, int N, int M>
void step_in(const chain<T, N, M>& arm, const servo_bounds<T, N>& bounds, const servo_command<T, N>& command, T dt,
             servo_state<T, N>& state, servo_output<T>& out, const near_pairs<T, N>* near, int pairs) {
    const int n = arm.coordinates();
    out = servo_output<T>{};
    out.row = -1;
    out.scale = T(1);
    if (!(dt > T(0)) || !usable(dt) || !usable(state.theta, n) || !usable(state.theta_dot, n) ||
        !usable_hold(state, command)) {
        out.cause = servo_cause::unusable;
        out.scale = T(0);
        for (int k = 0; k < n; ++k) state.theta_dot[k] = T(0);
        let_go(state);
        return;
    }
    state.period = period_after(state.period, dt);
    servo<T, N, M> step{arm, bounds, state, command, out, dt, near, pairs};
    const bool follows = usable(command, n);
    if (command.kind == servo_kind::none || !follows) {
        T rest[capacity(N)];
        for (int k = 0; k < n; ++k) rest[k] = T(0);
        let_go(state);
        step.move(rest);
        if (follows) return;
        out.cause = servo_cause::unusable;
        out.row = -1;
        out.scale = T(0);
    } else if (command.kind == servo_kind::jog) {
        let_go(state);
        step.jog();
    } else {
        step.follow();
    }
}
}  // namespace servo_detail

/// One step: the state after dt [s] under the command, and what became of the command.
///
/// The state's theta_dot are the rates for the coming dt. Without a command (servo_kind::none) the arm comes to rest; with
/// one that is not finite or beyond 1e6 too, and with a dt that is not positive or a state that is neither it stands at
/// once where it is: servo_cause::unusable.
/// Pairs of `near` come no closer than their room; without a command nothing looks at them.
template <class T, int N, int M>
void servo_step(const chain<T, N, M>& arm, const servo_bounds<T, N>& bounds, const servo_command<T, N>& command, T dt,
                servo_state<T, N>& state, servo_output<T>& out, const near_pairs<T, N>* near = nullptr) {
    const int motors = bounds.motion.motors;
    const int pairs = near == nullptr || command.kind == servo_kind::none ? 0 : least(near->count, most_joints - motors);
    if (pairs > 0) {
        const servo_bounds<T, N> all = servo_detail::with_near(bounds, *near, pairs, state.theta);
        servo_detail::step_in(arm, all, command, dt, state, out, near, pairs);
        if (out.cause == servo_cause::singularity || out.row < motors) return;
        out.row -= out.cause == servo_cause::near ? motors : pairs;
        return;
    }
    servo_detail::step_in(arm, bounds, command, dt, state, out, near, 0);
}

TWISTARM_END
