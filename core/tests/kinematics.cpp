// Chains of every size and number type: forward kinematics against products of exponentials, eight at once as one by
// one. Jacobians Python's tests hold to Pinocchio's.
#include "twistarm/kinematics/kinematics.hpp"

#include "arms.hpp"
#include "sizes.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::matrix;
using tests::wiring;

namespace {
constexpr double tolerance = 5e-14, single_tolerance = 3e-5;

/// Eight configurations in lanes: the same as one by one.
template <class T, int N, int M>
void test_lanes(const chain<T, N, M>& arm, const drawn_arm& source, const double (&theta)[8][most_joints],
                double enough) {
    using V = pack<T, 8>;
    V thetas[capacity(N)] = {};
    for (int k = 0; k < source.coordinates; ++k)
        for (int l = 0; l < 8; ++l) thetas[k].set(l, static_cast<T>(theta[l][k]));
    column<V> columns[capacity(N)];
    const frame<V> g = forward_with_body_jacobian(arm, thetas, columns);
    for (int l = 0; l < 8; ++l) {
        T alone[capacity(N)] = {};
        for (int k = 0; k < source.coordinates; ++k) alone[k] = thetas[k][l];
        const matrix expected = source.fk(alone);
        column<T> J[capacity(N)];
        forward_with_body_jacobian(arm, alone, J);
        for (int r = 0; r < 3; ++r) {
            CHECK(std::fabs(static_cast<double>(g.p[r][l] - expected.a[r][3])) < enough, "lane %d", l);
            CHECK(std::fabs(static_cast<double>(g.x[r][l] - expected.a[r][0])) < enough, "lane %d", l);
            for (int k = 0; k < source.coordinates; ++k)
                CHECK(std::fabs(static_cast<double>(columns[k].v[r][l] - J[k].v[r])) < enough &&
                          std::fabs(static_cast<double>(columns[k].w[r][l] - J[k].w[r])) < enough,
                      "lane %d, column %d", l, k);
        }
    }
}

template <int N, int M> void test_arm(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "n = %d", source.coordinates);
    if (!fits<N, M>(general)) return;  // neighbours that commute have become one joint
    double theta[8][most_joints] = {};
    for (auto& row : theta)
        for (int k = 0; k < source.coordinates; ++k) row[k] = random.between(-3, 3);
    const auto arm = narrowed<double, N, M>(general);
    const double scale = source.joints > 8 ? 4 : 1;
    test_lanes(arm, source, theta, tolerance * scale);
    test_lanes(narrowed<float, N, M>(general), source, theta, single_tolerance * scale);
}

template <int N, int M> void test_size(int n, wiring wired) {
    tests::generator random;
    for (int i = 0; i < 8; ++i) test_arm<N, M>(drawn_arm(random, n, wired), random);
}

void test_a_tool() {
    tests::generator random;
    const drawn_arm source(random, 5, wiring::plain);
    chain<double, dynamic, dynamic> arm{};
    CHECK(chain_from_screws(source.model(), arm), "five joints");
    const double xi[6] = {0.1, 0.2, -0.3, 1.0, -0.4, 0.2}, theta[5] = {0.3, -1, 0.7, 2, -0.4};
    const matrix tool = tests::exponential(xi, 1);
    const frame<double> g = forward(with_tool(arm, tests::to_frame<double>(tool)), theta);
    CHECK(tests::distance(source.fk(theta) * tool, g) < tolerance, "%g", tests::distance(source.fk(theta) * tool, g));
}

/// A turn and the slide that follows it are one helical joint; rows of zero and twists of zero move nothing.
void test_what_becomes_of_joints() {
    const double home[16] = {1, 0, 0, 0.2, 0, 1, 0, 0, 0, 0, 1, 0.1, 0, 0, 0, 1};
    const double screws[24] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0};
    const double A[8] = {1, 0, 0.05, 0, 0, 0, 0, 1};  // hinge, its slide, a joint that stands, a joint of its own
    chain<double, dynamic, dynamic> arm{};
    CHECK(chain_from_screws({4, 2, screws, home, A}, arm), "four joints");
    CHECK(arm.joint_count == 2 && arm.identity, "%d joints", arm.joint_count);
    CHECK(std::fabs(arm.links[0].slide - 0.05) < 1e-15 && arm.links[0].turn == 1.0, "a helical joint");
    const double across[12] = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0}, together[2] = {1, 1}, theta = 0.7;
    CHECK(chain_from_screws({2, 1, across, home, together}, arm) && arm.joint_count == 2, "axes that cross stay two");
    const double z[6] = {0, 0, 0, 0, 0, 1}, x[6] = {0, 0, 0, 1, 0, 0};
    const matrix expected = tests::exponential(z, theta) * tests::exponential(x, theta);
    CHECK(tests::distance(expected * tests::from_frame(frame_from_rows<double>(home)), forward(arm, &theta)) < tolerance,
          "two turns that follow one coordinate");
    const double nothing[8] = {};
    CHECK(!chain_from_screws({4, 2, screws, home, nothing}, arm), "nothing moves");
    CHECK(!chain_from_screws({0, 0, screws, home, nullptr}, arm), "no joints");
    static double many[6 * 33] = {};
    for (int i = 0; i < 33; ++i) many[(3 + i % 3) * 33 + i] = 1.0;
    CHECK(!chain_from_screws({33, 33, many, home, nullptr}, arm), "one joint too many");
}

template <int... N> void test_sizes(std::integer_sequence<int, N...>) {
    (test_size<N, N>(N, wiring::plain), ...);
}
}  // namespace

int main() {
    test_sizes(tests::sizes{});
    test_size<4, 6>(4, wiring::followers);
    for (const int n : {1, 4, 9, 32}) test_size<dynamic, dynamic>(n, wiring::plain);
    for (const int n : {1, 4, 30}) test_size<dynamic, dynamic>(n, wiring::followers);
    for (const int n : {2, 6}) test_size<dynamic, dynamic>(n, wiring::differential);
    test_a_tool();
    test_what_becomes_of_joints();
    return tests::verdict("kinematics");
}
