// twistarm._core.Gaps: how near pairs of bodies are at least, by a ball and a rounded box for each pair.
#pragma once

#include "arrays.hpp"

#include <utility>
#include <vector>

namespace bindings {

class Gaps {
public:
    // Each body's joint (b,), and [p R] (b, 3, 4) of its box. Each pair's bodies with the ball and with the box (k,),
    // and half the box, the radii of both, and 1 where the gap is the distance (k, 5). Each joint's twist (m, 6), which
    // bodies of pairs it carries (k, m), and how fast it follows theta (m, n).
    Gaps(std::vector<int> joints, nb::handle placements, std::vector<int> balls, std::vector<int> boxes,
         nb::handle sizes, nb::handle twists, nb::handle between, nb::handle coupling);

    nb::object gaps(nb::handle frames, const std::vector<int>& pairs) const;
    nb::object nearest(nb::handle frames, int start, double slack, nb::handle measure) const;
    nb::object closest(nb::handle frames, nb::handle limits, nb::handle margins, std::size_t count,
                       nb::handle measure) const;

private:
    struct Placed {
        double p[3], R[3][3];  // R[i]: axis i
    };
    struct Pair {
        int ball, box;
        double half[3], radius, reach;
        bool exact;
    };
    // From the box to the ball, along the axes of the box: between the centres, and beyond the faces.
    struct Way {
        double along[3], beyond[3], gap;
    };
    using Found = std::vector<std::pair<double, int>>;  // gaps and their pairs
    using Wrench = std::vector<double>;                 // distance, direction, moment

    std::vector<Placed> placed(nb::handle frames) const;
    static Way way(const Pair& pair, const std::vector<Placed>& bodies);
    template <class Limit> Found below(const std::vector<Placed>& bodies, Limit limit) const;
    Wrench wrench(int k, const std::vector<Placed>& bodies, nb::handle measure) const;
    void approach(nb::handle frames, int k, const Wrench& wrench, double* rates) const;

    std::vector<int> joints_;
    std::vector<Placed> placements_;
    std::vector<Pair> pairs_;
    std::vector<double> twists_, between_, coupling_;
    std::size_t moving_, n_;
};

}  // namespace bindings
