#include "answer.hpp"

namespace bindings {

nb::object Record::type(std::size_t n, std::size_t numbers) {
    nb::list names, formats, offsets;
    const auto field = [&](const char* name, nb::object format, std::size_t offset) {
        names.append(name);
        formats.append(format);
        offsets.append(offset);
    };
    const nb::str real("f8"), whole("i8"), flag("?");
    field("position_error", real, offsetof(Record, position_error));
    field("orientation_error", real, offsetof(Record, orientation_error));
    field("position_tol", real, offsetof(Record, position_tol));
    field("orientation_tol", real, offsetof(Record, orientation_tol));
    field("iterations", whole, offsetof(Record, iterations));
    field("restarts", whole, offsetof(Record, restarts));
    field("stop", whole, offsetof(Record, stop));
    field("kind", whole, offsetof(Record, kind));
    field("nearest", flag, offsetof(Record, nearest));
    field("has_unlimited", flag, offsetof(Record, has_unlimited));
    field("other_branch", flag, offsetof(Record, other_branch));
    field("start_moved", flag, offsetof(Record, start_moved));
    field("by_closed_form", flag, offsetof(Record, by_closed_form));
    field("certain", flag, offsetof(Record, certain));
    std::size_t at = sizeof(Record);
    const auto row = [&](const char* name, std::size_t count) {
        field(name, nb::make_tuple(real, nb::make_tuple(count)), at);
        at += count * sizeof(double);
    };
    row("theta", n);
    row("unlimited", n);
    row("theta0", n);
    row("numbers", numbers);
    nb::dict layout;
    layout["names"] = names;
    layout["formats"] = formats;
    layout["offsets"] = offsets;
    layout["itemsize"] = at;
    return nb::module_::import_("numpy").attr("dtype")(layout);
}

void Record::ask(const Query& query, const Question& question, std::size_t n) {
    *this = Record{};
    stop = not_finished;
    kind = query.kind;
    position_tol = query.position_tolerance;
    orientation_tol = query.orientation_tolerance;
    double* const start = rows() + 2 * n;
    for (std::size_t k = 0; k < n; ++k) start[k] = question.theta0[k];
    for (std::size_t k = 0; k < numbers_of_kind[query.kind]; ++k) start[n + k] = question.numbers[k];
}

void Record::answer(const Answer& found, std::size_t n) {
    position_error = found.position_error;
    orientation_error = found.orientation_error;
    iterations = found.iterations;
    restarts = found.restarts;
    stop = found.stop;
    nearest = found.nearest;
    has_unlimited = found.has_unlimited;
    other_branch = found.other_branch;
    start_moved = found.start_moved;
    double *const theta = rows(), *const unlimited = theta + n;
    for (std::size_t k = 0; k < n; ++k) {
        theta[k] = found.theta[k];
        unlimited[k] = found.has_unlimited ? found.unlimited[k] : 0.0;
    }
}

void OneAnswer::define(nb::module_& module) {
    using One = OneAnswer;
    nb::class_<One>(module, "Answer")
        .def_prop_ro("theta", [](const One& one) { return frozen(one.found.theta, one.n); })
        .def_prop_ro("theta0", [](const One& one) { return frozen(one.theta0, one.n); })
        .def_prop_ro("numbers", [](const One& one) { return frozen(one.numbers, numbers_of_kind[one.kind]); })
        .def_prop_ro("unlimited",
                     [](const One& one) {
                         const double nothing[most_joints] = {};
                         return frozen(one.found.has_unlimited ? one.found.unlimited : nothing, one.n);
                     })
        .def_ro("kind", &One::kind)
        .def_ro("position_tol", &One::position_tol)
        .def_ro("orientation_tol", &One::orientation_tol)
        .def_prop_ro("position_error", [](const One& one) { return one.found.position_error; })
        .def_prop_ro("orientation_error", [](const One& one) { return one.found.orientation_error; })
        .def_prop_ro("iterations", [](const One& one) { return one.found.iterations; })
        .def_prop_ro("restarts", [](const One& one) { return one.found.restarts; })
        .def_prop_ro("stop", [](const One& one) { return one.found.stop; })
        .def_prop_ro("nearest", [](const One& one) { return one.found.nearest; })
        .def_prop_ro("has_unlimited", [](const One& one) { return one.found.has_unlimited; })
        .def_prop_ro("other_branch", [](const One& one) { return one.found.other_branch; })
        .def_prop_ro("start_moved", [](const One& one) { return one.found.start_moved; })
        .def_prop_ro("by_closed_form", [](const One&) { return false; })
        .def_prop_ro("certain", [](const One&) { return false; });
}

}  // namespace bindings
