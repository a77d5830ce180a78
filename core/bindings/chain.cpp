#include "chain.hpp"

#include <cmath>
#include <cstring>

#include "answer.hpp"
#include "clock.hpp"

namespace bindings {

namespace {

void require(bool holds, const char* otherwise) {
    if (!holds) throw nb::value_error(otherwise);
}

const Kernels* chosen(const std::string& name) {
    std::string there;
    for (auto each = kernels(); *each != nullptr; ++each) {
        if (name.empty() || name == (*each)->name) return *each;
        there += std::string(there.empty() ? "" : ", ") + (*each)->name;
    }
    throw nb::value_error(("no instruction set '" + name + "' here; there are: " + there).c_str());
}

// Rows of numbers, `stride` apart, as lists.
nb::list rows(const double* values, int count, int width, int stride) {
    nb::list all;
    for (int i = 0; i < count; ++i) {
        nb::list row;
        for (int k = 0; k < width; ++k) row.append(values[i * stride + k]);
        all.append(row);
    }
    return all;
}

}  // namespace

Chain::Chain(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle lower, nb::handle upper,
             nb::handle start_lower, nb::handle start_upper, double reach, const std::string& instruction_set)
    : kernels_(chosen(instruction_set)) {
    const Numbers S(screws), g(home), A(coupling), low(lower), high(upper), from(start_lower), to(start_upper);
    require(S.plain() && S.dimensions() == 2 && S.shape(0) == 6, "screws must be float64 (6, m)");
    require(A.plain() && A.dimensions() == 2 && A.shape(0) == S.shape(1), "coupling must be float64 (m, n)");
    n_ = A.shape(1);
    require(g.is(4, 4), "home must be float64 (4, 4)");
    require(low.is(n_) && high.is(n_) && from.is(n_) && to.is(n_), "each bound must be float64 (n,)");
    require(S.finite() && g.finite() && A.finite() && from.finite() && to.finite(), "a chain's numbers are finite");
    engine_.reset(kernels_->make({static_cast<int>(S.shape(1)), static_cast<int>(n_), S.data(), g.data(), A.data(),
                                  low.data(), high.data(), from.data(), to.data(), reach}));
    require(engine_ != nullptr, "a chain has 1 to 32 coordinates and moving joints");
    pose_ = nb::make_tuple(4, 4);
    jacobian_ = nb::make_tuple(6, n_);
}

nb::dict Chain::constants() const {
    Constants found;
    engine_->constants(found);
    nb::list links;
    for (int i = 0; i < found.joints; ++i) {
        const Constants::Link& from = found.links[i];
        nb::dict link;
        link["offset"] = nb::make_tuple(from.offset[0], from.offset[1], from.offset[2]);
        link["cos_alpha"] = from.cos_alpha;
        link["sin_alpha"] = from.sin_alpha;
        link["turn"] = from.turn;
        link["phase"] = from.phase;
        link["slide"] = from.slide;
        link["revolute"] = from.revolute;
        links.append(link);
    }
    nb::dict constants;
    constants["joints"] = found.joints;
    constants["coordinates"] = found.coordinates;
    constants["identity"] = found.identity;
    constants["base"] = rows(found.base, 4, 4, 4);
    constants["tip"] = rows(found.tip, 4, 4, 4);
    constants["links"] = links;
    constants["coupling"] = rows(found.coupling[0], found.joints, found.coordinates, most_joints);
    return constants;
}

// One call of forward kinematics: theta held, the results made, the kernel run.
class Chain::Call {
public:
    Call(const Chain& chain, nb::handle theta) : chain_(chain), theta_(theta) {
        const std::size_t axes = theta_.plain() ? theta_.dimensions() : 0;
        plain_ = (axes == 1 || axes == 2) && theta_.shape(axes - 1) == chain.n_ && theta_.finite();
    }

    bool plain() const { return plain_; }

    nb::object result(const nb::object& shape, int rows) const {
        if (theta_.dimensions() == 1) return NumPy::get().empty(shape);
        return NumPy::get().empty(nb::make_tuple(theta_.shape(0), rows, shape[1]));
    }

    void run(const nb::object& poses, const nb::object& spatial, const nb::object& body) const {
        const Written g(poses), J_s(spatial), J_b(body);
        if (theta_.dimensions() == 1)
            return chain_.engine_->kinematics(theta_.data(), 1, g.data, J_s.data, J_b.data);
        const nb::gil_scoped_release released;
        chain_.engine_->kinematics(theta_.data(), theta_.shape(0), g.data, J_s.data, J_b.data);
    }

private:
    // Where a result goes; nowhere if it is not wanted. The array itself keeps the memory.
    struct Written {
        explicit Written(const nb::object& array) : data(array ? Numbers(array).data() : nullptr) {}
        double* data;
    };

