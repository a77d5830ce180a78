#include "chain.hpp"

#include <cmath>
#include <vector>

#include "answer.hpp"
#include "clock.hpp"
#include "targets.hpp"

namespace bindings {

namespace {

const Kernels* chosen(const std::string& name) {
    std::string there;
    for (auto kernel = kernels(); *kernel != nullptr; ++kernel) {
        if (name.empty() || name == (*kernel)->name) return *kernel;
        there += std::string(there.empty() ? "" : ", ") + (*kernel)->name;
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
    require(engine_ != nullptr, "a chain has 1 to 64 coordinates and moving joints");
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

constexpr double two_turns = 12.566370614359172;  // [rad], as in support/units.py

// One call of forward kinematics: theta held, the results made, the kernel run.
class Chain::Call {
public:
    Call(const Chain& chain, nb::handle theta) : chain_(chain), theta_(theta) {
        const std::size_t axes = theta_.plain() ? theta_.dimensions() : 0;
        plain_ = (axes == 1 || axes == 2) && theta_.shape(axes - 1) == chain.n_ && theta_.finite();
        // A configuration beyond two turns may be in degrees. Python checks it and passes it on as rows.
        for (std::size_t i = 0; axes == 1 && plain_ && i < chain.n_; ++i) plain_ = std::fabs(theta_.data()[i]) <= two_turns;
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
        // A copy: without the lock another thread may resize the caller's array.
        const std::vector<double> theta(theta_.data(), theta_.data() + theta_.size());
        const std::size_t count = theta_.shape(0);
        without_lock([&] { chain_.engine_->kinematics(theta.data(), count, g.data, J_s.data, J_b.data); });
    }

private:
    // Where a result goes; nowhere if it is not wanted. The array itself keeps the memory.
    struct Written {
        explicit Written(const nb::object& array) : data(array ? memory(array) : nullptr) {}
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

constexpr double least_tolerance = 1e-12;  // as in ik/request.py
constexpr double farthest_start = 1e6;     // [rad, m], as in ik/request.py
constexpr std::uint64_t most_threads = 256;        // as in ik/batch.py
constexpr std::uint64_t most_searches = 1000000;  // as in ik/request.py

}  // namespace

bool tolerance(nb::handle value, double& number) {
    return real(value, number) && number >= least_tolerance && std::isfinite(number);
}

bool Settings::read(nb::handle kind, nb::handle position_tolerance, nb::handle orientation_tolerance,
                    nb::handle restarts, nb::handle seed, nb::handle max_time) {
    std::uint64_t which, searches;
    if (!whole(kind, which) || which >= kinds || !tolerance(position_tolerance, query.position_tolerance) ||
        !tolerance(orientation_tolerance, query.orientation_tolerance) || !whole(restarts, searches) || searches < 1 ||
        searches > most_searches || !whole(seed, query.seed))
        return false;
    query.kind = static_cast<int>(which);
    query.searches = static_cast<int>(searches);
    return max_time.is_none() || (real(max_time, seconds) && seconds > 0.0 && std::isfinite(seconds));
}

bool is_start(const double* theta, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k)
        if (!(std::fabs(theta[k]) <= farthest_start)) return false;
    return true;
}

bool is_threads(nb::handle value, std::uint64_t& number) {
    return whole(value, number) && number >= 1 && number <= most_threads;
}

nb::object Chain::split_rotation(nb::handle kind, nb::handle numbers, nb::handle theta) const {
    const Numbers here(theta);
    std::uint64_t which;
    double asked[most_numbers];
    if (!whole(kind, which) || which >= kinds || !read_target(numbers, static_cast<int>(which), asked) ||
        !here.is(n_) || !here.finite())
        return not_plain();
    nb::object split = NumPy::get().empty(nb::int_(5));
    engine_->split_rotation(static_cast<int>(which), asked, here.data(), memory(split));
    return split;
}

nb::object Chain::solve(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                        nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                        nb::handle posture) const {
    const Numbers given_start(theta0), given_posture(posture);
    const bool has_posture = !posture.is_none();
    Settings settings;
    Query& query = settings.query;
    double asked[most_numbers], start[most_joints], preferred[most_joints];
    if (!settings.read(kind, position_tolerance, orientation_tolerance, restarts, seed, max_time) ||
        !read_target(numbers, query.kind, asked) || !given_start.is(n_) || !is_start(given_start.data(), n_) ||
        (has_posture && !(given_posture.is(n_) && given_posture.finite())))
        return not_plain();
    given_start.copy_to(start);
    if (has_posture) given_posture.copy_to(preferred);
    const Question question{asked, start, has_posture ? preferred : nullptr};
    Answer found;
    Watch watch(settings.seconds);
    query.stopped = &Watch::passed;
    query.clock = &watch;
    engine_->solve(query, question, found);
    watch.end();
    const nb::object kept = nb::steal(PyByteArray_FromStringAndSize(nullptr, static_cast<Py_ssize_t>(Record::size(n_))));
    if (!kept.is_valid()) throw nb::python_error();
    auto* const record = reinterpret_cast<Record*>(PyByteArray_AS_STRING(kept.ptr()));
    record->ask(query, question, n_);
    record->answer(found, n_);
    return nb::make_tuple(found.stop, kept);
}

}  // namespace bindings
