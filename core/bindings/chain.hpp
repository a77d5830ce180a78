// twistarm._core.Chain: one arm as Python sees it.
#pragma once

#include <memory>
#include <string>

#include "arrays.hpp"
#include "clock.hpp"
#include "kernels.hpp"

namespace bindings {

// A call returns None (solve_batch: False) if an argument is not plainly right. Python then raises the error, or converts
// the argument and calls again.
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
bool is_threads(nb::handle value, std::uint64_t& number);
bool is_start(const double* theta, std::size_t count);

class Chain {
public:
    Chain(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle lower, nb::handle upper,
          nb::handle start_lower, nb::handle start_upper, double reach, const std::string& instruction_set);

    std::size_t n() const { return n_; }
    const char* instruction_set() const { return kernels_->name; }
    const Engine& engine() const { return *engine_; }

    // The chain's numbers by name: joints, coordinates, identity, base, tip, links, coupling.
    nb::dict constants() const;

    nb::object fk(nb::handle theta) const;
    nb::object spatial_jacobian(nb::handle theta) const;
    nb::object body_jacobian(nb::handle theta) const;
    nb::object fk_and_body_jacobian(nb::handle theta) const;

    // None, or five numbers: the impossible and the prevented part of a target's rotation error, and an axis of the
    // tool.
    nb::object split_rotation(nb::handle kind, nb::handle numbers, nb::handle theta) const;

    // None, or the number of the reason and the bytes of a record (answer.hpp): NumPy would take ten times as long.
    nb::object solve(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                     nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                     nb::handle posture) const;
    // False, or true with a record for each target; `progress` None or called with (done, count).
    bool solve_batch(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                     nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle max_time,
                     nb::handle posture, nb::handle threads, nb::handle progress, nb::handle records) const;
    // None, or (converged (count,), theta (count, n)); `chunks` (m + 1,): where chunks of targets begin, and the end.
    nb::object reachable(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                         nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle chunks,
                         nb::handle threads, nb::handle progress) const;

private:
    class Call;

    const Kernels* kernels_;
    std::unique_ptr<Engine> engine_;
    std::size_t n_;
    nb::object pose_, jacobian_;
};

}  // namespace bindings
