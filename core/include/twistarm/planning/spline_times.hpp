// The times between a spline's waypoints: as short a motion as limits of velocity, acceleration and jerk allow.
//
// The spline of degree 2 R + 1 (cubic, quintic) through waypoints at given times, at rest at both ends, is the one of least
// ∫ |q^(R+1)|² dt: the R derivatives at each inner waypoint solve a banded, positive definite system. A motion f times as
// slow meets its limits, where f is the largest of its rates, each as a share of its limit, to the power of 1 over its order.
// Σ d · f does not change when all durations d are multiplied by one number; it is made least in x = log d, with a p-norm in
// the place of the largest and its gradient by the adjoint of the system.
#pragma once

#include "../numeric/quasi_newton.hpp"

TWISTARM_BEGIN

/// The ways of r rows (joints, motors) on each segment, and their limits of each order; null for none.
template <class T> struct spline_ways {
    int segments, rows;
    const T *way, *limits[3];  // (segments, rows), (rows) each
};

namespace detail {
/// Places in each segment at which rates are looked at.
constexpr int spline_looks = 17;

/// Rates below this part of the largest are ignored: as a power they are less than 1e-7 of the sum.
template <class T> constexpr T least_weight = T(1e-7);

/// Common data of the segments of all splines of one degree, in unit time. A segment's ends (2 R + 1) are the
/// derivatives of order 1 … R at the start, the way, and the derivatives at the end.
template <class T, int R> struct spline_segment {
    static constexpr int ends = 2 * R + 1, degree = 2 * R + 1;
    T look[3][spline_looks][ends];  // a rate of each order, at each place
    T energy[ends][ends];           // ∫ of the products of the derivatives of order R + 1

    static constexpr int order(int end) { return end < R ? end + 1 : end == R ? 0 : end - R; }

    spline_segment() {
        T powers[ends][degree + 1];  // of each end, the lowest first
        for (int k = 0; k < ends; ++k) {
            T e[ends] = {};
            e[k] = T(1);
            polynomial(e, powers[k]);
        }
        for (int o = 1; o <= 3; ++o)
            for (int m = 0; m < spline_looks; ++m)
                for (int k = 0; k < ends; ++k) {
                    const T at = T(m) / T(spline_looks - 1);
                    T sum = T(0);
                    for (int p = degree; p >= o; --p) sum = sum * at + falling(p, o) * powers[k][p];
                    look[o - 1][m][k] = sum;
                }
        for (int k = 0; k < ends; ++k)
            for (int l = 0; l < ends; ++l) {
                energy[k][l] = T(0);
                for (int p = R + 1; p <= degree; ++p)
                    for (int q = R + 1; q <= degree; ++q)
                        energy[k][l] += falling(p, R + 1) * powers[k][p] * falling(q, R + 1) * powers[l][q] /
                                        T(p + q - 2 * R - 1);
            }
    }

private:
    static constexpr T falling(int p, int order) {
        T product = T(1);
        for (int k = 0; k < order; ++k) product *= T(p - k);
        return product;
    }
    static void polynomial(const T* e, T* c) {
        const T v = e[0], a = R == 2 ? e[R - 1] : T(0), bent = R == 2 ? T(0.5) * (e[ends - 1] - a) : T(0);
        const T way = e[R] - v - T(0.5) * a, faster = e[R + 1] - v - a;
        c[0] = T(0);
        c[1] = v;
        if constexpr (R == 1) {
            c[2] = T(3) * way - faster;
            c[3] = faster - T(2) * way;
        } else {
            c[2] = T(0.5) * a;
            c[3] = T(10) * way - T(4) * faster + bent;
            c[4] = T(-15) * way + T(7) * faster - T(2) * bent;
            c[5] = T(6) * way - T(3) * faster + bent;
        }
    }
};
}  // namespace detail

