// Joint rates for a twist (resolved motion rate control): the least of one strictly convex function.
//
// Of a twist V in levels V_l, the first the most important, with the Jacobian's rows J_l, the joint rates are
//
//     x = argmin  Σ_l w_l |V_l − J_l x| + (τ/2) |x|²   over   lower ≤ x ≤ upper,   w_l = 1, 1/κ, 1/κ², …
//
// The norms are not squared: an exact penalty (J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §17.2). What the
// arm can do without more than |J⁻ᵀ τ x| ≤ w it does exactly; near a singularity, where that would take joint rates beyond
// all bounds, it gives up as much as it must, and of a lower level first. x is continuous in posture, twist and bounds.
// Under a constant velocity of the tool, V·J x > 0 while anything moves, because 0 lies within the bounds: the tool
// moves on along the command or comes to rest, and no motion repeats itself. About a rest at the edge of the reach,
// ∂x/∂θ is at most the curvature of the tool's path over τ, which one step of delay leaves stable for τ ≥ 3 dt.
//
// A first level that is held is no norm but ½ ρ |V_0 − J_0 x|² with a large ρ: it is done exactly, whatever the rest loses.
// Its directions that a posture nearly lacks count as whole, so that no joint moves the tool along them to second order.
//
// D. E. Whitney, Resolved motion rate control of manipulators and human prostheses, IEEE T-MMS 10(2), 1969. Everything
// here is scaled to radians: metres are measured in a length, and a slide's rates too.
#pragma once

#include "../numeric/half_spaces.hpp"
#include "../kinematics/kinematics.hpp"
#include "../kinematics/motion_limits.hpp"
#include "../kinematics/singular_directions.hpp"

TWISTARM_BEGIN

/// What a servo needs to know of an arm beside its chain.
///
/// unit: what a coordinate's scaled number is multiplied by, 1 or `length` for a slide. ready: where a singular arm looks
/// for the way out. length [m]: what compares metres with radians. below: a smaller singular value is called singular.
/// damping [s]: τ. stops: where the arm cannot follow it stops on its way, and does not slide along.
template <class T, int N> struct servo_bounds {
    motion_limits<T, N> motion;
    T unit[capacity(N)], ready[capacity(N)];
    T length, below, damping;
    bool stops;
};

/// Tool rates by levels: which components of the twist, in tool or in base axes, go before which others. Of those
/// that are held the first level consists; `holds` says whether there are any.
struct servo_levels {
    int count, size[3], component[3][6];
    bool holds, held[6];
};

