// twistarm._core.Gaps: how near pairs of bodies are at least, by a ball and a rounded box for each pair.
#pragma once

#include "arrays.hpp"

#include <utility>
#include <vector>

namespace bindings {

class Gaps {
public:
    // Each body's joint (b,), and [p R] (b, 3, 4) of its box in the frame of that joint. Each pair's body with the ball
    // and the one with the box (k,), half the box (k, 3), and the radii of both (k,).
    Gaps(std::vector<int> joints, nb::handle placements, std::vector<int> balls, std::vector<int> boxes, nb::handle half,
         nb::handle radius);

    // The pairs whose gap is below their limit (k,), and these gaps. frames: [p R] of all joints but the world, side by
    // side (3, 4 m).
    nb::object near(nb::handle frames, nb::handle limits) const;

    // The pair for which `measure` gives the smallest distance, the first of equal ones, and that distance. No distance
    // is less than its gap by more than `slack`. The pair `start` is measured first: it bounds what others have to be.
    nb::object nearest(nb::handle frames, int start, double slack, nb::handle measure) const;

    // Of these pairs (j,) the gap, the direction (3,) from the first body to the second, and its moment about the
    // world's origin: (j, 7).
    nb::object measure(nb::handle frames, const std::vector<int>& pairs) const;

private:
    struct Placed {
        double p[3], R[3][3];  // R[i]: axis i
    };
    struct Pair {
        int ball, box;
        double half[3], radius, reach;
    };
    // From the box to the ball, along the axes of the box: between the centres, and beyond the faces.
    struct Way {
        double along[3], beyond[3], gap;
    };
    using Found = std::vector<std::pair<double, int>>;  // gaps and their pairs

    std::vector<Placed> placed(nb::handle frames) const;
    static Way way(const Pair& pair, const std::vector<Placed>& bodies);
    template <class Limit> Found below(nb::handle frames, Limit limit) const;

    std::vector<int> joints_;
    std::vector<Placed> placements_;
    std::vector<Pair> pairs_;
    int most_joint_;
};

}  // namespace bindings
