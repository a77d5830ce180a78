#include "gaps.hpp"

#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace bindings {

Gaps::Gaps(std::vector<int> joints, nb::handle placements, std::vector<int> balls, std::vector<int> boxes,
           nb::handle sizes, nb::handle twists, nb::handle between, nb::handle coupling)
    : joints_(std::move(joints)), placements_(joints_.size()), pairs_(balls.size()) {
    const Numbers at(placements), size(sizes), S(twists), sides(between), A(coupling);
    require(S.plain() && S.dimensions() == 2 && S.shape(1) == 6, "twists must be float64 (m, 6)");
    moving_ = S.shape(0);
    require(A.plain() && A.dimensions() == 2 && A.shape(0) == moving_, "coupling must be float64 (m, n)");
    n_ = A.shape(1);
    require(at.is(joints_.size(), 3, 4), "placements must be float64 (b, 3, 4)");
    require(boxes.size() == pairs_.size() && size.is(pairs_.size(), 5) && sides.is(pairs_.size(), moving_),
            "pairs must be (k,), sizes float64 (k, 5), between (k, m)");
    twists_.assign(S.data(), S.data() + S.size());
    between_.assign(sides.data(), sides.data() + sides.size());
    coupling_.assign(A.data(), A.data() + A.size());
    const auto among = [](int each, std::size_t count) { return each >= 0 && static_cast<std::size_t>(each) < count; };
    for (std::size_t b = 0; b < joints_.size(); ++b) {
        require(among(joints_[b], moving_ + 1), "a joint is one of these");
        const double* const rows = at.data() + 12 * b;
        for (int i = 0; i < 3; ++i) {
            placements_[b].p[i] = rows[4 * i];
            for (int k = 0; k < 3; ++k) placements_[b].R[k][i] = rows[4 * i + 1 + k];
        }
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        require(among(balls[k], joints_.size()) && among(boxes[k], joints_.size()), "a pair is of these bodies");
        const double* const s = size.data() + 5 * k;
        pairs_[k] = {balls[k], boxes[k], {s[0], s[1], s[2]}, s[3], s[3] + std::hypot(s[0], s[1], s[2]), s[4] != 0.0};
    }
}

