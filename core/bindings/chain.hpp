// twistarm._core.Chain: one arm as Python sees it.
#pragma once

#include <memory>
#include <string>

#include "arrays.hpp"
#include "clock.hpp"
#include "kernels.hpp"

namespace bindings {

// A call returns None if the core does not take an argument as it is. Python then converts the argument and calls
// again, or raises an error.
inline nb::object not_plain() { return nb::none(); }

// How one target or many are to be solved.
struct Settings {
    Query query{};
    double seconds = Deadline::none;

    // False where one of them is not plainly right.
    bool read(nb::handle kind, nb::handle position_tolerance, nb::handle orientation_tolerance, nb::handle restarts,
              nb::handle seed, nb::handle max_time);
};

// Each is false for what is not plainly right.
bool tolerance(nb::handle value, double& number);
bool is_start(const double* theta, std::size_t count);
bool is_finite(const double* theta, std::size_t count);

class Chain {
public:
    Chain(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle lower, nb::handle upper,
          nb::handle start_lower, nb::handle start_upper, double reach, const std::string& instruction_set);

    std::size_t n() const { return n_; }
    const char* instruction_set() const { return kernels_->name; }
    const Engine& engine() const { return *engine_; }

    // The data type of records with room for a target of any kind.
    nb::object widest_record() const { return record_types_[3]; }

    // The chain's numbers by name: joints, coordinates, identity, base, tip, links, coupling.
    nb::dict constants() const;

    nb::object fk(nb::handle theta) const;
    nb::object spatial_jacobian(nb::handle theta) const;
    nb::object body_jacobian(nb::handle theta) const;
    nb::object fk_and_body_jacobian(nb::handle theta) const;

    // None, or five numbers: the impossible and the prevented part of a target's rotation error, and an axis of the
    // tool.
    nb::object split_rotation(nb::handle kind, nb::handle numbers, nb::handle theta) const;

    // None, or an Answer (answer.hpp).
    nb::object solve(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                     nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                     nb::handle posture) const;
    // None, or a record for each target; `progress` None or called with (done, count).
    nb::object solve_batch(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                           nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                           nb::handle posture, nb::handle threads, nb::handle progress) const;
    // None, or (met (count,), theta (count, n)); `chunks` (m + 1,): where chunks of targets begin, and the end.
    nb::object reachable(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                         nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle chunks,
                         nb::handle threads, nb::handle progress) const;

private:
    class Call;

    const Kernels* kernels_;
    std::unique_ptr<Engine> engine_;
    std::size_t n_;
    nb::object pose_, jacobian_, record_types_[kinds];
};

}  // namespace bindings
