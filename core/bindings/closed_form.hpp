// twistarm._core.ClosedForm: the closed form of one arm's family, for one kind of target, as Python sees it.
#pragma once

#include <memory>

#include "chain.hpp"

namespace bindings {

class ClosedForm {
public:
    // axes (k, 7): w, o and 1 for a slide, in the family's order; joint (k,): theta's index of each, -1 for a turn that the
    // target leaves free; kept (4,): as `keeps` says, a point and 0, or a plane's normal and d; held (h,) and held_axes (h, 7): base to tip;
    // rate (n,), home (4, 4); idle (n,): 1 for what any answer may move.
    ClosedForm(nb::object chain, int kind, int first, int last, int keeps, nb::handle axes, nb::handle joint,
               nb::handle kept, nb::handle held, nb::handle held_axes, nb::handle rate, nb::handle home, nb::handle idle);

    // None, or a row as src/twistarm/ik/all_solutions.py reads it; held: None, or values (m, h), each of which is
    // tried.
    nb::object solve(nb::handle numbers, nb::handle theta0, nb::handle held, nb::handle position_tolerance,
                     nb::handle orientation_tolerance) const;
    // None, or (rows (r, 2 n), count (N,), inside (N,), families (N,)): each target's configurations behind those of the one before.
    nb::object solve_batch(nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                           nb::handle orientation_tolerance, nb::handle threads) const;

private:
    nb::object chain_;  // whose engine this one works with
    int kind_;
    std::size_t n_, held_count_;
    std::unique_ptr<ClosedFormEngine> engine_;
};

}  // namespace bindings
