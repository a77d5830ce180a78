// Targets: the slope of what a search makes vanish, by the definitions, and the chord near half turns.
#include "twistarm/ik/target.hpp"

#include "problems.hpp"
#include "twistarm/ik/residual.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::matrix;
using tests::real;

namespace {
constexpr double weight = 0.2;  // of a squared radian beside a squared metre, as in a search
constexpr real step = 1e-5L;

/// Near the half turn R − Rᵀ fades, and squared errors of rotations [rad²] with it; a search is far from its end there.
constexpr double near_half_turn = 1e-6;

matrix drawn_pose(tests::generator& random) {
    double xi[6];
    for (double& component : xi) component = random.between(-2, 2);
    return tests::exponential(xi, 1);
}

/// What a search minimises: ½ (distance² + w · 8 (1 − cos φ/2)), for a task half the squared excess.
real objective(const target<double>& asked, const matrix& g) {
    const tests::misses off = tests::missed(asked, g);
    const real turned = asked.kind == target_kind::task ? off.orientation * off.orientation
                                                        : 8 * (1 - std::cos(off.orientation / 2));
    return (off.position * off.position + weight * turned) / 2;
}

/// Jᵀ e against central differences of the objective, and the squared errors against those of the definitions.
template <target_kind Kind, int N> void test_slope(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    if (!fits<N, N>(general)) return;
    const auto arm = narrowed<double, N, N>(general);
    using V = pack<double, 8>;
    V theta[capacity(N)] = {};
    for (int k = 0; k < source.coordinates; ++k)
        for (int l = 0; l < 8; ++l) theta[k].set(l, random.between(-3, 3));
    const auto asked = tests::drawn_target<double>(random, Kind, drawn_pose(random));
    const auto aims = aim_in_every_lane<V>(aim_at(arm, asked));
    frame<V> g;
    column<V> columns[capacity(N)];
    residual<V, N, rows_of(Kind)> at;
    walk_with_columns(arm, aims.base, aims.tip, theta, g, columns);
    residual_of<Kind, N>(g, columns, source.coordinates, aims, std::sqrt(weight), at);
    for (int l = 0; l < 8; ++l) {
        real there[most_joints];
        for (int k = 0; k < source.coordinates; ++k) there[k] = theta[k][l];
        const tests::misses off = tests::missed(asked, source.fk(there));
        const real turned = Kind == target_kind::task ? off.orientation : 2 * std::sin(off.orientation / 2);
        const double farther = static_cast<double>(at.position_squared[l] - off.position * off.position);
        CHECK(std::fabs(farther) < 1e-12, "lane %d: %g", l, farther);
        const tests::misses whole = tests::missed(pose_target(asked.goal), source.fk(there));
        const real angle = Kind == target_kind::task ? whole.orientation : off.orientation;
        const double apart = static_cast<double>(std::fabs(at.rotation_squared[l] - turned * turned));
        CHECK(apart < (angle < 2.6L ? 1e-12 : near_half_turn), "kind %d, angle %g: %g", static_cast<int>(Kind),
              static_cast<double>(angle), apart);
        if (angle > 3.1L) continue;  // differences would straddle the half turn
        for (int k = 0; k < source.coordinates; ++k) {
            double slope = 0;
            for (int r = 0; r < rows_of(Kind); ++r) slope += at.J[k][r][l] * at.e[r][l];
            there[k] += step;
            const real ahead = objective(asked, source.fk(there));
            there[k] -= 2 * step;
            const real behind = objective(asked, source.fk(there));
            there[k] += step;
            const double expected = static_cast<double>((ahead - behind) / (2 * step));
            CHECK(std::fabs(slope - expected) < 2e-8, "kind %d, n = %d, coordinate %d: %g, expected %g",
                  static_cast<int>(Kind), source.coordinates, k, slope, expected);
        }
    }
}

template <int N> void test_slopes(int n, tests::wiring wired) {
    tests::generator random;
    for (int i = 0; i < 10; ++i) {
        const drawn_arm arm(random, n, wired);
        test_slope<target_kind::pose, N>(arm, random);
        test_slope<target_kind::position, N>(arm, random);
        test_slope<target_kind::approach, N>(arm, random);
        test_slope<target_kind::task, N>(arm, random);
    }
}

/// Near the half turn the chord keeps its length, 2 sin(φ/2), and its axis up to the sign.
void test_chords_near_half_turns() {
    tests::generator random;
    for (const double short_of : {1e-2, 1e-3, 1.1e-3, 1e-6, 1e-9, 0.0}) {
        double u[3], phi[3];
        for (double& each : u) each = random.between(-1, 1);
        const double size_of_u = std::sqrt(dot(u, u));
        for (double& each : u) each /= size_of_u;
        for (int k = 0; k < 3; ++k) phi[k] = (3.14159265358979323846 - short_of) * u[k];
        const auto R = tests::to_frame<double>(tests::rotation(phi));
        double chord[3];
        detail::chord_of(R, chord);
        const double size = 2 * std::sin(0.5 * (3.14159265358979323846 - short_of));
        const double side = dot(chord, u) < 0 ? -1 : 1;
        for (int k = 0; k < 3; ++k)
            CHECK(std::fabs(side * chord[k] - size * u[k]) < 1e-9, "%g short of a half turn", short_of);
        if (short_of > 1e-7) CHECK(side == 1, "%g short of a half turn the side is known", short_of);
    }
}
}  // namespace

int main() {
    test_slopes<dynamic>(4, tests::wiring::plain);
    test_slopes<6>(6, tests::wiring::plain);
    test_slopes<dynamic>(5, tests::wiring::followers);
    test_chords_near_half_turns();
    return tests::verdict("targets");
}
