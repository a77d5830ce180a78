// twistarm._core: the kernels as Python sees them; _core.pyi says what each means.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "chain.hpp"
#include "closed_form.hpp"
#include "gaps.hpp"
#include "planning.hpp"
#include "servo.hpp"
#include "targets.hpp"

namespace {

namespace nb = nanobind;
using bindings::Chain;

std::vector<std::string> instruction_sets() {
    std::vector<std::string> names;
    for (auto kernel = bindings::kernels(); *kernel != nullptr; ++kernel) names.emplace_back((*kernel)->name);
    return names;
}

}  // namespace

NB_MODULE(_core, module) {
    using namespace nb::literals;
    if (*bindings::kernels() == nullptr) throw nb::import_error("it was compiled for a processor with more instructions");
    // A program may end while it holds arms.
    nb::set_leak_warnings(false);
    module.doc() = "The compiled kernels; `twistarm.arm.engine.core()` is the door to them.";
    module.attr("INTERFACE") = TWISTARM_INTERFACE;
    module.def("instruction_sets", &instruction_sets);
    module.def("pose", &bindings::pose, nb::arg().none());
    module.def("position", &bindings::position, nb::arg().none());
    module.def("approach", &bindings::approach, nb::arg().none(), nb::arg().none(), nb::arg().none());
    module.def("task", &bindings::task, nb::arg().none(), nb::arg().none(), nb::arg());
    module.def("path_velocity", &bindings::path_velocity, nb::arg().none(), nb::arg().none(), nb::arg().none(),
               nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg());
    module.def("shares_of_average", &bindings::shares_of_average, nb::arg().none(), nb::arg().none(), nb::arg().none(),
               nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
               nb::arg().none(), nb::arg().none(), nb::arg());
    nb::class_<Chain>(module, "Chain")
        .def(nb::init<nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, double,
                      const std::string&>(),
             "screws"_a, "home"_a, "coupling"_a, "lower"_a, "upper"_a, "start_lower"_a, "start_upper"_a, "reach"_a,
             "instruction_set"_a = "")
        .def_prop_ro("n", &Chain::n)
        .def_prop_ro("instruction_set", &Chain::instruction_set)
        .def("constants", &Chain::constants)
        .def("fk", &Chain::fk, nb::arg().none())
        .def("spatial_jacobian", &Chain::spatial_jacobian, nb::arg().none())
        .def("body_jacobian", &Chain::body_jacobian, nb::arg().none())
        .def("fk_and_body_jacobian", &Chain::fk_and_body_jacobian, nb::arg().none())
        .def("split_rotation", &Chain::split_rotation, nb::arg().none(), nb::arg().none(), nb::arg().none())
        .def("solve", &Chain::solve, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none())
        .def("solve_batch", &Chain::solve_batch, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg())
        .def("reachable", &Chain::reachable, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none());
    nb::class_<bindings::ClosedForm>(module, "ClosedForm")
        .def(nb::init<nb::object, int, int, int, int, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle,
                      nb::handle, nb::handle, nb::handle>())
        .def("solve", &bindings::ClosedForm::solve, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none())
        .def("verify", &bindings::ClosedForm::verify, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none())
        .def("candidates", &bindings::ClosedForm::candidates, nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none())
        .def("solve_batch", &bindings::ClosedForm::solve_batch, nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg().none());
    nb::class_<bindings::Servo>(module, "Servo")
        .def(nb::init<nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle,
                      nb::handle, nb::handle, nb::handle, double, double, double, bool>())
        .def("step", &bindings::Servo::step, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg(), nb::arg(),
             nb::arg().none(), nb::arg(), nb::arg(), nb::arg().none());
    nb::class_<bindings::Gaps>(module, "Gaps")
        .def(nb::init<std::vector<int>, nb::handle, std::vector<int>, std::vector<int>, nb::handle, nb::handle,
                      nb::handle, nb::handle>())
        .def("gaps", &bindings::Gaps::gaps)
        .def("nearest", &bindings::Gaps::nearest)
        .def("closest", &bindings::Gaps::closest);
}
