// twistarm._core: the kernels as Python sees them; _core.pyi says what each means.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "answer.hpp"
#include "chain.hpp"
#include "servo.hpp"

namespace {

namespace nb = nanobind;
using bindings::Chain;
using bindings::OneAnswer;

std::vector<std::string> instruction_sets() {
    std::vector<std::string> names;
    for (auto each = bindings::kernels(); *each != nullptr; ++each) names.emplace_back((*each)->name);
    return names;
}

}  // namespace

NB_MODULE(_core, module) {
    using namespace nb::literals;
    // A program may end while it holds arms.
    nb::set_leak_warnings(false);
    module.doc() = "The compiled kernels; `twistarm.engine.core()` is the door to them.";
    module.attr("INTERFACE") = TWISTARM_INTERFACE;
    module.def("instruction_sets", &instruction_sets);
    nb::class_<OneAnswer>(module, "Answer")
        .def_ro("kind", &OneAnswer::kind)
        .def_ro("position_tol", &OneAnswer::position_tolerance)
        .def_ro("orientation_tol", &OneAnswer::orientation_tolerance)
        .def_prop_ro("numbers",
                     [](const OneAnswer& self) {
                         return OneAnswer::row(self.numbers, bindings::numbers_of_kind[self.kind]);
                     })
        .def_prop_ro("theta0", [](const OneAnswer& self) { return self.theta_row(self.theta0); })
        .def_prop_ro("theta", [](const OneAnswer& self) { return self.theta_row(self.answer.theta); })
        .def_prop_ro("unlimited",
                     [](const OneAnswer& self) -> nb::object {
                         if (!self.answer.has_unlimited) return nb::none();
                         return self.theta_row(self.answer.unlimited);
                     })
        .def_prop_ro("position_error", [](const OneAnswer& self) { return self.answer.position_error; })
        .def_prop_ro("orientation_error", [](const OneAnswer& self) { return self.answer.orientation_error; })
        .def_prop_ro("iterations", [](const OneAnswer& self) { return self.answer.iterations; })
        .def_prop_ro("restarts", [](const OneAnswer& self) { return self.answer.restarts; })
        .def_prop_ro("stop", [](const OneAnswer& self) { return self.answer.stop; })
        .def_prop_ro("nearest", [](const OneAnswer& self) { return self.answer.nearest; })
        .def_prop_ro("other_branch", [](const OneAnswer& self) { return self.answer.other_branch; })
        .def_prop_ro("start_moved", [](const OneAnswer& self) { return self.answer.start_moved; });
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
        .def("solve", &Chain::solve, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(),
             nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg().none())
        .def("are_targets", &Chain::are_targets)
        .def("solve_batch", &Chain::solve_batch, nb::arg(), nb::arg().none(), nb::arg().none(), nb::arg(), nb::arg(),
             nb::arg(), nb::arg(), nb::arg(), nb::arg().none(), nb::arg(), nb::arg().none());
    nb::class_<bindings::Servo>(module, "Servo")
        .def(nb::init<nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, nb::handle,
                      nb::handle, nb::handle, nb::handle, double, double, double, bool>())
        .def("step", &bindings::Servo::step, nb::arg().none(), nb::arg().none(), nb::arg().none(), nb::arg(), nb::arg(),
             nb::arg().none(), nb::arg());
}
