// Which of many targets an arm meets: verdicts and configurations, without the nearest configuration and the reason.
#pragma once

#include "far_slides.hpp"
#include "resume.hpp"

TWISTARM_BEGIN

namespace detail {
/// The answers that are remembered, and how many of them a search begins from.
constexpr int remembered = 64, recalled = 3;

/// The last answers, each with its target.
template <class T, int N> struct answers_before {
    static constexpr int width = 15;
    T features[remembered][width], theta[remembered][capacity(N)];
    int count = 0;

    static void describe(const target<T>& asked, T* feature) {
        for (int k = 0; k < 3; ++k) {
            const T each[] = {asked.goal.p[k], asked.goal.x[k], asked.goal.y[k], asked.goal.z[k], asked.direction[k]};
            for (int i = 0; i < 5; ++i) feature[5 * k + i] = each[i];
        }
    }

    void add(const target<T>& asked, const T* found, int n) {
        const int at = count++ % remembered;
        describe(asked, features[at]);
        for (int k = 0; k < n; ++k) theta[at][k] = found[k];
    }

    /// The answers to the targets most like this one, the most like it first; how many there are.
    int recall(const target<T>& asked, const T* (&nearest)[recalled]) const {
        T here[width], least[recalled];
        describe(asked, here);
        const int there = count < remembered ? count : remembered;
        int kept = 0;
        for (int a = 0; a < there; ++a) {
            T apart = T(0);
            for (int i = 0; i < width; ++i) apart += (features[a][i] - here[i]) * (features[a][i] - here[i]);
            int at = kept < recalled ? kept++ : recalled;
            for (; at > 0 && apart < least[at - 1]; --at)
                if (at < recalled) {
                    least[at] = least[at - 1];
                    nearest[at] = nearest[at - 1];
                }
            if (at == recalled) continue;
            least[at] = apart;
            nearest[at] = theta[a];
        }
        return kept;
    }
};

/// Searches from `known` starts, from θ₀ and from random starts, then from where the best of them ended.
template <target_kind Kind, class T, int N, int M, class Stopped>
bool meets(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
           const target<T>& asked, const T* const* known, int count, const T* theta0, const start_sequence<N>& sequence,
           Stopped& stopped, solution<T, N>& found) {
    const int n = arm.coordinates();
    T ends[most_ends * capacity(N)];
    const T* const near = count > 0 ? known[0] : theta0;
    const auto begins = [&](int search, T* theta, int stride) {
        if (search > count) return start_at(range, n, sequence, search - count, theta, stride);
        const T* const from = search < count ? known[search] : theta0;
        for (int k = 0; k < n; ++k) theta[k * stride] = from[k];
    };
    if (race_to<pack<T, lanes_at_once<T>>, Kind>(arm, range, settings, asked, begins, near, ends, most_ends, stopped, found))
        return true;
    judge(arm, range, settings, asked, near, found);
    found.converged = false;
    resume_as_needed<Kind>(arm, range, settings, asked, near, ends, least(found.restarts, most_ends), stopped, found);
    return found.converged;
}
}  // namespace detail

/// Which of job.count() targets of one kind the arm meets, with at most settings.searches searches for each.
///
/// The searches begin at the answers to the nearest of the targets before, at θ₀ and at random starts. So targets that
/// follow one another should be neighbours. `Job` has job.count(), job.asked(t), job.store(t, theta), theta null where
/// none was found, and job.stopped(); true ends the work.
template <target_kind Kind, class T, int N, int M, class Job>
void find_reachable(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                    const T* theta0, std::uint64_t seed, Job& job) {
    const int n = arm.coordinates();
    detail::answers_before<T, N> before;
    T start[capacity(N)];
    for (int k = 0; k < n; ++k) start[k] = theta0[k];
    bring_inside(range, n, start);
    const start_sequence<N> sequence = sequence_of<N>(seed, n);
    const auto stopped = [&] { return job.stopped(); };
    for (std::int64_t t = 0; t < job.count() && !stopped(); ++t) {
        const target<T> asked = job.asked(t);
        const T* known[detail::recalled];
        solution<T, N> found{};
        const bool met = detail::meets<Kind>(arm, range, settings, asked, known, before.recall(asked, known), start,
                                             sequence, stopped, found);
        if (met) before.add(asked, found.theta, n);
        job.store(t, met ? found.theta : nullptr);
    }
}

TWISTARM_END