namespace servo_detail {
template <class T> constexpr T precedence = T(10);             // κ: what a level counts beside the next, below six joints
template <class T> constexpr T precedence_of_six = T(3);       // … and from six on
template <class T> constexpr T steps_damped = T(3);            // τ is at least so many steps, and a joint comes to its limit in no fewer
template <class T> constexpr T no_motion = T(sizeof(T) == 8 ? 1e-9 : 1e-5);   // singular values below this count as none
template <class T> constexpr T rise_whole = T(0.05);           // dσ per scaled rad: from here on a motion leaves a singularity entirely
template <class T> constexpr T rise_moving = T(0.02);           // … and by the motion that the arm makes then
template <class T> constexpr T on_course = T(2e-3);            // what singular values count as at least, where the arm keeps to its course
template <class T> constexpr T difference = T(sizeof(T) == 8 ? 1e-4 : 4e-3);
template <class T> constexpr T beside = T(0.02);               // how far beside a posture one looks for lacking directions
template <class T> constexpr T off_course = T(1e-3);           // of the twist: less beside its course is none
template <class T> constexpr T missed = T(0.1);                // of the twist: a smaller part that is lost leads nowhere
template <class T> constexpr T tilt = T(0.1);                  // leads toward the ready pose off any singularity
template <class T> constexpr T nothing = T(sizeof(T) == 8 ? 1e-12 : 1e-6);   // slower scaled rates are rounding
template <class T> constexpr T rounded_off = T(sizeof(T) == 8 ? 1e-4 : 1e-3);   // of the twist: a norm's tip
template <class T> constexpr T unchanged = T(sizeof(T) == 8 ? 1e-6 : 1e-4);    // of the rates: a smaller change is none
template <class T> constexpr T left_behind = T(0.055);        // what a singular value on its way up counts as: √(τ V) for V = 0.1
template <class T> constexpr T equally = T(1e-6);             // of a unit motion: joints that move so nearly alike move alike
template <class T> constexpr T firmness = T(sizeof(T) == 8 ? 1e6 : 1e3);      // the weight of what is held, [s]
template <class T> constexpr T as_good_as_none = T(2e-4);     // a smaller singular value may be left to either side
template <class T> constexpr T more_room = T(0.1);            // [scaled rad]: a way out is taken for its room where it ends so much farther off
template <class T> constexpr T no_share = T(1e-3);            // of a unit motion: a joint that moves less does not count
template <class T> constexpr T held_damping_below = T(0.1);  // what turns a held direction is damped by τ times the square of this over σ
template <class T> constexpr T no_way = T(1e-5);              // of the rows beside a posture: what is shorter is none
constexpr int most_rounds = 50;
constexpr int five = 5;  // joints from which on singularities are the whole twist's

template <class T> T norm(const T* values, int count) {
    T sum = T(0);
    for (int k = 0; k < count; ++k) sum += values[k] * values[k];
    return sqrt(sum);
}

/// A direction: joints v move the tool by σ u. leaving, 0 … 1: how far the motion that is asked for leaves a singularity;
/// edge: what σ counts as then.
template <class T, int N> struct direction {
    T u[6], v[capacity(N)], sigma, edge, leaving;
};

/// How what is held goes astray while the rest moves: −d(error)/dt = rows · twist, scaled; of all six components where only
/// some of the position or of the orientation are held, else their own.
template <class T> struct held_rows {
    bool mixed;
    T rows[6][6];
};

template <class T, int N, int M> struct rate_solver {
    static constexpr int most = capacity(N);
    const chain<T, N, M>& arm;
    const servo_bounds<T, N>& bounds;
    const servo_levels& levels;
    const held_rows<T>& held;
    bool base_axes;
    T damping, posture[most];
    six_rows<T, N> J, rows_leaving;  // rows_leaving: J as it will be, on the way out of a singularity
    direction<T, N> found[6];        // the tool's directions, the strongest first
    int rank = 0;                    // how many of them
    bool of_position = false;        // whether they are those of the position alone
    T turning = T(0);                // 0 … 1: how far the tool may turn as it will, on its course out of a singular position
    bool held_nearly_lost = false;   // whether any held direction is nearly lost, which gives the next two a meaning
    six_rows<T, N> rows_held;        // J where held directions count as whole
    T held_damping[most][most];      // what is damped beside τ

    int n() const { return arm.coordinates(); }

    rate_solver(const chain<T, N, M>& arm_, const servo_bounds<T, N>& bounds_, const servo_levels& levels_,
                const held_rows<T>& held_, bool base, const T* theta, T period)
        : arm(arm_), bounds(bounds_), levels(levels_), held(held_), base_axes(base),
          damping(greatest(bounds_.damping, steps_damped<T> * period)) {
        for (int k = 0; k < n(); ++k) posture[k] = theta[k];
        jacobian(posture, J);
        copy(J, rows_leaving);
        if (levels.holds) hold_nearly_lost();
    }

    /// Held directions that this posture nearly lacks count as whole: what moves them is as good as fixed, here and beside.
    void hold_nearly_lost() {
        six_rows<T, N> rows;
        const int count = levels.size[0];
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < n(); ++k) rows[i][k] = J[levels.component[0][i]][k];
        if (!(smallest_about<T, N>(rows, count, n()) < left_behind<T>)) return;
        decompose(levels.held, count);
        for (int d = 0; d < rank; ++d)
            if (found[d].sigma < left_behind<T>) fix(found[d]);
        rank = 0;
        if (held_nearly_lost) copy(rows_leaving, rows_held);
    }

