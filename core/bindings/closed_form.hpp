// twistarm._core.ClosedForm: the closed form of one arm's family for one kind of target.
#pragma once

#include <memory>
#include <vector>

#include "chain.hpp"

namespace bindings {

class ClosedForm {
public:
    // axes (k, 7): w, o and 1 for a slide, in the family's order. joint (k,): the index in theta, -1 for a turn that
    // the target leaves free. kept (4,): a point and 0, or a plane's normal and d, as `keeps` says. held (h,) and
    // held_axes (h, 7): base to tip. rate (n,), home (4, 4). idle (n,): 1 for joints that do not affect the target.
    ClosedForm(nb::object chain, int kind, int first, int last, int keeps, nb::handle axes, nb::handle joint,
               nb::handle kept, nb::handle held, nb::handle held_axes, nb::handle rate, nb::handle home, nb::handle idle);

    // A configuration is a row (2, n): theta and, as 0 and 1, which coordinates may move while the target stays reached.
    //
    // None, or (rows (k, 2, n), inside, hits, left, families): those inside the limits come first, by distance. `hits`
    // counts the values with any; `families` those of a continuous family, `left` those of them outside. held: None,
    // or values (m, h); the call tries each row.
    nb::object solve(nb::handle numbers, nb::handle theta0, nb::handle held, nb::handle position_tolerance,
                     nb::handle orientation_tolerance) const;
    // The same from candidates (k, n), which all have held joints at the values of the first.
    nb::object verify(nb::handle numbers, nb::handle theta0, nb::handle candidates, nb::handle position_tolerance,
                      nb::handle orientation_tolerance) const;
    // None, or candidates (k, n) that nobody has verified, for values (h,) of the held joints. slack: by how much of its
    // size a subproblem may be missed.
    nb::object candidates(nb::handle numbers, nb::handle theta0, nb::handle held, nb::handle slack) const;
    // None, or (rows (r, 2, n), count (N,), inside (N,), families (N,)): the rows of target 0, then of target 1 …
    nb::object solve_batch(nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                           nb::handle orientation_tolerance, nb::handle threads) const;

private:
    nb::object chain_;  // whose engine this one works with
    int kind_;
    std::size_t n_, held_count_;
    std::unique_ptr<ClosedFormEngine> engine_;
};

}  // namespace bindings
