#include "given.hpp"

#include <cstring>

namespace bindings {

namespace {

// A new reference to a number made from `value`, or false with no error set.
bool made(PyObject* number, nb::object& kept) {
    kept = nb::steal(number);
    if (number == nullptr) PyErr_Clear();
    return number != nullptr;
}

template <class T>
void copy(const char* from, const Py_ssize_t* strides, const std::size_t* shape, std::size_t axes, double*& into) {
    if (axes == 0) {
        T value;
        std::memcpy(&value, from, sizeof(T));
        *into++ = static_cast<double>(value);
        return;
    }
    for (std::size_t i = 0; i < *shape; ++i) copy<T>(from + static_cast<Py_ssize_t>(i) * *strides, strides + 1, shape + 1, axes - 1, into);
}

// Types are NumPy's type numbers: bool, the integers from char to long long, float and double.
bool copy_of(const Array& array, const std::size_t* shape, std::size_t axes, double* into) {
    if (!array.is(shape, axes) || !array.native()) return false;
    if (array.plain()) {
        std::memcpy(into, array.bytes(), array.size() * sizeof(double));
        return true;
    }
    const char* const from = array.bytes();
    const Py_ssize_t* const strides = array.strides();
    switch (array.type()) {
        case 0: copy<bool>(from, strides, shape, axes, into); return true;
        case 1: copy<signed char>(from, strides, shape, axes, into); return true;
        case 2: copy<unsigned char>(from, strides, shape, axes, into); return true;
        case 3: copy<short>(from, strides, shape, axes, into); return true;
        case 4: copy<unsigned short>(from, strides, shape, axes, into); return true;
        case 5: copy<int>(from, strides, shape, axes, into); return true;
        case 6: copy<unsigned>(from, strides, shape, axes, into); return true;
        case 7: copy<long>(from, strides, shape, axes, into); return true;
        case 8: copy<unsigned long>(from, strides, shape, axes, into); return true;
        case 9: copy<long long>(from, strides, shape, axes, into); return true;
        case 10: copy<unsigned long long>(from, strides, shape, axes, into); return true;
        case 11: copy<float>(from, strides, shape, axes, into); return true;
        case 12: copy<double>(from, strides, shape, axes, into); return true;
        default: return false;
    }
}

}  // namespace

bool real(nb::handle value, double& number) {
    PyObject* const given = value.ptr();
    if (PyFloat_Check(given)) {
        number = PyFloat_AS_DOUBLE(given);
        return true;
    }
    nb::object kept;
    if (!PyLong_Check(given)) {
        if (!NumPy::get().is_number(value) || !made(PyNumber_Float(given), kept)) return false;
        number = PyFloat_AS_DOUBLE(kept.ptr());
        return true;
    }
    number = PyLong_AsDouble(given);
    if (number != -1.0 || PyErr_Occurred() == nullptr) return true;
    PyErr_Clear();
    return false;
}

bool whole(nb::handle value, std::uint64_t& number) {
    nb::object kept;
    PyObject* given = value.ptr();
    if (!PyLong_Check(given)) {
        if (!NumPy::get().is_integer(value) || !made(PyNumber_Index(given), kept)) return false;
        given = kept.ptr();
    } else if (PyBool_Check(given)) {
        return false;
    }
    number = PyLong_AsUnsignedLongLong(given);
    if (number != static_cast<std::uint64_t>(-1) || PyErr_Occurred() == nullptr) return true;
    PyErr_Clear();
    return false;
}

bool length(nb::handle value, std::size_t& count) {
    if (PyList_CheckExact(value.ptr()) || PyTuple_CheckExact(value.ptr())) {
        count = static_cast<std::size_t>(Py_SIZE(value.ptr()));
        return true;
    }
    if (!NumPy::get().is_array(value)) return false;
    const Array array(value);
    if (array.dimensions() == 0) return false;
    count = array.shape(0);
    return true;
}

bool has_axes(nb::handle value, std::size_t axes) {
    for (nb::object item = nb::borrow(value); axes > 0; --axes) {
        if (NumPy::get().is_array(item)) return Array(item).dimensions() == axes;
        std::size_t count = 0;
        if (!length(item, count)) return false;
        if (count == 0) return true;
        item = nb::borrow(PyList_CheckExact(item.ptr()) ? PyList_GET_ITEM(item.ptr(), 0) : PyTuple_GET_ITEM(item.ptr(), 0));
    }
    return true;
}

bool numbers(nb::handle value, const std::size_t* shape, std::size_t axes, double* into) {
    if (axes == 0) return real(value, *into);
    if (NumPy::get().is_array(value)) return copy_of(Array(value), shape, axes, into);
    std::size_t count = 0, step = 1;
    if (!length(value, count) || count != *shape) return false;
    for (std::size_t axis = 1; axis < axes; ++axis) step *= shape[axis];
    const bool listed = PyList_CheckExact(value.ptr());
    for (std::size_t i = 0; i < count; ++i, into += step) {
        // A number's own conversion may change the list that it is in.
        if (static_cast<std::size_t>(Py_SIZE(value.ptr())) != count) return false;
        const auto at = static_cast<Py_ssize_t>(i);
        const nb::object item = nb::borrow(listed ? PyList_GET_ITEM(value.ptr(), at) : PyTuple_GET_ITEM(value.ptr(), at));
        if (!numbers(item, shape + 1, axes - 1, into)) return false;
    }
    return true;
}

}  // namespace bindings