    const Chain& chain_;
    Numbers theta_;
    bool plain_;
};

nb::object Chain::fk(nb::handle theta) const {
    const Call call(*this, theta);
    if (!call.plain()) return not_plain();
    nb::object poses = call.result(pose_, 4);
    call.run(poses, {}, {});
    return poses;
}

nb::object Chain::spatial_jacobian(nb::handle theta) const {
    const Call call(*this, theta);
    if (!call.plain()) return not_plain();
    nb::object J = call.result(jacobian_, 6);
    call.run({}, J, {});
    return J;
}

nb::object Chain::body_jacobian(nb::handle theta) const {
    const Call call(*this, theta);
    if (!call.plain()) return not_plain();
    nb::object J = call.result(jacobian_, 6);
    call.run({}, {}, J);
    return J;
}

nb::object Chain::fk_and_body_jacobian(nb::handle theta) const {
    const Call call(*this, theta);
    if (!call.plain()) return not_plain();
    const nb::object poses = call.result(pose_, 4), J = call.result(jacobian_, 6);
    call.run(poses, {}, J);
    return nb::make_tuple(poses, J);
}

// -- inverse kinematics ----------------------------------------------------------------------------------------------

namespace {

constexpr double orthonormal = 1e-12;      // RᵀR − I beyond this is Python's to clean or to refuse
constexpr double least_tolerance = 1e-12;  // as in ik/solve.py
constexpr double farthest = 1e6;           // [m], as in ik/targets.py
constexpr double farthest_start = 1e6;     // [rad, m], as in ik/request.py
constexpr std::uint64_t most_searches = 1000000;  // as in ik/request.py

bool is_start(const Numbers& theta) {
    for (std::size_t k = 0; k < theta.size(); ++k)
        if (!(std::fabs(theta.data()[k]) <= farthest_start)) return false;
    return true;
}

bool is_rigid(const double* g) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
            const double dot = g[i] * g[j] + g[4 + i] * g[4 + j] + g[8 + i] * g[8 + j];
            if (!(std::fabs(dot - (i == j ? 1.0 : 0.0)) <= orthonormal)) return false;
        }
    const double determinant = g[0] * (g[5] * g[10] - g[6] * g[9]) - g[1] * (g[4] * g[10] - g[6] * g[8]) +
                               g[2] * (g[4] * g[9] - g[5] * g[8]);
    return determinant > 0.0 && g[12] == 0.0 && g[13] == 0.0 && g[14] == 0.0 && g[15] == 1.0;
}

}  // namespace

bool is_target(int kind, const double* numbers) {
    const bool has_pose = kind == 0 || kind == 3;
    if (has_pose && !is_rigid(numbers)) return false;
    for (int k = 0; k < 3; ++k)
        if (!(std::fabs(has_pose ? numbers[4 * k + 3] : numbers[k]) <= farthest)) return false;
    return true;
}

namespace {

// The numbers a call was given, or that they are not plain.
struct Scalar {
    explicit Scalar(nb::handle value) : given(PyFloat_CheckExact(value.ptr())), number(0.0) {
        if (given) number = PyFloat_AS_DOUBLE(value.ptr());
    }
    bool given;
    double number;
};

bool whole(nb::handle value, std::uint64_t& number) {
    if (!PyLong_CheckExact(value.ptr())) return false;
    number = PyLong_AsUnsignedLongLong(value.ptr());
    if (PyErr_Occurred() == nullptr) return true;
    PyErr_Clear();
    return false;
}

}  // namespace

nb::object Chain::solve(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                        nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                        nb::handle posture) const {
    std::uint64_t which, searches, from;
    const Scalar position(position_tolerance), orientation(orientation_tolerance);
    if (!whole(kind, which) || which >= kinds || !whole(restarts, searches) || searches < 1 || searches > most_searches ||
        !whole(seed, from) || !(position.number >= least_tolerance) || !(orientation.number >= least_tolerance) ||
        !std::isfinite(position.number) || !std::isfinite(orientation.number))
        return not_plain();
    const Numbers target(numbers), start(theta0);
    if (!(which == 0 ? target.is(4, 4) : target.plain() && target.size() == numbers_of_kind[which]) || !start.is(n_) || !is_start(start) ||
        !is_target(static_cast<int>(which), target.data()))
        return not_plain();
    double seconds = Deadline::none;
    if (!max_time.is_none()) {
        const Scalar limit(max_time);
        if (!limit.given || !(limit.number > 0.0) || !std::isfinite(limit.number)) return not_plain();
        seconds = limit.number;
    }
    const bool has_posture = !posture.is_none();
    const Numbers preferred(has_posture ? posture : theta0);
    if (has_posture && (!preferred.is(n_) || !preferred.finite())) return not_plain();
    const Deadline deadline(seconds);
    nb::object object = nb::inst_alloc(nb::type<OneAnswer>());
    OneAnswer& found = *nb::inst_ptr<OneAnswer>(object);
    found.kind = static_cast<int>(which);
    found.n = static_cast<int>(n_);
    found.position_tolerance = position.number;
    found.orientation_tolerance = orientation.number;
    std::memcpy(found.numbers, target.data(), target.size() * sizeof(double));
    std::memcpy(found.theta0, start.data(), n_ * sizeof(double));
    const Query query{found.kind, position.number, orientation.number, static_cast<int>(searches), from,
                      &Deadline::passed, &deadline};
    const Question question{found.numbers, found.theta0, has_posture ? preferred.data() : nullptr};
    {
        const nb::gil_scoped_release released;
        engine_->solve(query, question, found.answer);
    }
    nb::inst_mark_ready(object);
    return object;
}

}  // namespace bindings