    /// Fixes a held direction. Its joint motion v turns by (∂J/∂x)ᵀ u / σ: by the square of what is left that is
    /// damped, so that no step turns v by much, however little is left.
    void fix(const direction<T, N>& held) {
        if (!(norm(held.v, n()) > T(0))) return;
        for (int i = 0; i < 6; ++i)
            for (int k = 0; k < n(); ++k) rows_leaving[i][k] += (left_behind<T> - held.sigma) * held.u[i] * held.v[k];
        T turns[most][most];
        for (int j = 0; j < n(); ++j) {
            six_rows<T, N> there;
            T theta[most];
            for (int k = 0; k < n(); ++k) theta[k] = posture[k] + (k == j ? bounds.unit[k] * difference<T> : T(0));
            jacobian(theta, there);
            for (int k = 0; k < n(); ++k) {
                turns[k][j] = T(0);
                for (int i = 0; i < 6; ++i) turns[k][j] += held.u[i] * (there[i][k] - J[i][k]) / difference<T>;
            }
        }
        const T here = held_damping_below<T> / greatest(held.sigma, difference<T>), whole = held_damping_below<T> / left_behind<T>;
        const T heavy = damping * (here * here - whole * whole);
        for (int a = 0; a < n(); ++a)
            for (int b = 0; b <= a; ++b) {
                if (!held_nearly_lost) held_damping[a][b] = T(0);
                for (int k = 0; k < n(); ++k) held_damping[a][b] += heavy * turns[k][a] * turns[k][b];
            }
        held_nearly_lost = true;
    }

    void copy(const six_rows<T, N>& from, six_rows<T, N>& to) const {
        for (int i = 0; i < 6; ++i)
            for (int k = 0; k < n(); ++k) to[i][k] = from[i][k];
    }

    /// The scaled rows at theta.
    void jacobian(const T* theta, six_rows<T, N>& rows) const {
        column<T> columns[most];
        const frame<T> g = forward_with_body_jacobian(arm, theta, columns);
        for (int k = 0; k < n(); ++k) {
            if (base_axes) {
                rotate(g, columns[k].v, columns[k].v);
                rotate(g, columns[k].w, columns[k].w);
            }
            for (int i = 0; i < 3; ++i) {
                rows[i][k] = columns[k].v[i] * (bounds.unit[k] / bounds.length);
                rows[i + 3][k] = columns[k].w[i] * bounds.unit[k];
            }
            if (!held.mixed) continue;
            T twist[6];
            for (int i = 0; i < 6; ++i) twist[i] = rows[i][k];
            for (int i = 0; i < 6; ++i) {
                if (!levels.held[i]) continue;
                rows[i][k] = T(0);
                for (int j = 0; j < 6; ++j) rows[i][k] += held.rows[i][j] * twist[j];
            }
        }
    }

    /// The rows a little beside the posture, toward the ready one.
    void jacobian_beside(six_rows<T, N>& rows) const {
        T theta[most], way[most];
        for (int k = 0; k < n(); ++k)
            way[k] = (bounds.ready[k] - posture[k]) / bounds.unit[k] + (k % 2 == 0 ? tilt<T> : -tilt<T>);
        const T step = beside<T> / greatest(norm(way, n()), nothing<T>);
        for (int k = 0; k < n(); ++k) theta[k] = posture[k] + bounds.unit[k] * step * way[k];
        jacobian(theta, rows);
    }

