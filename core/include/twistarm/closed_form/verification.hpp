// Candidates made into answers: corrected by forward kinematics, verified, compared; joints that may go on moving.
#pragma once

#include "../ik/ranges.hpp"
#include "../ik/residual.hpp"
#include "../kinematics/singular_directions.hpp"
#include "../numeric/ldl.hpp"
#include "solved_arm.hpp"

TWISTARM_BEGIN

/// An answer: θ, its distance from the start, and, as bits, the coordinates that may change while the target stays reached.
template <class T, int N> struct configuration {
    T theta[capacity(N)];
    std::uint64_t free;
    bool family;  ///< whether it may move for itself, not only for what was held
    T distance;
    bool inside;
};

namespace closed_form {

/// Thresholds for zero, in m and rad. src/twistarm/ik/closed_form/roots.py has the same for double.
template <class T> struct precision {
    static constexpr int steps = 30;               ///< of Newton's, for a candidate
    static constexpr int patience = 8;             ///< for steps that gain little, along a direction that hardly moves the tool
    static constexpr T longest = T(0.3);           ///< step: a candidate is near its answer or none
    static constexpr T near = T(0.05);             ///< so far a candidate of an exact family misses, at most
    static constexpr T rounding = T(is_double<T> ? 1e-14 : 1e-6);     ///< of forward kinematics
    static constexpr T singular = T(is_double<T> ? 1e-12 : 1e-5);      ///< singular values below this part are none
    static constexpr T dependent = T(is_double<T> ? 1e-6 : 1e-3);     ///< and below this move nothing at first
    static constexpr T regular = T(is_double<T> ? 1e11 : 1e5);        ///< squares of singular values, the largest over the least
    static constexpr T same = T(is_double<T> ? 1e-5 : 3e-3);          ///< nearer together, two answers may be one
    static constexpr T halfway = T(is_double<T> ? 1e-13 : 3e-6);      ///< if halfway between the target is reached so well,
    static constexpr T twins = T(1e-2);            ///< and so near if it is reached to the tolerances there
    static constexpr T at_limit = T(is_double<T> ? 1e-5 : 3e-3);      ///< an answer beyond by less may be at the limit:
                                                                     ///< a multiple root is known no better,
    static constexpr T on_limit = T(is_double<T> ? 1e-11 : 1e-6);     ///< and by so little meets the target there too
    static constexpr T sidestep = T(0.05);         ///< along a singular direction, where a family is looked for
    static constexpr T alike = T(is_double<T> ? 1e-12 : 1e-5);        ///< members of a family miss by less,
    static constexpr T hardly = T(is_double<T> ? 1e-10 : 1e-4);       ///< or by so much at most where the first does too
    static constexpr T moved = T(is_double<T> ? 1e-6 : 1e-3);
};

enum class relation { different, twins, same };

/// Forward kinematics as the judge of one target: how far configurations miss it, and Newton's steps toward it.
template <target_kind Kind, class T, int N, int M> class judge {
public:
    static constexpr int rows = rows_of(Kind), width = capacity(N);

    judge(const chain<T, N, M>& arm, const solved_arm<T, N>& solved, const target<T>& asked, T position_tolerance,
          T orientation_tolerance)
        : arm_(arm), aim_(aim_at(arm, asked)), position_(position_tolerance),
          chord_(T(2) * static_cast<T>(__builtin_sin(0.5 * static_cast<double>(least(orientation_tolerance, T(3.1415926)))))) {
        for (int i = 0; i < solved.family.count; ++i)
            if (solved.joint[i] >= 0) moving_[count_++] = solved.joint[i];
    }

    /// Whether θ misses the target by no more than `position` [m] and `chord` [2 sin(φ/2)].
    bool meets(const T* theta, T position, T chord) const {
        residual<T, N, rows> missed;
        miss(theta, missed);
        return meets(missed, position, chord);
    }
    bool meets(const T* theta) const { return meets(theta, position_, chord_); }

    /// Whether two answers are one. They are near each other up to whole turns, and their midpoint meets the target as
    /// well, or to rounding. They are twins if the midpoint meets it within the tolerances.
    __attribute__((noinline, cold)) relation compare(const ranges<T, N>& range, const T* a, const T* b) const {
        T difference[width], between[width], farthest = T(0);
        if (!differences(range, a, b, difference)) return relation::different;
        for (int k = 0; k < arm_.coordinates(); ++k) {
            between[k] = b[k] + T(0.5) * difference[k];
            farthest = greatest(farthest, absolute(difference[k]));
        }
        const T most = greatest(greatest(precision<T>::halfway, T(2) * missed(a)), T(2) * missed(b));
        if (farthest <= precision<T>::same && missed(between) <= most) return relation::same;
        return meets(between) ? relation::twins : relation::different;
    }

    /// In which lanes θ is so near an answer, whole turns left aside, that it may be the same.
    template <class V> unsigned near_to(const ranges<T, N>& range, const V* theta, const T* answer) const {
        V difference[width];
        return differences(range, theta, answer, difference);
    }

    /// A register of configurations after one Newton step, if one of them needs it. Tells which of them have only
    /// rounding errors far from singularities, and which were near enough before the step to be answers.
    template <class V> void step(V* theta, unsigned& done, unsigned& near) const {
        constexpr T far = precision<T>::near;
        const int n = arm_.coordinates();
        const aim<V> aims = aim_in_every_lane<V>(aim_);
        column<V> columns[width];
        residual<V, N, rows> missed;
        frame<V> g;
        walk_with_columns(arm_, aims.base, aims.tip, theta, g, columns);
        residual_of<Kind, N>(g, columns, n, aims, T(1), missed);
        near = bits((missed.position_squared < V(far * far)) & (missed.rotation_squared < V(far * far)));
        V H[most_unknowns][most_unknowns], y[most_unknowns], trace = V(T(0)), longest = V(precision<T>::longest);
        TWISTARM_UNROLL
        for (int i = 0; i < count_; ++i) {
            const V* const row = missed.J[moving_[i]];
            y[i] = V(T(0));
            for (int k = 0; k < rows; ++k) y[i] = y[i] - row[k] * missed.e[k];
            TWISTARM_UNROLL
            for (int j = 0; j <= i; ++j) {
                const V* const other = missed.J[moving_[j]];
                V sum = row[0] * other[0];
                for (int k = 1; k < rows; ++k) sum = sum + row[k] * other[k];
                H[i][j] = sum;
            }
            trace = trace + H[i][i];
        }
        solve_ldl(H, y, count_);
        for (int i = 0; i < count_; ++i) longest = greatest(longest, absolute(y[i]));
        V worst = V(T(0));
        for (int k = 0; k < rows; ++k) worst = greatest(worst, absolute(missed.e[k]));
        auto good = trace_of_inverse(H, count_) * trace < V(precision<T>::regular);
        for (int i = 0; i < count_; ++i) good = good & (H[i][i] > V(T(0)));
        const V enough = V(T(10) * precision<T>::rounding);
        done = bits(good & (worst <= enough));
        if (all(good & (worst <= enough))) return;
        const V share = precision<T>::longest / longest;
        for (int i = 0; i < count_; ++i) theta[moving_[i]] = theta[moving_[i]] + select(good, y[i] * share, V(T(0)));
        walk(arm_, aims.base, aims.tip, theta, g);
        residual_of<Kind, N>(g, columns, 0, aims, T(1), missed);
        worst = V(T(0));
        for (int k = 0; k < rows; ++k) worst = greatest(worst, absolute(missed.e[k]));
        done = bits(good & (worst <= enough));
    }

    /// θ after Newton steps of least length, −J⁺ e; at most `patience` of them may gain little. Returns whether the
    /// target is reached. singular: smaller singular values, as a part of the largest, are ignored. still: the coordinates,
    /// as bits, that stay.
    bool correct(T* theta, int patience = precision<T>::patience, T singular = precision<T>::singular,
                 std::uint64_t still = 0) const {
        residual<T, N, rows> missed;
        T best = static_cast<T>(__builtin_inf());
        int in_vain = 0;
        for (int step = 0; step < precision<T>::steps; ++step) {
            with_rows(theta, missed);
            const T worst = largest(missed);
            if (!(worst > precision<T>::rounding)) break;
            if (worst > T(0.9) * best && ++in_vain > patience) break;
            best = least(best, worst);
            for (int i = 0; i < count_; ++i)
                for (int k = 0; k < rows && (still >> moving_[i] & 1U) != 0U; ++k) missed.J[moving_[i]][k] = T(0);
            T move[most_unknowns];
            pseudo_inverse_step(missed, singular, move);
            for (int i = 0; i < count_; ++i) theta[moving_[i]] += move[i];
        }
        return meets(theta);
    }

    /// Whether the target can be reached inside the limits with the coordinates that exceed a limit moved to it. θ is then
    /// that answer.
    bool meet_at_limits(const ranges<T, N>& range, T* theta) const {
        std::uint64_t still = 0;
        for (int pass = 0; pass <= arm_.coordinates(); ++pass) {
            const std::uint64_t before = still;
            for (int k = 0; k < arm_.coordinates(); ++k) {
                const T there = clamped(theta[k], range.lower[k], range.upper[k]);
                if (there < theta[k] || there > theta[k]) still |= std::uint64_t{1} << k;
                theta[k] = there;
            }
            if (meets(theta)) return true;
            if (pass > 0 && still == before) return false;
            correct(theta, 3, precision<T>::singular, still);
        }
        return false;
    }

    /// The coordinates that move while the target stays reached.
    ///
    /// If the rows of the Jacobian are dependent, some direction moves nothing to first order. The code takes a step
    /// along it and corrects the result. If the result is a different answer that is as exact, both belong to a family.
    /// An answer also counts as exact if a whole turn along the direction stays within the tolerances.
    std::uint64_t self_motion(const T* theta) const {
        residual<T, N, rows> missed;
        six_rows<T, most_unknowns> columns;
        T X[6][6], size[6], beside[width];
        with_rows(theta, missed);
        const T most = decompose(missed, columns, X, size);
        const T alike = greatest(precision<T>::alike, least(T(2) * this->missed(theta), precision<T>::hardly));
        const T loosened = T(0.5) * precision<T>::sidestep;
        std::uint64_t moving = 0;
        for (int i = 0; i < count_; ++i) {
            if (size[i] > precision<T>::dependent * most) continue;
            for (int k = 0; k < arm_.coordinates(); ++k) beside[k] = theta[k];
            for (int j = 0; j < count_; ++j) beside[moving_[j]] += precision<T>::sidestep * X[j][i];
            if (!correct(beside, precision<T>::patience, precision<T>::dependent)) continue;
            if (this->missed(beside) > alike && !meets(beside, loosened * position_, loosened * chord_)) continue;
            std::uint64_t changed = 0;
            T square = T(0);
            for (int j = 0; j < count_; ++j) {
                const T away = absolute(beside[moving_[j]] - theta[moving_[j]]);
                square += away * away;
                if (away > precision<T>::moved) changed |= std::uint64_t{1} << moving_[j];
            }
            if (sqrt(square) > T(0.5) * precision<T>::sidestep) moving |= changed;
        }
        return moving;
    }

private:
    /// a − b without whole turns, and, as bits, the lanes where it is small. If there are none, the difference is
    /// incomplete.
    template <class V> unsigned differences(const ranges<T, N>& range, const V* a, const T* b, V* difference) const {
        auto near = in_every_lane<V>(true);
        for (int k = 0; k < arm_.coordinates(); ++k) {
            difference[k] = a[k] - b[k];
            if (range.periodic[k]) difference[k] = difference[k] - T(whole_turn) * nearest_whole(difference[k] * T(1.0 / whole_turn));
            near = near & (absolute(difference[k]) <= V(precision<T>::twins));
            if (!any(near)) return 0;
        }
        return bits(near);
    }

    static bool meets(const residual<T, N, rows>& missed, T position, T chord) {
        return missed.position_squared <= position * position && missed.rotation_squared <= chord * chord;
    }

    static T largest(const residual<T, N, rows>& missed) {
        T worst = T(0);
        for (T component : missed.e)
            if (!(absolute(component) <= worst)) worst = absolute(component);
        return worst;
    }

    /// The larger of both errors.
    T missed(const T* theta) const {
        residual<T, N, rows> off;
        miss(theta, off);
        return sqrt(greatest(off.position_squared, off.rotation_squared));
    }

    void miss(const T* theta, residual<T, N, rows>& missed) const {
        frame<T> g;
        column<T> columns[1];
        walk(arm_, aim_.base, aim_.tip, theta, g);
        residual_of<Kind, N>(g, columns, 0, aim_, T(1), missed);
    }

    void with_rows(const T* theta, residual<T, N, rows>& missed) const {
        frame<T> g;
        column<T> columns[width];
        walk_with_columns(arm_, aim_.base, aim_.tip, theta, g, columns);
        residual_of<Kind, N>(g, columns, arm_.coordinates(), aim_, T(1), missed);
    }

    /// J X = `columns`, orthogonal, column i of length size[i]; the greatest length.
    T decompose(const residual<T, N, rows>& missed, six_rows<T, most_unknowns>& columns, T X[6][6], T size[6]) const {
        for (int i = 0; i < count_; ++i)
            for (int k = 0; k < rows; ++k) columns[i][k] = missed.J[moving_[i]][k];
        make_orthogonal<T, most_unknowns>(columns, count_, rows, X);
        T most = T(0);
        for (int i = 0; i < count_; ++i) {
            T square = T(0);
            for (int k = 0; k < rows; ++k) square += columns[i][k] * columns[i][k];
            size[i] = sqrt(square);
            most = greatest(most, size[i]);
        }
        return most;
    }

    /// Limits the step in each direction that J distinguishes. If one direction hardly moves the tool, as near a straight
    /// wrist, the others still take their full step.
    void pseudo_inverse_step(const residual<T, N, rows>& missed, T singular, T move[6]) const {
        six_rows<T, most_unknowns> columns;
        T X[6][6], size[6];
        const T most = decompose(missed, columns, X, size);
        for (int j = 0; j < count_; ++j) move[j] = T(0);
        for (int i = 0; i < count_; ++i) {
            if (!(size[i] > singular * most)) continue;
            T share = T(0);
            for (int k = 0; k < rows; ++k) share -= columns[i][k] * missed.e[k];
            share = clamped(share / (size[i] * size[i]), -precision<T>::longest, precision<T>::longest);
            for (int j = 0; j < count_; ++j) move[j] += share * X[j][i];
        }
    }

    const chain<T, N, M>& arm_;
    aim<T> aim_;
    T position_, chord_;
    int moving_[most_unknowns], count_ = 0;
};

}  // namespace closed_form

TWISTARM_END
