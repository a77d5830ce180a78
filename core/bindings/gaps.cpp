#include "gaps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace bindings {

Gaps::Gaps(std::vector<int> joints, nb::handle placements, std::vector<int> balls, std::vector<int> boxes,
           nb::handle half, nb::handle radius)
    : joints_(std::move(joints)), placements_(joints_.size()), pairs_(balls.size()), most_joint_(0) {
    const Numbers at(placements), size(half), round(radius);
    const int bodies = static_cast<int>(joints_.size());
    require(at.is(joints_.size(), 3, 4), "placements must be float64 (b, 3, 4)");
    require(boxes.size() == balls.size() && size.is(balls.size(), 3) && round.is(balls.size()),
            "pairs must be (k,), half float64 (k, 3), radius float64 (k,)");
    for (std::size_t b = 0; b < joints_.size(); ++b) {
        require(joints_[b] >= 0, "a joint has an index from 0");
        most_joint_ = std::max(most_joint_, joints_[b]);
        const double* const rows = at.data() + 12 * b;
        for (int i = 0; i < 3; ++i) {
            placements_[b].p[i] = rows[4 * i];
            for (int k = 0; k < 3; ++k) placements_[b].R[k][i] = rows[4 * i + 1 + k];
        }
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        require(balls[k] >= 0 && balls[k] < bodies && boxes[k] >= 0 && boxes[k] < bodies, "a pair is of these bodies");
        Pair& pair = pairs_[k];
        pair = {balls[k], boxes[k], {}, round.data()[k], 0.0};
        std::copy_n(size.data() + 3 * k, 3, pair.half);
        pair.reach = pair.radius + std::hypot(pair.half[0], pair.half[1], pair.half[2]);
    }
}

std::vector<Gaps::Placed> Gaps::placed(nb::handle frames) const {
    const Numbers given(frames);
    require(given.plain() && given.dimensions() == 2 && given.shape(0) == 3 &&
                given.shape(1) >= 4 * static_cast<std::size_t>(most_joint_),
            "frames must be float64 (3, 4 m) of all joints");
    const std::size_t width = given.shape(1);
    std::vector<Placed> bodies(placements_);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (joints_[b] == 0) continue;
        const double* const g = given.data() + 4 * (joints_[b] - 1);
        const Placed& own = placements_[b];
        for (int i = 0; i < 3; ++i) {
            const double* const row = g + static_cast<std::size_t>(i) * width;
            bodies[b].p[i] = row[0] + row[1] * own.p[0] + row[2] * own.p[1] + row[3] * own.p[2];
            for (int k = 0; k < 3; ++k)
                bodies[b].R[k][i] = row[1] * own.R[k][0] + row[2] * own.R[k][1] + row[3] * own.R[k][2];
        }
    }
    return bodies;
}

Gaps::Way Gaps::way(const Pair& pair, const std::vector<Placed>& bodies) {
    const Placed &ball = bodies[static_cast<std::size_t>(pair.ball)], &box = bodies[static_cast<std::size_t>(pair.box)];
    const double d[3] = {ball.p[0] - box.p[0], ball.p[1] - box.p[1], ball.p[2] - box.p[2]};
    Way found;
    double square = 0.0;
    for (int i = 0; i < 3; ++i) {
        found.along[i] = box.R[i][0] * d[0] + box.R[i][1] * d[1] + box.R[i][2] * d[2];
        found.beyond[i] = std::fabs(found.along[i]) - pair.half[i];
        const double outside = std::max(found.beyond[i], 0.0);
        square += outside * outside;
    }
    const double deepest = std::max({found.beyond[0], found.beyond[1], found.beyond[2]});
    found.gap = std::sqrt(square) + std::min(deepest, 0.0) - pair.radius;
    return found;
}

template <class Limit> Gaps::Found Gaps::below(nb::handle frames, Limit limit) const {
    const std::vector<Placed> bodies = placed(frames);
    Found found;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        const Pair& pair = pairs_[k];
        const double *const a = bodies[static_cast<std::size_t>(pair.ball)].p,
                     *const b = bodies[static_cast<std::size_t>(pair.box)].p;
        const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2], most = limit(k), far = most + pair.reach;
        // The balls round both are farther apart: most pairs end here.
        if (far < 0.0 || x * x + y * y + z * z > far * far) continue;
        const double gap = way(pair, bodies).gap;
        if (gap < most) found.emplace_back(gap, static_cast<int>(k));
    }
    return found;
}

nb::object Gaps::near(nb::handle frames, nb::handle limits) const {
    const Numbers most(limits);
    require(most.is(pairs_.size()), "limits must be float64 (k,)");
    const Found found = below(frames, [&](std::size_t k) { return most.data()[k]; });
    const nb::int_ count(found.size());
    const nb::object pairs = NumPy::get().empty(count, NumPy::get().whole()), gaps = NumPy::get().empty(count);
    for (std::size_t i = 0; i < found.size(); ++i) {
        memory(gaps)[i] = found[i].first;
        memory<std::int64_t>(pairs)[i] = found[i].second;
    }
    return nb::make_tuple(pairs, gaps);
}

nb::object Gaps::nearest(nb::handle frames, int start, double slack, nb::handle measure) const {
    require(start >= 0 && static_cast<std::size_t>(start) < pairs_.size(), "no such pair");
    const auto measured = [&](int k) { return called([&] { return nb::cast<double>(measure(k)); }); };
    std::pair<double, int> best(measured(start), start);
    Found heap = below(frames, [&](std::size_t) { return best.first + slack; });
    std::make_heap(heap.begin(), heap.end(), std::greater<>());
    for (; !heap.empty() && heap.front().first < best.first + slack; heap.pop_back()) {
        std::pop_heap(heap.begin(), heap.end(), std::greater<>());
        const int k = heap.back().second;
        if (k != start) best = std::min(best, {measured(k), k});
    }
    return nb::make_tuple(best.second, best.first);
}

nb::object Gaps::measure(nb::handle frames, const std::vector<int>& pairs) const {
    const std::vector<Placed> bodies = placed(frames);
    const nb::object rows = NumPy::get().empty(nb::make_tuple(pairs.size(), 7));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        require(pairs[i] >= 0 && static_cast<std::size_t>(pairs[i]) < pairs_.size(), "no such pair");
        const Pair& pair = pairs_[static_cast<std::size_t>(pairs[i])];
        const Way found = way(pair, bodies);
        // From the box to the ball: from the nearest point of the box, or by the face that is nearest from inside.
        double out[3], n[3] = {};
        const int face = static_cast<int>(std::max_element(found.beyond, found.beyond + 3) - found.beyond);
        const bool inside = found.beyond[face] <= 0.0;
        for (int k = 0; k < 3; ++k)
            out[k] = std::copysign(inside ? (k == face ? 1.0 : 0.0) : std::max(found.beyond[k], 0.0), found.along[k]);
        const double size = std::hypot(out[0], out[1], out[2]) * (pair.ball < pair.box ? -1.0 : 1.0);
        const Placed& box = bodies[static_cast<std::size_t>(pair.box)];
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) n[axis] += box.R[k][axis] * out[k] / size;
        // The line of the force passes through the centre of the ball.
        const double* const p = bodies[static_cast<std::size_t>(pair.ball)].p;
        const double row[] = {found.gap, n[0], n[1], n[2], p[1] * n[2] - p[2] * n[1], p[2] * n[0] - p[0] * n[2],
                              p[0] * n[1] - p[1] * n[0]};
        std::copy_n(row, 7, memory(rows) + 7 * i);
    }
    return rows;
}

}  // namespace bindings