    /// The directions that the arm's tool has, the strongest first. Those that this very posture lacks are read off one a
    /// little beside: no rates move the tool along them here, but some bend the arm so that they will. Where nothing is
    /// seen of them there either, v = 0.
    void decompose(const bool (&chosen)[6], int count) {
        six_rows<T, N> rows;
        T X[6][6];
        rank = count < n() ? count : n();
        for (int i = 0; i < 6; ++i)
            for (int k = 0; k < n(); ++k) rows[i][k] = chosen[i] ? J[i][k] : T(0);
        make_orthogonal<T, N>(rows, 6, n(), X);
        int order[6], strong = 0;
        for (int i = 0; i < 6; ++i) order[i] = i;
        for (int i = 0; i < 6; ++i)
            for (int j = i + 1; j < 6; ++j)
                if (norm(rows[order[j]], n()) > norm(rows[order[i]], n())) {
                    const int swapped = order[i];
                    order[i] = order[j];
                    order[j] = swapped;
                }
        for (int i = 0; i < rank; ++i) {
            const T sigma = norm(rows[order[i]], n());
            if (!(sigma > no_motion<T>)) break;
            direction<T, N>& next = found[strong++];
            next.sigma = sigma;
            for (int j = 0; j < 6; ++j) next.u[j] = X[j][order[i]];
            for (int k = 0; k < n(); ++k) next.v[k] = rows[order[i]][k] / sigma;
        }
        if (strong == rank) return;
        six_rows<T, N> there, rest;
        T Y[6][6];
        jacobian_beside(there);
        const int weak = 6 - strong;
        for (int i = 0; i < weak; ++i)
            for (int k = 0; k < n(); ++k) {
                rest[i][k] = T(0);
                for (int j = 0; j < 6; ++j)
                    if (chosen[j]) rest[i][k] += X[j][order[strong + i]] * there[j][k];
            }
        for (int i = 0; i < weak; ++i)
            for (int d = 0; d < strong; ++d) {
                const T along = times(rest, i, found[d].v);
                for (int k = 0; k < n(); ++k) rest[i][k] -= along * found[d].v[k];
            }
        make_orthogonal<T, N>(rest, weak, n(), Y);
        for (bool used[6] = {}; strong < rank; ++strong) {
            int widest = -1;
            for (int i = 0; i < weak; ++i)
                if (!used[i] && (widest < 0 || norm(rest[i], n()) > norm(rest[widest], n()))) widest = i;
            used[widest] = true;
            direction<T, N>& next = found[strong];
            next.sigma = T(0);
            const T size = norm(rest[widest], n());
            for (int k = 0; k < n(); ++k) next.v[k] = size > no_way<T> ? rest[widest][k] / size : T(0);
            for (int j = 0; j < 6; ++j) {
                next.u[j] = T(0);
                for (int i = 0; i < weak; ++i) next.u[j] += X[j][order[6 - weak + i]] * Y[i][widest];
            }
        }
    }

    /// dσ per scaled radian along a unit motion: uᵀ (∂J/∂motion) v.
    T rise(const direction<T, N>& of, const T* motion) const {
        six_rows<T, N> there;
        T theta[most], risen = T(0);
        for (int k = 0; k < n(); ++k) theta[k] = posture[k] + bounds.unit[k] * difference<T> * motion[k];
        jacobian(theta, there);
        for (int i = 0; i < 6; ++i) risen += of.u[i] * (times(there, i, of.v) - times(J, i, of.v)) / difference<T>;
        return risen;
    }

    /// Where the arm is singular and a share `lost` of what is asked, looks which motions leave the singularity.
    ///
    /// An arm must be able to move away: a singular value on its way up counts as more. (An arm that is exactly stretched
    /// has no rates at all that pull its tool back to first order.) Where the arm keeps to its course it counts as itself,
    /// and is not damped. Answers whether the arm is singular. The position alone is looked at first in an arm of fewer
    /// than five joints. steady: what is asked stays the same in base axes while the arm moves.
    bool look_beside(const T* asked, const T* left, T lost, bool steady) {
        const bool position = n() < five && smallest_about<T, N>(J, 3, n()) < greatest(bounds.below, T(2) / precedence<T>);
        const T enough = greatest(bounds.below, left_behind<T>), size = norm(asked, 6);
        if (!position && !(smallest_about<T, N>(J, 6, n()) < enough)) return false;
        decompose({true, true, true, !position, !position, !position}, position ? 3 : 6);
        of_position = position;
        const T much = clamped(lost / missed<T> - T(1), T(0), T(1));
        for (int d = 0; d < rank; ++d) {
            direction<T, N>& along = found[d];
            along.leaving = along.edge = T(0);
            // The way out of a position may turn the tool, which a lower level resists.
            T share = T(0);
            along.edge = position ? greatest(bounds.below, T(2) * turn_of(along.v) / precedence<T>) : enough;
            if (!(along.sigma < along.edge)) continue;
            for (int i = 0; i < 6; ++i) share += along.u[i] * left[i];
            const T side = T(share < T(0) ? -1 : 1);
            if (along.sigma < as_good_as_none<T> && way_left(along.v, side) + more_room<T> < way_left(along.v, -side)) {
                // Both ways bend the arm, which is as good as exactly singular, and the other one ends later.
                along.sigma = -along.sigma;
                for (int k = 0; k < n(); ++k) along.v[k] = -along.v[k];
            }
            if (bounds.stops) along.edge = greatest(on_course<T>, along.sigma);
            along.leaving = much * clamped(rise(along, along.v) * share / size / rise_whole<T>, T(0), T(1));
            if (position && steady && !bounds.stops && along.leaving < much) bend(along, asked, share / size, much);
        }
        lead();
        return true;
    }

