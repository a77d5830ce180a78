// NumPy's arrays through Python's buffers: nothing here depends on which NumPy there is.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>

namespace bindings {

namespace nb = nanobind;

// The start of a NumPy array and of its data type, which NumPy's own inline functions (PyArray_DATA, PyArray_TYPE …) read
// in whatever extension they are compiled into, under 1.x and 2.x alike: its layout is part of the binary interface.
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

// numpy.ndarray and numpy.empty, looked up once.
class NumPy {
public:
    static const NumPy& get() {
        static const NumPy numpy;
        return numpy;
    }
    bool is_array(nb::handle object) const { return reinterpret_cast<PyObject*>(Py_TYPE(object.ptr())) == array_.ptr(); }
    nb::object empty(nb::handle shape) const { return empty_(shape); }

private:
    // Never given back: Python is gone before what is static here is.
    NumPy() {
        const nb::module_ numpy = nb::module_::import_("numpy");
        array_ = numpy.attr("ndarray").inc_ref();
        empty_ = numpy.attr("empty").inc_ref();
    }
    nb::handle array_, empty_;
};

// An array's numbers; `plain` if they are float64 in a row, in this machine's byte order. Anything else is Python's to
// convert or to refuse. Its owner must hold the array.
class Numbers {
public:
    explicit Numbers(nb::handle object) : head_(reinterpret_cast<const ArrayHead*>(object.ptr())) {
        constexpr int usable = ArrayHead::row_by_row | ArrayHead::aligned;
        plain_ = NumPy::get().is_array(object) && head_->type->number == ArrayHead::float64 &&
                 head_->type->byte_order != foreign && (head_->flags & usable) == usable;
    }

    bool plain() const { return plain_; }
    double* data() const { return reinterpret_cast<double*>(head_->data); }
    std::size_t dimensions() const { return static_cast<std::size_t>(head_->dimensions); }
    std::size_t shape(std::size_t axis) const { return static_cast<std::size_t>(head_->shape[axis]); }
    std::size_t size() const {
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < dimensions(); ++axis) count *= shape(axis);
        return count;
    }
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
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    static constexpr char foreign = '>';
#else
    static constexpr char foreign = '<';
#endif
    const ArrayHead* head_;
    bool plain_;
};

}  // namespace bindings
