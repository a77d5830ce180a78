// When the time is up.
#pragma once

#include <chrono>
#include <limits>

namespace bindings {

// A moment some seconds from now, or never.
class Deadline {
public:
    explicit Deadline(double seconds)
        : never_(!(seconds < longest)) {
        if (!never_) at_ = std::chrono::steady_clock::now() +
            std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
    }
    static constexpr double none = std::numeric_limits<double>::infinity();

    bool never() const { return never_; }
    static bool passed(const void* deadline) {
        const auto* self = static_cast<const Deadline*>(deadline);
        return !self->never_ && std::chrono::steady_clock::now() >= self->at_;
    }

private:
    static constexpr double longest = 1e8;  // [s], three years: beyond it the clock's own numbers overflow
    bool never_;
    std::chrono::steady_clock::time_point at_;
};

}  // namespace bindings
