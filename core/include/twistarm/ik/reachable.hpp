// Which of many targets an arm meets: configurations, without the nearest one and the reason.
#pragma once

#include "far_slides.hpp"
#include "resume.hpp"

TWISTARM_BEGIN

/// Which of job.count() targets of one kind the arm meets, with at most settings.searches searches for each.
///
/// The first search begins at the answer before, so targets that follow one another should be neighbours. The others
/// begin at random starts in the order of `solve`. θ₀ (n,) stands for the answer before the first. `Job` has
/// job.count(), job.asked(t), job.store(t, theta), with a null pointer where no search converges, and job(), which is
/// called now and then; true ends the work.
template <target_kind Kind, class T, int N, int M, class Job>
void find_reachable(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                    const T* theta0, std::uint64_t seed, Job& job) {
    const auto of_kind = [](const target<T>& asked) { return target_of<T, Kind>{asked}; };
    T before[capacity(N)];
    for (int k = 0; k < arm.coordinates(); ++k) before[k] = theta0[k];
    for (std::int64_t t = 0; t < job.count() && !job(); ++t) {
        const target<T> asked = job.asked(t);
        solution<T, N> found;
        search_all(arm, range, settings, of_kind(asked), before, seed, job, found);
        if (!found.converged) {
            ranges<T, N> there = range;
            T start[capacity(N)];
            for (int k = 0; k < arm.coordinates(); ++k) start[k] = before[k];
            if (bring_slides_near(arm, asked, there, start))
                search_all(arm, there, settings, of_kind(asked), start, seed, job, found);
        }
        for (int k = 0; k < arm.coordinates() && found.converged; ++k) before[k] = found.theta[k];
        job.store(t, found.converged ? found.theta : nullptr);
    }
}

TWISTARM_END
