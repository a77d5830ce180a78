// Packs of numbers: arithmetic, comparisons and bit patterns, lane by lane as one number at a time.
#include "twistarm/numeric/lanes.hpp"

#include <cmath>

#include "check.hpp"

using namespace twistarm;

namespace {
template <class T, int L> void test_arithmetic() {
    using V = pack<T, L>;
    T a[L], b[L];
    tests::generator random;
    for (int l = 0; l < L; ++l) {
        a[l] = static_cast<T>(random.between(-9, 9));
        b[l] = l % 3 == 0 ? a[l] : static_cast<T>(random.between(1, 9));
    }
    const V x = gathered<V>(a, 1), y = gathered<V>(b, 1);
    for (int l = 0; l < L; ++l) {
        CHECK((x + y)[l] == a[l] + b[l] && (x - y)[l] == a[l] - b[l], "lane %d", l);
        CHECK((x * y)[l] == a[l] * b[l] && (x / y)[l] == a[l] / b[l] && (-x)[l] == -a[l], "lane %d", l);
        CHECK((x * T(3))[l] == a[l] * T(3) && (T(3) - x)[l] == T(3) - a[l], "lane %d", l);
        CHECK(sqrt(y * y)[l] == std::sqrt(b[l] * b[l]), "lane %d", l);
        CHECK(absolute(x)[l] == std::fabs(a[l]), "lane %d", l);
        CHECK(least(x, y)[l] == std::fmin(a[l], b[l]) && greatest(x, y)[l] == std::fmax(a[l], b[l]), "lane %d", l);
        CHECK(clamped(x, V(T(-2)), V(T(2)))[l] == std::fmin(std::fmax(a[l], T(-2)), T(2)), "lane %d", l);
        CHECK((bits(x < y) >> l & 1U) == (a[l] < b[l]) && (bits(x <= y) >> l & 1U) == (a[l] <= b[l]), "lane %d", l);
        CHECK((bits(x > y) >> l & 1U) == (a[l] > b[l]) && (bits(x >= y) >> l & 1U) == (a[l] >= b[l]), "lane %d", l);
    }
}

template <class T, int L> void test_masks() {
    using V = pack<T, L>;
    V x(T(1));
    x.set(1, T(-1));
    x.set(L - 1, T(-1));
    const auto negative = x < V(T(0));
    const unsigned every = L == 32 ? ~0U : (1U << L) - 1U, some = 2U | 1U << (L - 1);
    CHECK(bits(negative) == some && bits(!negative) == (every & ~some), "%x", bits(negative));
    CHECK(any(negative) && !all(negative) && all(negative | !negative) && !any(negative & !negative), "masks");
    const V chosen = select(negative, V(T(5)), x);
    for (int l = 0; l < L; ++l) CHECK(chosen[l] == ((some >> l & 1U) != 0U ? T(5) : T(1)), "lane %d", l);
}

template <class T> void test_unusual_numbers() {
    using V = pack<T, 8>;
    V x(T(0));
    x.set(2, static_cast<T>(INFINITY));
    x.set(3, static_cast<T>(NAN));
    x.set(4, static_cast<T>(-0.0));
    const unsigned more = bits(x > V(T(1))), less = bits(x <= V(T(1)));
    CHECK(more == 4U && less == 0xF3U, "no comparison holds of a NaN: %x %x", more, less);
    CHECK(std::isnan(select(x > V(T(1)), V(T(0)), x)[3]), "select keeps a NaN");
    CHECK(std::signbit((-x)[0]) && std::signbit(x[4]) && !std::signbit((-x)[4]), "signs of zero");
    const V everywhere(static_cast<T>(-0.0));
    CHECK(everywhere[7] == T(0), "zero in every lane");
}

template <class T> void test_bit_patterns() {
    using V = pack<T, 8>;
    constexpr T rounding = sizeof(T) == 8 ? T(6755399441055744.0) : T(12582912.0);
    V x;
    for (int l = 0; l < 8; ++l) x.set(l, rounding + static_cast<T>(l - 4));
    const auto odd = is_odd(to_bits(x));
    const V flipped = flip_sign(V(T(3)), to_bits(x), 1, 1);
    for (int l = 0; l < 8; ++l) {
        const bool second = ((l - 4 + 1) >> 1 & 1) != 0;
        CHECK((bits(odd) >> l & 1U) == static_cast<unsigned>(l & 1), "lane %d", l);
        CHECK(flipped[l] == (second ? T(-3) : T(3)), "lane %d", l);
        CHECK(flip_sign(T(3), to_bits(x[l]), 1, 1) == flipped[l], "lane %d", l);
        CHECK(is_odd(to_bits(x[l])) == ((l & 1) != 0), "lane %d", l);
    }
}

template <class T> void test_gathering() {
    T rows[8][3];
    for (int l = 0; l < 8; ++l)
        for (int k = 0; k < 3; ++k) rows[l][k] = static_cast<T>(10 * l + k);
    using V = pack<T, 8>;
    const V column = gathered<V>(&rows[0][1], 3);
    for (int l = 0; l < 8; ++l) CHECK(column[l] == rows[l][1] && lane(column, l) == rows[l][1], "lane %d", l);
    CHECK(gathered<T>(&rows[0][2], 3) == T(2), "a scalar is its own only lane");
}
}  // namespace

int main() {
    test_arithmetic<double, 8>();
    test_arithmetic<float, 8>();
    test_arithmetic<float, 16>();
    test_masks<double, 8>();
    test_masks<float, 8>();
    test_masks<double, 4>();
    test_masks<float, 16>();
    test_unusual_numbers<double>();
    test_unusual_numbers<float>();
    test_bit_patterns<double>();
    test_bit_patterns<float>();
    test_gathering<double>();
    test_gathering<float>();
    return tests::verdict("lanes");
}
