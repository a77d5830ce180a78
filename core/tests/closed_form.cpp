// The equations of closed forms: polynomials and harmonics with roots that were put in. Python's tests judge arms of
// every family, and those of exported headers single precision.
#include "twistarm/closed_form/all_solutions.hpp"

#include <cmath>

#include "check.hpp"

using namespace twistarm;

namespace {
/// Roots of (t - a)(t - b)((t - re)² + im²), each to be found so well.
template <class T> void test_quartic(double a, double b, double re, double im, double tolerance) {
    const double pair[3] = {re * re + im * im, -2 * re, 1}, both[3] = {a * b, -a - b, 1};
    T p[5] = {};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) p[i + k] += static_cast<T>(3 * pair[i] * both[k]);
    closed_form::complex_number<T> t[4];
    closed_form::quartic_roots(p, t);
    const double wanted[4][2] = {{a, 0}, {b, 0}, {re, im}, {re, -im}};
    for (const auto& root : wanted) {
        double nearest = 1e9;
        for (const auto& found : t)
            nearest = std::fmin(nearest, std::hypot(static_cast<double>(found.re) - root[0], static_cast<double>(found.im) - root[1]));
        CHECK(nearest <= tolerance, "(%g, %g) of %g, %g, %g ± %g i is missed by %g", root[0], root[1], a, b, re, im, nearest);
    }
}

template <class T> void test_quartics(tests::generator& random) {
    const bool fine = sizeof(T) == 8;
    for (int repeat = 0; repeat < 200; ++repeat)
        test_quartic<T>(random.between(-2, -1), random.between(1, 2), random.between(-0.5, 0.5), random.between(0.5, 2),
                        fine ? 1e-11 : 2e-3);
    test_quartic<T>(1, 1, -0.5, 0.7, fine ? 1e-6 : 5e-3);  // a double root keeps half of the digits
    test_quartic<T>(1, 1, 1, 0, fine ? 1e-3 : 5e-2);       // a fourfold one a quarter
    test_quartic<T>(0, 0, 0, 1, fine ? 1e-6 : 5e-3);
}

/// An equation with the angle x among its zeros, or touching zero there.
template <class T> void test_second_harmonic(tests::generator& random, bool touches) {
    closed_form::second_harmonic<T> equation{};
    const double x = random.between(-3, 3), c = std::cos(x), s = std::sin(x);
    for (T& coefficient : equation.k) coefficient = static_cast<T>(random.between(-1, 1));
    if (touches) {  // 1 - cos(y - x), times itself and a bit
        const T numbers[6] = {T(1), static_cast<T>(-2 * c), static_cast<T>(-2 * s), static_cast<T>(c * c), static_cast<T>(2 * c * s), static_cast<T>(s * s)};
        for (int i = 0; i < 6; ++i) equation.k[i] = numbers[i];
    }
    equation.k[0] -= equation.at(static_cast<T>(c), static_cast<T>(s));
    double nearest = 1e9;
    for (const auto& found : equation.zeros(closed_form::default_slack<T>))
        nearest = std::fmin(nearest, std::hypot(static_cast<double>(found.cosine) - c, static_cast<double>(found.sine) - s));
    CHECK(nearest <= (touches ? 0.1 : (sizeof(T) == 8 ? 1e-8 : 2e-2)), "%g is missed by %g", x, nearest);
}
}  // namespace

int main() {
    tests::generator random;
    test_quartics<double>(random);
    test_quartics<float>(random);
    for (int repeat = 0; repeat < 200; ++repeat) {
        test_second_harmonic<double>(random, repeat % 4 == 0);
        test_second_harmonic<float>(random, repeat % 4 == 0);
    }
    return tests::verdict("closed_form");
}
