// NumPy's arrays, as they lie in memory: nothing here depends on which NumPy there is.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "lock.hpp"

namespace bindings {

namespace nb = nanobind;

// What only a mistake in this library's own Python breaks.
inline void require(bool holds, const char* otherwise) {
    if (!holds) throw nb::value_error(otherwise);
}

// The start of a NumPy array and of its data type. NumPy's inline functions (PyArray_DATA, PyArray_TYPE …) read it in
// every extension, under 1.x and 2.x alike. So the layout is part of the binary interface.
struct ArrayHead {
    PyObject_HEAD
    char* data;
    int dimensions;
    Py_ssize_t *shape, *strides;
    PyObject* base;
    struct Type {
        PyObject_HEAD
        PyTypeObject* scalar;
        char kind, letter, byte_order, flags;
        int number;
    } const* type;
    int flags;

    static constexpr int float64 = 12, row_by_row = 0x1, aligned = 0x100, writeable = 0x400;
};

// What others will read may not be written to any more.
inline void make_read_only(nb::handle array) {
    reinterpret_cast<ArrayHead*>(array.ptr())->flags &= ~ArrayHead::writeable;
}

// What this extension needs from numpy, looked up once.
class NumPy {
public:
    static const NumPy& get() {
        static const NumPy numpy;
        return numpy;
    }
    bool is_array(nb::handle object) const { return reinterpret_cast<PyObject*>(Py_TYPE(object.ptr())) == array_.ptr(); }
    // A new array of float64 or another type. Like any call of Python, it may end this thread.
    nb::object empty(nb::handle shape) const {
        return called([&] { return nb::object(empty_(shape)); });
    }
    nb::object empty(nb::handle shape, nb::handle type) const {
        return called([&] { return nb::object(empty_(shape, type)); });
    }
    nb::handle truth() const { return truth_; }
    nb::handle whole() const { return whole_; }

private:
    // Never given back: Python is gone before what is static here is.
    NumPy() {
        const nb::module_ numpy = nb::module_::import_("numpy");
        array_ = numpy.attr("ndarray").inc_ref();
        empty_ = numpy.attr("empty").inc_ref();
        truth_ = numpy.attr("bool_").inc_ref();
        whole_ = numpy.attr("int64").inc_ref();
    }
    nb::handle array_, empty_, truth_, whole_;
};

// The numbers of one array, in place, if it is `plain`: float64, row by row, in this machine's byte order. Anything else
// is Python's to convert or to refuse. The caller keeps a reference, and the interpreter lock as long as others could
// resize the array.
class Numbers {
public:
    explicit Numbers(nb::handle object)
        : head_(reinterpret_cast<const ArrayHead*>(object.ptr())),
          plain_(NumPy::get().is_array(object) && head_->type->number == ArrayHead::float64 &&
                 head_->type->byte_order != foreign && in_rows()) {}

    bool plain() const { return plain_; }
    double* data() const { return reinterpret_cast<double*>(head_->data); }
    std::size_t dimensions() const { return static_cast<std::size_t>(head_->dimensions); }
    std::size_t shape(std::size_t axis) const { return static_cast<std::size_t>(head_->shape[axis]); }
    std::size_t size() const {
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < dimensions(); ++axis) count *= shape(axis);
        return count;
    }
    // Whether it is a plain array of this shape.
    template <class... Lengths> bool is(Lengths... lengths) const {
        const std::size_t wanted[] = {static_cast<std::size_t>(lengths)...};
        bool same = plain_ && dimensions() == sizeof...(lengths);
        for (std::size_t axis = 0; same && axis < sizeof...(lengths); ++axis) same = shape(axis) == wanted[axis];
        return same;
    }
    bool finite() const {
        // 0 x is NaN for what is not finite, and so is every sum that it enters.
        double sum = 0.0;
        for (std::size_t i = 0, count = size(); i < count; ++i) sum += 0.0 * data()[i];
        return sum == 0.0;
    }
    void copy_to(double* into) const { std::memcpy(into, data(), size() * sizeof(double)); }

private:
    bool in_rows() const {
        constexpr int usable = ArrayHead::row_by_row | ArrayHead::aligned;
        return (head_->flags & usable) == usable;
    }
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    static constexpr char foreign = '>';
#else
    static constexpr char foreign = '<';
#endif
    const ArrayHead* head_;
    bool plain_;
};

// The memory of an array that this extension or its Python has made.
template <class T = double> T* memory(nb::handle array) {
    return reinterpret_cast<T*>(reinterpret_cast<const ArrayHead*>(array.ptr())->data);
}

// A read-only array with a copy of these numbers.
inline nb::object frozen(nb::handle shape, const double* values, std::size_t count) {
    const nb::object array = NumPy::get().empty(shape);
    std::memcpy(memory(array), values, count * sizeof(double));
    make_read_only(array);
    return array;
}

// A number of Python, or NumPy's float64; it may be infinite or NaN. False for others.
inline bool real(nb::handle value, double& number) {
    if (!PyFloat_Check(value.ptr()) && !PyLong_Check(value.ptr())) return false;
    number = PyFloat_AsDouble(value.ptr());
    if (number != -1.0 || PyErr_Occurred() == nullptr) return true;
    PyErr_Clear();
    return false;
}

// A whole number of Python's from 0 to 2^64 - 1. False for others, and for True and False.
inline bool whole(nb::handle value, std::uint64_t& number) {
    if (!PyLong_Check(value.ptr()) || PyBool_Check(value.ptr())) return false;
    number = PyLong_AsUnsignedLongLong(value.ptr());
    if (number != static_cast<std::uint64_t>(-1) || PyErr_Occurred() == nullptr) return true;
    PyErr_Clear();
    return false;
}

}  // namespace bindings