    /// A way out of a position by the other motions: the one along which the tool's path bends most to where it is to go,
    /// where that leaves the singularity faster.
    ///
    /// At a rest that is held up by the turn that the way out takes, the tool stands where its path is farthest from there:
    /// any of these motions brings it back, but none to first order.
    void bend(direction<T, N>& along, const T* asked, T share, T much) const {
        T curved[2][2] = {}, side = T(share < T(0) ? -1 : 1);
        int others[2], count = 0;
        for (int d = 0; d < rank && count < 2; ++d)
            if (!(found[d].sigma < greatest(bounds.below, T(0.2) * turn_of(found[d].v)))) others[count++] = d;
        for (int b = 0; b < count; ++b) {
            direction<T, N> of = found[others[b]];
            for (int i = 0; i < 6; ++i) of.u[i] = along.u[i];
            for (int a = 0; a < count; ++a) {
                const T bent = T(0.5) * side * rise(of, found[others[a]].v);
                curved[a][b] += bent;
                curved[b][a] += bent;
            }
        }
        if (count == 0) return;
        const T half = T(0.5) * (curved[0][0] - curved[1][1]), mixed = curved[0][1];
        const T mean = T(0.5) * (curved[0][0] + curved[1][1]);
        const T most_bent = count == 1 ? curved[0][0] : mean + sqrt(half * half + mixed * mixed);
        const T leaving = much * clamped(most_bent * absolute(share) / rise_whole<T>, T(0), T(1));
        if (!(leaving > along.leaving)) return;
        T first = T(1), second = T(0);
        if (count == 2) {
            first = half > T(0) ? most_bent - curved[1][1] : mixed;
            second = half > T(0) ? mixed : most_bent - curved[0][0];
        }
        T motion[most] = {}, done = T(0);
        const T along_both[2] = {first, second};
        for (int b = 0; b < count; ++b)
            for (int k = 0; k < n(); ++k) motion[k] += along_both[b] * found[others[b]].v[k];
        const T length = norm(motion, n());
        if (!(length > nothing<T>)) return;
        for (int k = 0; k < n(); ++k) motion[k] = motion[k] / length;
        for (int i = 0; i < 3; ++i) done += asked[i] * times(J, i, motion);
        if (done < T(0)) side = -side;
        along.sigma = T(0);
        along.edge = greatest(bounds.below, T(2) * turn_of(motion) / precedence<T>);
        along.leaving = leaving;
        for (int k = 0; k < n(); ++k) along.v[k] = side * motion[k];
    }

    /// How fast a motion turns the tool.
    T turn_of(const T* motion) const {
        T rotated[3];
        for (int i = 0; i < 3; ++i) rotated[i] = times(J, i + 3, motion);
        return norm(rotated, 3);
    }

    /// How far the joints may move along a unit motion before one is at its limit [scaled rad], 1 at most.
    T way_left(const T* motion, T side) const {
        T least_way = T(1);
        for (int k = 0; k < n(); ++k) {
            const T speed = side * motion[k] * bounds.unit[k];
            if (!(absolute(side * motion[k]) > no_share<T>)) continue;
            const int row = bounds.motion.motors + k;
            const T room = speed > T(0) ? bounds.motion.upper[row] - posture[k] : posture[k] - bounds.motion.lower[row];
            least_way = least(least_way, greatest(room, T(0)) / absolute(speed));
        }
        return least_way;
    }