std::vector<Gaps::Placed> Gaps::placed(nb::handle frames) const {
    const Numbers given(frames);
    require(given.is(3, 4 * moving_), "frames must be float64 (3, 4 m)");
    std::vector<Placed> bodies(placements_);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (joints_[b] == 0) continue;
        const Placed& own = placements_[b];
        for (std::size_t i = 0; i < 3; ++i) {
            const double* const row = given.data() + 4 * (i * moving_ + static_cast<std::size_t>(joints_[b]) - 1);
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

template <class Limit> Gaps::Found Gaps::below(const std::vector<Placed>& bodies, Limit limit) const {
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

Gaps::Wrench Gaps::wrench(int k, const std::vector<Placed>& bodies, nb::handle measure) const {
    const Pair& pair = pairs_.at(static_cast<std::size_t>(k));
    if (!pair.exact) return called([&] { return nb::cast<Wrench>(measure(k)); });
    const Way found = way(pair, bodies);
    // From the nearest point of the box to the ball, or through the face that is nearest from inside.
    double out[3], n[3] = {};
    const int face = static_cast<int>(std::max_element(found.beyond, found.beyond + 3) - found.beyond);
    const bool inside = found.beyond[face] <= 0.0;
    for (int i = 0; i < 3; ++i)
        out[i] = std::copysign(inside ? (i == face ? 1.0 : 0.0) : std::max(found.beyond[i], 0.0), found.along[i]);
    const double size = std::hypot(out[0], out[1], out[2]) * (pair.ball < pair.box ? -1.0 : 1.0);
    const Placed& box = bodies[static_cast<std::size_t>(pair.box)];
    for (int i = 0; i < 3; ++i)
        for (int axis = 0; axis < 3; ++axis) n[axis] += box.R[i][axis] * out[i] / size;
    // The line of the force passes through the centre of the ball.
    const double* const p = bodies[static_cast<std::size_t>(pair.ball)].p;
    return {found.gap, n[0], n[1], n[2], p[1] * n[2] - p[2] * n[1], p[2] * n[0] - p[0] * n[2],
            p[0] * n[1] - p[1] * n[0]};
}

void Gaps::approach(nb::handle frames, int k, const Wrench& wrench, double* rates) const {
    require(wrench.size() == 7, "measure gives seven numbers");
    const double *const g = memory(frames), *const n = wrench.data() + 1, *const m = wrench.data() + 4;
    const double* const sides = between_.data() + static_cast<std::size_t>(k) * moving_;
    std::fill_n(rates, n_, 0.0);
    for (std::size_t j = 0; j < moving_; ++j) {
        if (sides[j] == 0.0) continue;
        const double *const x = g + 4 * j, *const y = x + 4 * moving_, *const z = y + 4 * moving_;
        // The moment about the joint's origin, and the power of the wrench in the joint's frame.
        const double at[3] = {m[0] - *y * n[2] + *z * n[1], m[1] - *z * n[0] + *x * n[2], m[2] - *x * n[1] + *y * n[0]};
        double power = 0.0;
        for (std::size_t i = 0; i < 3; ++i)
            power += twists_[6 * j + i] * (x[i + 1] * n[0] + y[i + 1] * n[1] + z[i + 1] * n[2]) +
                     twists_[6 * j + i + 3] * (x[i + 1] * at[0] + y[i + 1] * at[1] + z[i + 1] * at[2]);
        for (std::size_t i = 0; i < n_; ++i) rates[i] += sides[j] * power * coupling_[j * n_ + i];
    }
}

nb::object Gaps::gaps(nb::handle frames, const std::vector<int>& pairs) const {
    const std::vector<Placed> bodies = placed(frames);
    const nb::object found = NumPy::get().empty(nb::int_(pairs.size()));
    for (std::size_t i = 0; i < pairs.size(); ++i)
        memory(found)[i] = way(pairs_.at(static_cast<std::size_t>(pairs[i])), bodies).gap;
    return found;
}

nb::object Gaps::nearest(nb::handle frames, int start, double slack, nb::handle measure) const {
    const auto measured = [&](int k) { return called([&] { return nb::cast<double>(measure(k)); }); };
    std::pair<double, int> best(measured(start), start);
    Found heap = below(placed(frames), [&](std::size_t) { return best.first + slack; });
    std::make_heap(heap.begin(), heap.end(), std::greater<>());
    for (; !heap.empty() && heap.front().first < best.first + slack; heap.pop_back()) {
        std::pop_heap(heap.begin(), heap.end(), std::greater<>());
        const int k = heap.back().second;
        if (k != start) best = std::min(best, {measured(k), k});
    }
    return nb::make_tuple(best.second, best.first);
}

nb::object Gaps::closest(nb::handle frames, nb::handle limits, nb::handle margins, std::size_t count,
                         nb::handle measure) const {
    const Numbers most(limits), least(margins);
    require(most.is(pairs_.size()) && least.is(pairs_.size()), "limits and margins must be float64 (k,)");
    const std::vector<Placed> bodies = placed(frames);
    Found found = below(bodies, [&](std::size_t k) { return most.data()[k]; });
    const auto room = [&](const std::pair<double, int>& each) { return each.first - least.data()[each.second]; };
    std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) { return room(a) < room(b); });
    const auto empty = [](std::size_t size, nb::handle type) { return NumPy::get().empty(nb::int_(size), type); };
    const nb::handle whole = NumPy::get().whole(), truth = NumPy::get().truth();
    const nb::object pairs = empty(found.size(), whole), known = empty(found.size(), truth);
    const nb::object metres = NumPy::get().empty(nb::int_(found.size()));
    std::vector<std::pair<double, std::size_t>> rows;
    std::vector<Wrench> wrenches(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        auto& [distance, k] = found[i];
        const bool near = rows.size() < count || (count > 0 && room(found[i]) <= rows.back().first);
        if (near) {
            wrenches[i] = wrench(k, bodies, measure);
            distance = wrenches[i][0] < most.data()[k] ? wrenches[i][0] : std::numeric_limits<double>::infinity();
            const std::pair<double, std::size_t> row(room(found[i]), i);
            if (std::isfinite(distance)) rows.insert(std::upper_bound(rows.begin(), rows.end(), row), row);
            if (rows.size() > count) rows.pop_back();
        }
        memory<std::int64_t>(pairs)[i] = k;
        memory(metres)[i] = distance;
        memory<bool>(known)[i] = near || pairs_[static_cast<std::size_t>(k)].exact;
    }
    const nb::object owners = empty(rows.size(), whole), rates = NumPy::get().empty(nb::make_tuple(rows.size(), n_));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::size_t row = rows[i].second;
        memory<std::int64_t>(owners)[i] = static_cast<std::int64_t>(row);
        approach(frames, found[row].second, wrenches[row], memory(rates) + n_ * i);
    }
    return nb::make_tuple(pairs, metres, known, owners, rates);
}

}  // namespace bindings
