// A quadratic within bounds and half-spaces: compared with Hildreth's iteration on the multipliers (Quarterly of Applied
// Mathematics 14, 1957, p. 79–85).
#include "twistarm/numeric/half_spaces.hpp"

#include <cmath>

#include "check.hpp"

using namespace twistarm;

namespace {
constexpr int N = 7, M = most_half_spaces;

struct problem {
    int n;
    double H[N][N], r[N], lower[N], upper[N], x[N];
    half_spaces<double, N> rows;
    sides<N> at;
};

/// H = B Bᵀ + 0.1, bounds about 0, rows that x = 0 keeps, or else by which it is to be moved.
problem made(tests::generator& random, int n, int count, bool moved) {
    problem made{};
    made.n = n;
    made.rows.count = count;
    double B[N][N];
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < n; ++b) B[a][b] = random.between(-1, 1);
        made.r[a] = random.between(-3, 3);
        made.lower[a] = -random.between(0.5, 2);
        made.upper[a] = random.between(0.5, 2);
    }
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            made.H[a][b] = a == b ? 0.1 : 0.0;
            for (int k = 0; k < n; ++k) made.H[a][b] += B[a][k] * B[b][k];
        }
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < n; ++k) made.rows.normal[i][k] = i % 3 == 2 ? made.rows.normal[i - 1][k] : random.between(-1, 1);
        made.rows.most[i] = moved && i == 0 ? -0.01 : random.between(0, 0.5);
    }
    return made;
}

/// Of least ½ xᵀ H x − rᵀ x, by raising one multiplier after the other.
void by_multipliers(const problem& of, double* x) {
    const int n = of.n, all = of.rows.count + 2 * n;
    double G[M + 2 * N][N] = {}, h[M + 2 * N], Z[M + 2 * N][N], raised[M + 2 * N] = {};
    for (int i = 0; i < all; ++i) {
        const int k = (i - of.rows.count) / 2, side = (i - of.rows.count) % 2;
        for (int a = 0; a < n; ++a) G[i][a] = i < of.rows.count ? of.rows.normal[i][a] : a != k ? 0 : side == 0 ? 1 : -1;
        h[i] = i < of.rows.count ? of.rows.most[i] : side == 0 ? of.upper[k] : -of.lower[k];
    }
    const auto solved = [&](const double* right, double* left) {
        double H[N][N], y[N];
        for (int a = 0; a < n; ++a) {
            y[a] = right[a];
            for (int b = 0; b < n; ++b) H[a][b] = of.H[a][b];
        }
        solve_ldl(H, y, n);
        for (int a = 0; a < n; ++a) left[a] = y[a];
    };
    solved(of.r, x);
    for (int i = 0; i < all; ++i) solved(G[i], Z[i]);
    for (int round = 0; round < 20000; ++round)
        for (int i = 0; i < all; ++i) {
            double beyond = -h[i], size = 0;
            for (int a = 0; a < n; ++a) {
                beyond += G[i][a] * x[a];
                size += G[i][a] * Z[i][a];
            }
            const double next = std::fmax(raised[i] + beyond / size, 0.0);
            for (int a = 0; a < n; ++a) x[a] -= (next - raised[i]) * Z[i][a];
            raised[i] = next;
        }
}
}  // namespace

int main() {
    tests::generator random;
    int active = 0;
    for (int trial = 0; trial < 120; ++trial) {
        problem drawn = made(random, 1 + trial % N, trial % 9, trial % 4 == 0);
        auto* rows = drawn.rows.count > 0 ? &drawn.rows : nullptr;
        least_within(drawn.H, drawn.r, drawn.lower, drawn.upper, drawn.n, drawn.at, drawn.x, rows);
        double wanted[N], missed = 0;
        by_multipliers(drawn, wanted);
        for (int a = 0; a < drawn.n; ++a) missed = std::fmax(missed, std::fabs(drawn.x[a] - wanted[a]));
        for (int i = 0; i < drawn.rows.count; ++i) active += drawn.rows.on[i];
        CHECK(missed < 1e-6, "trial %d, %d unknowns, %d rows: misses by %g", trial, drawn.n, drawn.rows.count, missed);
    }
    CHECK(active > 60, "only %d rows were active", active);
    return tests::verdict("half_spaces");
}
