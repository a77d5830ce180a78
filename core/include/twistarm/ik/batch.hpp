// Batch of targets: each lane works on one target and then takes the next.
#pragma once

#include "searches.hpp"
#include "starts.hpp"

TWISTARM_BEGIN

namespace detail {
/// The targets of a batch, one per lane at a time. Each is searched from its θ₀, then from random starts in order.
///
/// `Job` has job.count(), job.asked(t), job.start(t, theta), job.seed(t), job.store(t, solution, ends) and
/// job.goes_on(done). goes_on is called after each target and now and then; false ends the batch, and targets in
/// progress are not stored. job.ends(lane) is null, or room for `most_ends` (n,) ends of the failed searches in a lane;
/// `store` gets them back.
template <class V, target_kind Kind, class T, int N, int M, class Job>
struct batch_of_targets final : search_owner<V, T, N> {
    static constexpr int lane_count = number<V>::lanes;
    static constexpr std::int64_t none = -1;
    static constexpr int looks_for_an_end = 8;  ///< iterations between two questions, where no target is done

    const chain<T, N, M>& arm;
    const ranges<T, N>& range;
    const search_settings<T>& settings;
    Job& job;

    std::int64_t next_target = 0, done = 0, looks = 0;
    bool stopped = false;
    std::int64_t at_target[lane_count]{};
    int search[lane_count]{};
    start_order order[lane_count]{};
    T least_error[lane_count]{};
    target<T> asked[lane_count]{};
    T theta0[lane_count][capacity(N)]{};
    solution<T, N> found[lane_count]{};

    batch_of_targets(const chain<T, N, M>& chain, const ranges<T, N>& within, const search_settings<T>& how, Job& work)
        : search_owner<V, T, N>(aim_in_every_lane<V>(aim<T>{})), arm(chain), range(within), settings(how), job(work) {}

    int start_of(int i) {
        if (Kind != target_kind::pose || job.seed(at_target[i]) != 0) return search[i];
        if (search[i] == 1) order[i] = order_of_starts(range, asked[i].goal, settings.rotation_weight);
        return order[i][search[i]];
    }

    void put(lane_starts<T, N, lane_count>& starts, int i) {
        if (search[i] == 0)
            for (int k = 0; k < arm.coordinates(); ++k) starts.theta[k][i] = theta0[i][k];
        else random_start(range, arm.coordinates(), job.seed(at_target[i]), start_of(i), &starts.theta[0][i], lane_count);
        starts.waiting |= 1U << i;
    }

    void take_next(lane_starts<T, N, lane_count>& starts, int i) {
        at_target[i] = none;
        if (stopped || next_target == job.count()) return;
        at_target[i] = next_target++;
        asked[i] = job.asked(at_target[i]);
        job.start(at_target[i], theta0[i]);
        bring_inside(range, arm.coordinates(), theta0[i]);
        set_lane(this->aims, i, aim_at(arm, asked[i]));
        search[i] = 0;
        found[i].iterations = 0;
        least_error[i] = static_cast<T>(__builtin_inf());
        put(starts, i);
    }

    void hand_over(lane_starts<T, N, lane_count>& starts, int i) {
        found[i].restarts = search[i] + 1;
        job.store(at_target[i], found[i], job.ends(i));
        stopped = !job.goes_on(++done) || stopped;
        take_next(starts, i);
    }

    bool converged(const lane_searches<V, N>& lanes, int i) {
        solution<T, N> candidate = found[i];
        if (!accept(lanes, i, range, arm.coordinates(), Kind, theta0[i], candidate)) return false;
        polish_as<Kind>(arm, range, settings, asked[i], theta0[i], candidate);
        if (search[i] == 0) candidate.start_error = lane_of<T>(lanes.first.position, lanes.first.rotation, i);
        found[i] = candidate;
        return true;
    }

    void failed(const lane_searches<V, N>& lanes, lane_starts<T, N, lane_count>& starts, int i) {
        found[i].iterations += static_cast<int>(lane(lanes.iterations, i));
        T* ends = search[i] < most_ends ? job.ends(i) : nullptr;
        for (int k = 0; ends != nullptr && k < arm.coordinates(); ++k)
            ends[search[i] * arm.coordinates() + k] = lane(lanes.theta[k], i);
        if (search[i] == 0) found[i].start_error = lane_of<T>(lanes.first.position, lanes.first.rotation, i);
        const T error = lane(lanes.error, i);
        if (search[i] == 0 || error < least_error[i]) {
            least_error[i] = error;
            for (int k = 0; k < arm.coordinates(); ++k) found[i].theta[k] = lane(lanes.theta[k], i);
        }
        if (++search[i] < settings.searches) {
            put(starts, i);
            return;
        }
        --search[i];
        judge_end(arm, range, settings, asked[i], theta0[i], found[i]);
        hand_over(starts, i);
    }

    void collect(const lane_searches<V, N>& lanes, lane_starts<T, N, lane_count>& starts, unsigned ended,
                unsigned reached) override {
        for (; ended != 0U; ended &= ended - 1U) {
            const int i = __builtin_ctz(ended);
            if (at_target[i] == none || stopped) continue;
            if ((reached >> i & 1U) != 0U && converged(lanes, i)) hand_over(starts, i);
            else failed(lanes, starts, i);
        }
    }

    bool finished(const lane_searches<V, N>&) override {
        if (++looks % looks_for_an_end == 0) stopped = stopped || !job.goes_on(done);
        return stopped || done == job.count();
    }
};
}  // namespace detail

/// Inverse kinematics of job.count() targets of one kind.
///
/// Each target is searched from its θ₀, then from random starts in the order of `solve`. The first search in this order
/// that meets the target itself gives the answer. So the verdicts are those of `solve`, and an answer depends on its target alone. It
/// may be another root than that of `solve`, which races whole rounds to finish sooner. If no search converges, the end
/// with the least error is stored; `conclude` finds the nearest configuration and the reason from there.
template <target_kind Kind, class T, int N, int M, class Job>
void solve_batch(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings, Job& job) {
    constexpr int at_once = lanes_at_once<T>;
    using V = pack<T, at_once>;
    if (job.count() == 0) return;
    detail::batch_of_targets<V, Kind, T, N, M, Job> batch(arm, range, settings, job);
    lane_searches<V, N> lanes = searches_at_rest<V, N>();
    lane_starts<T, N, at_once> starts;
    for (int i = 0; i < at_once; ++i) batch.take_next(starts, i);
    run_searches<V, Kind, T, N, M>(arm, range, settings, lanes, starts, batch);
}

TWISTARM_END
