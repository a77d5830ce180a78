#include "questions.hpp"

namespace bindings {

namespace {

constexpr std::size_t most_targets = 1000000000;  // more is a mistake

}  // namespace

bool read_thetas(nb::handle given, std::size_t count, std::size_t n, Each& thetas) {
    const std::size_t each[] = {count, n};
    if (row(given, n, thetas.make(n))) return true;
    thetas.step = n;
    return has_axes(given, 2) && numbers(given, each, 2, thetas.make(count * n));
}

bool read_targets(nb::handle given, int kind, Questions& asked) {
    const std::size_t width = numbers_of_kind[kind];
    // Checks a number of items before memory is allocated for them.
    if (!length(given, asked.count) || asked.count > most_targets || !has_axes(given, kind == 0 ? 3 : 2)) return false;
    const std::size_t poses[] = {asked.count, 4, 4}, others[] = {asked.count, width};
    double* const values = asked.numbers.make(asked.count * width);
    asked.numbers.step = width;
    if (!(kind == 0 ? numbers(given, poses, 3, values) : numbers(given, others, 2, values))) return false;
    for (std::size_t t = 0; t < asked.count; ++t)
        if (!is_target(kind, values + t * width)) return false;
    return true;
}

}  // namespace bindings
