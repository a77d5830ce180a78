// Tells when a call has to end: its time is up, or the user has pressed Ctrl-C.
#pragma once

#include <chrono>
#include <limits>

#include "lock.hpp"

namespace bindings {

using Steady = std::chrono::steady_clock;

constexpr auto patience = std::chrono::milliseconds(50);  // between two looks at Ctrl-C

// A moment some seconds from now, or never.
class Deadline {
public:
    explicit Deadline(double seconds) : never_(!(seconds < longest)) {
        if (!never_) at_ = Steady::now() + std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(seconds));
    }
    static constexpr double none = std::numeric_limits<double>::infinity();

    bool never() const { return never_; }
    bool passed(Steady::time_point now) const { return !never_ && now >= at_; }
    static bool passed(const void* deadline) {
        const auto* self = static_cast<const Deadline*>(deadline);
        return !self->never_ && self->passed(Steady::now());
    }

private:
    static constexpr double longest = 1e8;  // [s], three years: beyond it the clock's own numbers overflow
    bool never_;
    Steady::time_point at_;
};

// The time of a call that works in its caller's thread. It keeps the interpreter lock until the first check of the
// time. A call that ends within a microsecond or two never checks; releasing the lock would cost it a tenth.
class Watch {
public:
    explicit Watch(double seconds) : deadline_(seconds) {}
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    static bool passed(const void* watch) { return static_cast<Watch*>(const_cast<void*>(watch))->look(); }

    // Takes the lock again. Call it when the work is done, with or without a result. Throws what a signal handler has
    // raised.
    void end() {
        if (state_ != nullptr) take_lock(state_);
        state_ = nullptr;
        if (raised_) throw nanobind::python_error();
    }

private:
    static constexpr unsigned looks = 8;  // to each reading of the clock where there is no deadline

    bool look() {
        if (state_ == nullptr) {
            state_ = PyEval_SaveThread();
            heard_ = Steady::now();
        }
        if (raised_ || (deadline_.never() && ++asked_ % looks != 0U)) return raised_;
        const Steady::time_point now = Steady::now();
        if (now - heard_ >= patience) hear(now);
        return raised_ || deadline_.passed(now);
    }

    void hear(Steady::time_point now) {
        heard_ = now;
        take_lock(state_);
        raised_ = called([] { return PyErr_CheckSignals() != 0; });
        state_ = PyEval_SaveThread();
    }

    Deadline deadline_;
    PyThreadState* state_ = nullptr;
    Steady::time_point heard_;
    unsigned asked_ = 0;
    bool raised_ = false;
};

}  // namespace bindings
