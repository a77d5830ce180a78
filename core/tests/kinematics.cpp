// Chains of joints that follow, stand or commute, and tools, against products of exponentials. The targets' and batches'
// tests judge every size, lane and number type; Python's tests hold Jacobians to Pinocchio's.
#include "twistarm/kinematics/kinematics.hpp"

#include "arms.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::matrix;
using tests::wiring;

namespace {
constexpr double tolerance = 5e-14;

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
    static double many[6 * 65] = {};
    for (int i = 0; i < 65; ++i) many[(3 + i % 3) * 65 + i] = 1.0;
    CHECK(!chain_from_screws({65, 65, many, home, nullptr}, arm), "one joint too many");
}
}  // namespace

int main() {
    test_a_tool();
    test_what_becomes_of_joints();
    return tests::verdict("kinematics");
}