/// How long a spline takes, as a function of the logarithms of its durations.
template <class T, int R> class spline_times {
public:
    /// How many numbers it needs beside its own.
    static std::size_t room(int segments, int rows) {
        const std::size_t s = static_cast<std::size_t>(segments), r = static_cast<std::size_t>(rows);
        return s * (2 + R * band + (2 * R + 2 * ends + 3 * detail::spline_looks) * r);
    }

    spline_times(const spline_ways<T>& ways, T* room)
        : ways_(ways), rows_(ways.rows), unknowns_((ways.segments - 1) * R), best_value_(T(0)), tried_(false) {
        const int s = ways.segments, states = R * s * rows_, all = ends * s * rows_;
        d_ = room;
        best_ = d_ + s;
        band_ = best_ + s;
        states_ = band_ + band * R * s;
        adjoint_ = states_ + states;
        e_ = adjoint_ + states;
        slope_ = e_ + all;
        rates_ = slope_ + all;
    }

    /// The logarithm of the time, with a norm of the power 2^squarings, and its gradient.
    T operator()(const T* x, int squarings, T* gradient) {
        spread(x);
        factorise();
        for (int k = 0; k < unknowns_ * rows_; ++k) states_[k] = T(0);
        for_unknowns([&](int i, int k, int unknown) {
            const T pull = -shared_.energy[k][R] * power(d_[i], Segment::order(k) - Segment::degree);
            for (int r = 0; r < rows_; ++r) states_[unknown * rows_ + r] += pull * ways_.way[i * rows_ + r];
        });
        solve(states_);
        see_ends();
        const T largest = see_rates();
        T sum = T(0);
        for (int i = 0; i < ways_.segments; ++i) sum += d_[i];
        const T exact = __builtin_log(sum * largest);
        if (!tried_ || exact < best_value_) {
            tried_ = true;
            best_value_ = exact;
            for (int i = 0; i < ways_.segments; ++i) best_[i] = d_[i];
        }
        const T total = weigh(largest, squarings, gradient);
        for (int i = 0; i < ways_.segments; ++i) gradient[i] = gradient[i] / total + d_[i] / sum;
        follow(total, gradient);
        return exact + __builtin_log(total) / T(1 << squarings);
    }

    /// The durations (segments) of the shortest motion found, up to a common factor.
    const T* best() const { return best_; }

private:
    using Segment = detail::spline_segment<T, R>;
    static constexpr int ends = Segment::ends, band = 2 * R;

    static T power(T base, int exponent) {
        T product = T(1);
        for (int k = exponent < 0 ? -exponent : exponent; k > 0; --k) product *= base;
        return exponent < 0 ? T(1) / product : product;
    }

    /// Durations of about 1, in any unit of time.
    void spread(const T* x) {
        T mean = T(0);
        for (int i = 0; i < ways_.segments; ++i) mean += x[i] / T(ways_.segments);
        for (int i = 0; i < ways_.segments; ++i) d_[i] = __builtin_exp(x[i] - mean);
    }

    /// body(segment, end, unknown) for every end that is unknown.
    template <class Body> void for_unknowns(Body&& body) const {
        for (int i = 0; i < ways_.segments; ++i)
            for (int k = 0; k < ends; ++k) {
                const int unknown = unknown_of(i, k);
                if (unknown >= 0) body(i, k, unknown);
            }
    }
    int unknown_of(int i, int k) const {
        if (k < R) return i > 0 ? (i - 1) * R + k : -1;
        return k > R && i < ways_.segments - 1 ? i * R + k - R - 1 : -1;
    }

    T& entry(int i, int j) { return band_[i * band + i - j]; }

    /// The system as L D Lᵀ, D on the diagonal.
    void factorise() {
        for (int k = 0; k < unknowns_ * band; ++k) band_[k] = T(0);
        for_unknowns([&](int i, int k, int unknown) {
            for (int l = 0; l < ends; ++l) {
                const int other = unknown_of(i, l);
                if (other >= 0 && other <= unknown)
                    entry(unknown, other) += shared_.energy[k][l] *
                                             power(d_[i], Segment::order(k) + Segment::order(l) - Segment::degree);
            }
        });
        for (int i = 0; i < unknowns_; ++i) {
            const int first = i < band ? 0 : i - band + 1;
            for (int j = first; j <= i; ++j) {
                T left = entry(i, j);
                for (int k = first; k < j; ++k)
                    if (j - k < band) left -= entry(i, k) * entry(j, k) * entry(k, k);
                entry(i, j) = j < i ? left / entry(j, j) : left;
            }
        }
    }

    /// The unknowns (unknowns, rows) of right sides, in their place.
    void solve(T* b) {
        for (int i = 0; i < unknowns_; ++i)
            for (int j = i < band ? 0 : i - band + 1; j < i; ++j)
                for (int r = 0; r < rows_; ++r) b[i * rows_ + r] -= entry(i, j) * b[j * rows_ + r];
        for (int i = unknowns_ - 1; i >= 0; --i) {
            for (int r = 0; r < rows_; ++r) b[i * rows_ + r] /= entry(i, i);
            for (int j = i + 1; j < unknowns_ && j - i < band; ++j)
                for (int r = 0; r < rows_; ++r) b[i * rows_ + r] -= entry(j, i) * b[j * rows_ + r];
        }
    }

    /// Every segment's ends in unit time.
    void see_ends() {
        for (int i = 0; i < ways_.segments; ++i)
            for (int k = 0; k < ends; ++k) {
                const int unknown = unknown_of(i, k);
                const T scale = power(d_[i], Segment::order(k));
                T* const e = e_ + (i * ends + k) * rows_;
                for (int r = 0; r < rows_; ++r)
                    e[r] = k == R ? ways_.way[i * rows_ + r] : unknown < 0 ? T(0) : scale * states_[unknown * rows_ + r];
            }
    }

    T* rates(int i, int o, int m) { return rates_ + ((i * 3 + o) * detail::spline_looks + m) * rows_; }

    /// The largest rate, as by what the motion must be slowed.
    T see_rates() {
        T largest = T(0);
        for (int o = 0; o < 3; ++o) {
            if (!ways_.limits[o]) continue;
            for (int i = 0; i < ways_.segments; ++i) {
                const T faster = T(1) / power(d_[i], o + 1);
                T most = T(0);
                for (int m = 0; m < detail::spline_looks; ++m) {
                    T* const rate = rates(i, o, m);
                    for (int r = 0; r < rows_; ++r) rate[r] = T(0);
                    for (int k = 0; k < ends; ++k)
                        for (int r = 0; r < rows_; ++r)
                            rate[r] += shared_.look[o][m][k] * e_[(i * ends + k) * rows_ + r];
                    for (int r = 0; r < rows_; ++r) {
                        rate[r] *= faster / ways_.limits[o][r];
                        const T size = rate[r] < T(0) ? -rate[r] : rate[r];
                        if (size > most) most = size;
                    }
                }
                most = root(most, o + 1);
                if (most > largest) largest = most;
            }
        }
        return largest;
    }

    static T root(T share, int order) {
        return order == 1 ? share : order == 2 ? __builtin_sqrt(share) : __builtin_cbrt(share);
    }

    /// The sum of the powers of all rates over the largest. Its gradient by the ends goes to slope_, that by the
    /// segment lengths to `gradient`; both still have to be divided by the sum.
    T weigh(T largest, int squarings, T* gradient) {
        const T counts = __builtin_exp(__builtin_log(detail::least_weight<T>) / T(1 << squarings));
        T total = T(0);
        for (int k = 0; k < ways_.segments * ends * rows_; ++k) slope_[k] = T(0);
        for (int i = 0; i < ways_.segments; ++i) {
            gradient[i] = T(0);
            for (int o = 0; o < 3; ++o) {
                if (!ways_.limits[o]) continue;
                const T scale = T(1) / power(largest, o + 1), least = power(counts, o + 1);
                const T faster = T(1) / power(d_[i], o + 1);
                for (int m = 0; m < detail::spline_looks; ++m)
                    for (int r = 0; r < rows_; ++r) {
                        const T rate = rates(i, o, m)[r], share = scale * (rate < T(0) ? -rate : rate);
                        if (share < least) continue;
                        T weight = o == 2 ? __builtin_cbrt(share) : share;
                        for (int k = o == 1 ? 1 : 0; k < squarings; ++k) weight *= weight;
                        total += weight;
                        gradient[i] -= weight;
                        const T by_rate = weight / (T(o + 1) * rate) * faster / ways_.limits[o][r];
                        for (int k = 0; k < ends; ++k)
                            slope_[(i * ends + k) * rows_ + r] += by_rate * shared_.look[o][m][k];
                    }
            }
        }
        return total;
    }

    /// Adds to the gradient the change of the ends with the segment lengths: in unit time, and by the system.
    void follow(T total, T* gradient) {
        for (int k = 0; k < unknowns_ * rows_; ++k) adjoint_[k] = T(0);
        for_unknowns([&](int i, int k, int unknown) {
            const T* const slope = slope_ + (i * ends + k) * rows_;
            const T* const e = e_ + (i * ends + k) * rows_;
            const T scale = power(d_[i], Segment::order(k)) / total;
            for (int r = 0; r < rows_; ++r) {
                gradient[i] += T(Segment::order(k)) * slope[r] * e[r] / total;
                adjoint_[unknown * rows_ + r] += scale * slope[r];
            }
        });
        solve(adjoint_);
        for_unknowns([&](int i, int k, int unknown) {
            const T scale = power(d_[i], Segment::order(k) - Segment::degree);
            for (int l = 0; l < ends; ++l) {
                const T moved = scale * shared_.energy[k][l] * T(Segment::order(k) + Segment::order(l) - Segment::degree);
                for (int r = 0; r < rows_; ++r)
                    gradient[i] -= moved * adjoint_[unknown * rows_ + r] * e_[(i * ends + l) * rows_ + r];
            }
        });
    }

    const Segment shared_;
    spline_ways<T> ways_;
    int rows_, unknowns_;
    T best_value_;
    bool tried_;
    T *d_, *best_, *band_, *states_, *adjoint_, *e_, *slope_, *rates_;
};

namespace detail {
/// Powers of the norm, as numbers of squarings. The first sees the whole motion; the last is within a per cent of the
/// largest of many rates. With fewer powers between them, a search stops at one rate after the other.
constexpr int spline_norms[] = {5, 7, 9, 10};
constexpr int most_spline_steps = 60;
template <class T> constexpr T least_spline_gain = T(3e-6);
}  // namespace detail

/// x (segments), the logarithms of durations, made those of as short a motion as is found nearby.
template <class T, int R> void shortest_spline(const spline_ways<T>& ways, T* x, T* room) {
    spline_times<T, R> times(ways, room + least_value_room(ways.segments));
    for (const int squarings : detail::spline_norms)
        least_value(ways.segments, [&](const T* at, T* gradient) { return times(at, squarings, gradient); }, x,
                    detail::most_spline_steps, detail::least_spline_gain<T>, room);
    for (int i = 0; i < ways.segments; ++i) x[i] = __builtin_log(times.best()[i]);
}

/// How many numbers `shortest_spline` needs.
template <class T, int R> std::size_t shortest_spline_room(int segments, int rows) {
    return static_cast<std::size_t>(least_value_room(segments)) + spline_times<T, R>::room(segments, rows);
}

TWISTARM_END
