// Sine, cosine, arc sine and arc tangent against the C library's in long double, in units of the last place.
#include "twistarm/numeric/elementary.hpp"

#include "check.hpp"
#include "plain.hpp"

using namespace twistarm;
using tests::real;

namespace {
/// Bounds [ulp], measured on twenty million angles as 2.24 and 2.23; where the C library is no better, its error too.
constexpr double peer = tests::exact ? 0.0 : 1.0, sine_bound = 2.5 + peer, arcsine_bound = 3.0 + peer;

double ulps(double value, real exact) {
    const double size = std::fabs(static_cast<double>(exact));
    return static_cast<double>(std::fabs(static_cast<real>(value) - exact)) / (std::nextafter(size, INFINITY) - size);
}

/// Small, usual and large angles, and those next to multiples of π/2, where digits cancel.
double drawn_angle(tests::generator& random, int i) {
    const double size = i % 4 == 0 ? 1e4 : (i % 4 == 1 ? 3.2 : 100.0), x = random.between(-size, size);
    if (i % 4 != 3) return x;
    return std::nextafter(std::nearbyint(x) * 1.57079632679489661923, i % 8 == 3 ? 1e9 : -1e9);
}

void test_sines() {
    tests::generator random;
    double worst = 0, worst_float = 0, float_size = 0;
    for (int i = 0; i < 200000; ++i) {
        const double x = drawn_angle(random, i);
        double s, c;
        sincos(x, s, c);
        worst = std::fmax(worst, std::fmax(ulps(s, std::sin(real(x))), ulps(c, std::cos(real(x)))));
        const float y = static_cast<float>(x);
        float fs, fc;
        sincos(y, fs, fc);
        const real error = std::fmax(std::fabs(fs - std::sin(real(y))), std::fabs(fc - std::cos(real(y))));
        worst_float = std::fmax(worst_float, static_cast<double>(error));
        float_size = std::fmax(float_size, std::fabs(static_cast<double>(fs * fs + fc * fc - 1.0F)));
    }
    std::printf("sincos %.2f ulp, float %.1e\n", worst, worst_float);
    CHECK(worst < sine_bound, "%g ulp", worst);
    CHECK(worst_float < 2e-7 && float_size < 5e-7, "%g %g", worst_float, float_size);
}

void test_arcsine() {
    tests::generator random;
    double worst = 0, worst_float = 0;
    for (int i = 0; i < 200000; ++i) {
        const double x = i % 3 == 0 ? std::nextafter(0.5, random.uniform()) : random.uniform();
        worst = std::fmax(worst, ulps(arcsine(x), std::asin(real(x))));
        const float y = static_cast<float>(random.uniform());
        worst_float = std::fmax(worst_float, static_cast<double>(std::fabs(arcsine(y) - std::asin(real(y)))));
    }
    std::printf("arcsine %.2f ulp, float %.1e\n", worst, worst_float);
    CHECK(worst < arcsine_bound, "%g ulp", worst);
    CHECK(worst_float < 5e-7, "%g", worst_float);
    CHECK(arcsine(0.0) == 0.0 && ulps(arcsine(1.0), std::asin(real(1))) <= 1, "ends");
}

void test_arctangent() {
    tests::generator random;
    double worst = 0, worst_float = 0;
    for (int i = 0; i < 200000; ++i) {
        const double size = std::pow(10.0, random.between(-6, 6)), x = random.between(-1, 1), y = size * random.between(-1, 1);
        worst = std::fmax(worst, ulps(arctangent(y, x), std::atan2(real(y), real(x))));
        const float u = static_cast<float>(y), v = static_cast<float>(x);
        worst_float = std::fmax(worst_float, static_cast<double>(std::fabs(arctangent(u, v) - std::atan2(real(u), real(v)))));
    }
    std::printf("arctangent %.2f ulp, float %.1e\n", worst, worst_float);
    CHECK(worst < 4 + peer, "%g ulp", worst);
    CHECK(worst_float < 8e-7, "%g", worst_float);
    CHECK(arctangent(0.0, 0.0) == 0.0 && arctangent(0.0, -1.0) > 3.14 && arctangent(-1.0, 0.0) < -1.57, "ends");
    pack<double, 8> across(0.5), along(-0.25);
    across.set(3, -2.0);
    const pack<double, 8> all = arctangent(across, along);
    for (int l = 0; l < 8; ++l) CHECK(std::fabs(all[l] - arctangent(across[l], along[l])) < 1e-15, "arctangent in lanes");
}

/// Lanes do what numbers alone do, and a far angle or infinity in one leaves the others as they are.
template <class T> void test_lanes() {
    using V = pack<T, 8>;
    tests::generator random;
    for (int i = 0; i < 1000; ++i) {
        V x, s, c;
        for (int l = 0; l < 8; ++l) x.set(l, static_cast<T>(drawn_angle(random, i)));
        if (i % 2 == 0) x.set(3, T(1e7));
        if (i % 5 == 0) x.set(5, static_cast<T>(INFINITY));
        sincos(x, s, c);
        for (int l = 0; l < 8; ++l) {
            T one_s, one_c;
            sincos(x[l], one_s, one_c);
            const bool number = x[l] < T(1e30);
            CHECK(number ? std::fabs(s[l] - one_s) <= T(2e-16) + T(sizeof(T) == 4 ? 2e-7 : 0) &&
                               std::fabs(c[l] - one_c) <= T(2e-16) + T(sizeof(T) == 4 ? 2e-7 : 0)
                         : std::isnan(s[l]) && std::isnan(c[l]),
                  "lane %d of %g", l, static_cast<double>(x[l]));
        }
        const V half = arcsine(absolute(s));
        if (i % 5 != 0) CHECK(std::fabs(half[1] - arcsine(std::fabs(s[1]))) <= T(1e-6), "arcsine in lanes");
    }
    V zero(static_cast<T>(-0.0)), s, c;
    sincos(zero, s, c);
    CHECK(s[6] == T(0) && c[6] == T(1), "zero");
}

}  // namespace

int main() {
    test_sines();
    test_arcsine();
    test_arctangent();
    test_lanes<double>();
    test_lanes<float>();
    return tests::verdict("elementary");
}