    /// Leaves of the ways out what the arm really takes at the rates x, which the other levels bend. Answers whether less.
    bool take_back(const T* x) {
        const T size = norm(x, n());
        if (!(size > nothing<T>)) return false;
        T motion[most];
        for (int k = 0; k < n(); ++k) motion[k] = x[k] / size;
        bool less = false;
        for (int d = 0; d < rank; ++d) {
            if (!(found[d].leaving > T(0))) continue;
            const T rising = clamped(rise(found[d], motion) / rise_moving<T>, T(0), T(1));
            less = less || rising < T(1);
            found[d].leaving *= rising;
        }
        if (less) lead();
        return less;
    }

    /// What leaves a singularity a little farther on.
    void leave_as(const rate_solver& other) {
        rank = other.rank;
        turning = other.turning;
        for (int d = 0; d < rank; ++d) found[d] = other.found[d];
    }

    /// The rows as they will be.
    void lead() {
        copy(held_nearly_lost ? rows_held : J, rows_leaving);
        turning = T(0);
        for (int d = 0; bounds.stops && of_position && d < rank; ++d) turning = greatest(turning, found[d].leaving);
        for (int d = 0; d < rank; ++d)
            for (int i = 0; i < 6; ++i)
                for (int k = 0; k < n() && !levels.held[i]; ++k)
                    rows_leaving[i][k] += found[d].leaving * (found[d].edge - found[d].sigma) * found[d].u[i] * found[d].v[k];
    }

    /// Of what is lost (6,) the square of the part along singular directions, and the first of the joints that move most
    /// along them, −1 where none does.
    T singular_part(const T* lost, int& joint) const {
        T sum = T(0), gravest = T(0);
        for (int d = 0; d < rank; ++d) {
            if (!(found[d].sigma < bounds.below)) continue;
            T part = T(0);
            for (int i = 0; i < 6; ++i) part += (T(1) - found[d].leaving) * found[d].u[i] * lost[i];
            sum += part * part;
            if (!(part * part > gravest)) continue;
            gravest = part * part;
            joint = -1;
            T farthest = T(0);
            for (int k = 0; k < n(); ++k) {
                if (!(absolute(found[d].v[k]) > farthest + equally<T>)) continue;
                farthest = absolute(found[d].v[k]);
                joint = k;
            }
        }
        return sum;
    }

    /// Of what is lost (6,) all but what the arm is about to have again, because it leaves a singularity.
    void without_ways_out(const T* lost, T* rest) const {
        for (int i = 0; i < 6; ++i) rest[i] = lost[i];
        for (int d = 0; d < rank; ++d) {
            T part = T(0);
            for (int i = 0; i < 6; ++i) part += found[d].leaving * found[d].u[i] * lost[i];
            for (int i = 0; i < 6; ++i) rest[i] -= part * found[d].u[i];
        }
    }

    /// How much lower a level counts than the first.
    T weight_of(int level) const {
        T weight = T(1);
        for (int l = 0; l < level; ++l) weight = weight / (n() < 6 ? precedence<T> : precedence_of_six<T>);
        return weight;
    }

    T times(const six_rows<T, N>& rows, int row, const T* rates) const {
        T sum = T(0);
        for (int k = 0; k < n(); ++k) sum += rows[row][k] * rates[k];
        return sum;
    }

    /// What the rates x leave of what is asked.
    void rest(const six_rows<T, N>& rows, const T* asked, const T* x, T* left) const {
        for (int i = 0; i < 6; ++i) left[i] = asked[i] - times(rows, i, x);
    }

    /// Whether the tool moves along what is asked at the rates x, if slower, but for a thousandth beside it. An arm of
    /// fewer than six joints may turn its tool on the way, unless turning is all that is asked.
    bool keeps_course(const T* asked, const T* x) const {
        const int count = n() >= 6 || !(norm(asked, 3) > T(0)) ? 6 : 3;
        T done[6], along = T(0);
        const T size = norm(asked, count);
        for (int i = 0; i < count; ++i) {
            done[i] = times(rows_leaving, i, x);
            along += done[i] * asked[i];
        }
        along = clamped(along / greatest(size * size, nothing<T> * nothing<T>), T(0), T(1));
        for (int i = 0; i < count; ++i) done[i] -= along * asked[i];
        return norm(done, count) <= off_course<T> * size;
    }

