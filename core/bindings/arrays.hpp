// NumPy's arrays, as they lie in memory: nothing here depends on which NumPy there is.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstring>

#include "lock.hpp"

namespace bindings {

namespace nb = nanobind;

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
    // A scalar of NumPy's own that is a real number, or a whole one.
    bool is_number(nb::handle object) const { return is_integer(object) || is_a(object, floating_); }
    bool is_integer(nb::handle object) const { return is_a(object, integer_); }
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
        floating_ = numpy.attr("floating").inc_ref();
        integer_ = numpy.attr("integer").inc_ref();
        truth_ = numpy.attr("bool_").inc_ref();
        whole_ = numpy.attr("int64").inc_ref();
    }
    static bool is_a(nb::handle object, nb::handle type) {
        return PyObject_TypeCheck(object.ptr(), reinterpret_cast<PyTypeObject*>(type.ptr()));
    }
    nb::handle array_, empty_, floating_, integer_, truth_, whole_;
};

// The numbers of one array, in place. The caller keeps a reference, and the interpreter lock as long as others could
// resize the array.
class Array {
public:
    explicit Array(nb::handle array) : head_(reinterpret_cast<const ArrayHead*>(array.ptr())) {}

    // Whether it is float64 in a row, in this machine's byte order.
    bool plain() const {
        constexpr int usable = ArrayHead::row_by_row | ArrayHead::aligned;
        return type() == ArrayHead::float64 && native() && (head_->flags & usable) == usable;
    }
    bool native() const { return head_->type->byte_order != foreign; }
    int type() const { return head_->type->number; }
    const char* bytes() const { return head_->data; }
    double* data() const { return as<double>(); }
    template <class T> T* as() const { return reinterpret_cast<T*>(head_->data); }
    const Py_ssize_t* strides() const { return head_->strides; }
    std::size_t dimensions() const { return static_cast<std::size_t>(head_->dimensions); }
    std::size_t shape(std::size_t axis) const { return static_cast<std::size_t>(head_->shape[axis]); }
    std::size_t size() const {
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < dimensions(); ++axis) count *= shape(axis);
        return count;
    }
    bool is(const std::size_t* shape_wanted, std::size_t axes) const {
        bool same = dimensions() == axes;
        for (std::size_t axis = 0; same && axis < axes; ++axis) same = shape(axis) == shape_wanted[axis];
        return same;
    }

private:
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    static constexpr char foreign = '>';
#else
    static constexpr char foreign = '<';
#endif
    const ArrayHead* head_;
};

// A read-only array with a copy of these numbers.
inline nb::object frozen(const nb::object& array, const double* values, std::size_t count) {
    std::memcpy(Array(array).data(), values, count * sizeof(double));
    make_read_only(array);
    return array;
}

inline nb::object frozen(const double* values, std::size_t count) {
    return frozen(NumPy::get().empty(nb::int_(count)), values, count);
}

// A new value of a bound class, made where Python keeps it.
template <class T> nb::object made(T*& value) {
    static const nb::handle type = nb::type<T>();
    nb::object object = nb::inst_alloc(type);
    value = new (nb::inst_ptr<T>(object)) T;
    nb::inst_mark_ready(object);
    return object;
}

// Any object's numbers, if it is an array of plain ones. Anything else is Python's to convert or to refuse.
class Numbers {
public:
    explicit Numbers(nb::handle object) : array_(object), plain_(NumPy::get().is_array(object) && array_.plain()) {}

    bool plain() const { return plain_; }
    double* data() const { return array_.data(); }
    std::size_t dimensions() const { return array_.dimensions(); }
    std::size_t shape(std::size_t axis) const { return array_.shape(axis); }
    std::size_t size() const { return array_.size(); }
    bool is(std::size_t rows) const { return plain_ && dimensions() == 1 && shape(0) == rows; }
    bool is(std::size_t rows, std::size_t columns) const {
        return plain_ && dimensions() == 2 && shape(0) == rows && shape(1) == columns;
    }
    bool finite() const {
        // 0 x is NaN for what is not finite, and so is every sum that it enters.
        double sum = 0.0;
        for (std::size_t i = 0, count = size(); i < count; ++i) sum += 0.0 * data()[i];
        return sum == 0.0;
    }

private:
    Array array_;
    bool plain_;
};

}  // namespace bindings