    /// The rates x within the bounds for what is asked, and where they stand. Sums of squares, each level weighed by its
    /// last norm until that stands: E. Weiszfeld, Tôhoku Math. J. 43, 1937. (Rounds that go on as the last two went take
    /// half as many, but where they end jumps from step to step, and the arm shook.)
    void operator()(const T* asked, const T* lower, const T* upper, sides<most>& at, T* x,
                    half_spaces<T, most>* near = nullptr) const {
        for (int k = 0; k < n(); ++k) {
            x[k] = clamped(T(0), lower[k], upper[k]);
            at[k] = 0;
        }
        for (int i = 0; near != nullptr && i < near->count; ++i) near->on[i] = false;
        go_on(asked, lower, upper, most_rounds, at, x, near);
    }

    /// At most so many rounds from the rates x. near: what the rates are to keep beside their bounds.
    void go_on(const T* asked, const T* lower, const T* upper, int rounds, sides<most>& at, T* x,
               half_spaces<T, most>* near = nullptr) const {
        const T tip = rounded_off<T> * norm(asked, 6);
        if (!(tip * tip > T(0))) return;  // nothing, or so little that its square is
        for (int round = 0; round < rounds; ++round) {
            T H[most][most], r[most], before[most], change = T(0), size = T(0);
            weigh(asked, x, tip, H, r);
            for (int k = 0; k < n(); ++k) before[k] = x[k];
            least_within(H, r, lower, upper, n(), at, x, near);
            for (int k = 0; k < n(); ++k) {
                change = greatest(change, absolute(x[k] - before[k]));
                size = greatest(size, absolute(x[k]));
            }
            if (change <= unchanged<T> * size) return;
        }
    }

    /// The rates x that take what is held back by so much, if nothing else is asked.
    void take_back_held(const T* error, T* x) const {
        T H[most][most], r[most];
        begin(H, r);
        press(0, firmness<T>, error, H, r);
        mirror(H);
        solve_ldl(H, r, n());
        for (int k = 0; k < n(); ++k) x[k] = r[k];
    }

  private:
    void begin(T (&H)[most][most], T* r) const {
        for (int a = 0; a < n(); ++a) {
            r[a] = T(0);
            for (int b = 0; b <= a; ++b) H[a][b] = (a == b ? damping : T(0)) + (held_nearly_lost ? held_damping[a][b] : T(0));
        }
    }
    /// Adds what a level that counts so much wants.
    void press(int level, T counts, const T* asked, T (&H)[most][most], T* r) const {
        for (int i = 0; i < levels.size[level]; ++i) {
            const int c = levels.component[level][i];
            for (int a = 0; a < n(); ++a) {
                const T heavy = counts * rows_leaving[c][a];
                r[a] += heavy * asked[c];
                for (int b = 0; b <= a; ++b) H[a][b] += heavy * rows_leaving[c][b];
            }
        }
    }
    void mirror(T (&H)[most][most]) const {
        for (int a = 0; a < n(); ++a)
            for (int b = 0; b < a; ++b) H[b][a] = H[a][b];
    }

    /// Where the arm keeps to its course it leaves a singularity at what rates that takes.
    void undamp(T (&H)[most][most]) const {
        for (int d = 0; d < rank; ++d)
            for (int a = 0; a < n(); ++a)
                for (int b = 0; b <= a; ++b) H[a][b] -= damping * found[d].leaving * found[d].v[a] * found[d].v[b];
    }

    /// H = Jᵀ Ω J + τ and r = Jᵀ Ω V with Ω = w / |V − J x|, level by level.
    void weigh(const T* asked, const T* x, T tip, T (&H)[most][most], T* r) const {
        begin(H, r);
        if (bounds.stops) undamp(H);
        T left[6];
        rest(rows_leaving, asked, x, left);
        for (int level = 0; level < levels.count; ++level) {
            T square = tip * tip;
            for (int i = 0; i < levels.size[level]; ++i) {
                const T part = left[levels.component[level][i]];
                square += part * part;
            }
            T counts = level == 0 && levels.holds ? firmness<T> : weight_of(level) / sqrt(square);
            if (level > 0 && levels.component[level][0] >= 3) counts *= T(1) - turning;
            press(level, counts, asked, H, r);
        }
        mirror(H);
    }
};
}  // namespace servo_detail

TWISTARM_END
