// Packs of L numbers that are computed side by side: one search or one target per lane.
//
// A kernel is a template on its number type V: a scalar (float, double) or pack<T, L>, with the registers that L
// numbers need. Lanes never mix: the result of a lane does not depend on its neighbours or their number.
#pragma once

#include <cstdint>
#include <type_traits>

#include "instruction_set.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

TWISTARM_BEGIN

/// Searches side by side where a rule counts on their number, on every instruction set.
constexpr int searches_in_group = 8;

/// The number of lanes where it does not affect answers: those of one register, at most `Most`, a power of two.
template <class T, int Most = 8>
constexpr int lanes_at_once = TWISTARM_REGISTER_BYTES < Most * static_cast<int>(sizeof(T))
                                  ? TWISTARM_REGISTER_BYTES / static_cast<int>(sizeof(T))
                                  : Most;

namespace detail {
template <class T> struct integer_as_wide;
template <> struct integer_as_wide<double> { using type = std::int64_t; };
template <> struct integer_as_wide<float> { using type = std::int32_t; };

template <class T, int L> struct layout {
    static constexpr int whole = L * static_cast<int>(sizeof(T));
    static constexpr int bytes = whole < TWISTARM_REGISTER_BYTES ? whole : TWISTARM_REGISTER_BYTES;
    static constexpr int parts = whole / bytes;
    static constexpr int width = L / parts;
    using integer = typename integer_as_wide<T>::type;
    typedef T floats __attribute__((vector_size(bytes)));
    typedef integer integers __attribute__((vector_size(bytes)));
};

template <class Part> TWISTARM_INLINE unsigned sign_bits(const Part& part, int width) {
    unsigned bits = 0;
    for (int i = 0; i < width; ++i) bits |= static_cast<unsigned>(part[i] < 0) << i;
    return bits;
}

/// The sign bits of one register of 64-bit or 32-bit integers, lane 0 lowest.
template <class T, int L> TWISTARM_INLINE unsigned part_bits(const typename layout<T, L>::integers& part) {
    [[maybe_unused]] constexpr int bytes = layout<T, L>::bytes;
#if defined(__AVX512DQ__)
    if constexpr (bytes == 64 && sizeof(T) == 8) return _mm512_movepi64_mask(reinterpret_cast<__m512i>(part));
#endif
#if defined(__AVX__)
    if constexpr (bytes == 32 && sizeof(T) == 8)
        return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(part)));
    if constexpr (bytes == 32 && sizeof(T) == 4)
        return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(part)));
#endif
#if defined(__SSE2__)
    if constexpr (bytes == 16 && sizeof(T) == 8)
        return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(part)));
    if constexpr (bytes == 16 && sizeof(T) == 4)
        return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(part)));
#endif
    return sign_bits(part, layout<T, L>::width);
}
}  // namespace detail

/// L truth values, each all ones or all zeros in an integer as wide as T.
template <class T, int L> struct mask {
    using layout = detail::layout<T, L>;
    typename layout::integers part[layout::parts];
};

/// L integers as wide as T: the bit patterns of a pack.
template <class T, int L> struct bit_pack {
    using layout = detail::layout<T, L>;
    typename layout::integers part[layout::parts];
};

/// L numbers of type T.
template <class T, int L> struct pack {
    using layout = detail::layout<T, L>;
    typename layout::floats part[layout::parts];

    pack() = default;
    /// The same number in every lane.
    TWISTARM_INLINE pack(T value) {
        for (int i = 0; i < layout::parts; ++i) part[i] = value - typename layout::floats{};
    }
    TWISTARM_INLINE T operator[](int lane) const { return part[lane / layout::width][lane % layout::width]; }
    TWISTARM_INLINE void set(int lane, T value) { part[lane / layout::width][lane % layout::width] = value; }
};

#define TWISTARM_ARITHMETIC(OP)                                                                    \
    template <class T, int L> TWISTARM_INLINE pack<T, L> operator OP(const pack<T, L>& a, const pack<T, L>& b) { \
        pack<T, L> c;                                                                              \
        for (int i = 0; i < pack<T, L>::layout::parts; ++i) c.part[i] = a.part[i] OP b.part[i];    \
        return c;                                                                                  \
    }                                                                                              \
    template <class T, int L, class S> TWISTARM_INLINE pack<T, L> operator OP(const pack<T, L>& a, S b) { \
        return a OP pack<T, L>(static_cast<T>(b));                                                 \
    }                                                                                              \
    template <class T, int L, class S> TWISTARM_INLINE pack<T, L> operator OP(S a, const pack<T, L>& b) { \
        return pack<T, L>(static_cast<T>(a)) OP b;                                                 \
    }
TWISTARM_ARITHMETIC(+)
TWISTARM_ARITHMETIC(-)
TWISTARM_ARITHMETIC(*)
TWISTARM_ARITHMETIC(/)
#undef TWISTARM_ARITHMETIC

#define TWISTARM_COMPARISON(OP)                                                                    \
    template <class T, int L> TWISTARM_INLINE mask<T, L> operator OP(const pack<T, L>& a, const pack<T, L>& b) { \
        mask<T, L> c;                                                                              \
        for (int i = 0; i < pack<T, L>::layout::parts; ++i) c.part[i] = a.part[i] OP b.part[i];    \
        return c;                                                                                  \
    }                                                                                              \
    template <class T, int L, class S> TWISTARM_INLINE mask<T, L> operator OP(const pack<T, L>& a, S b) { \
        return a OP pack<T, L>(static_cast<T>(b));                                                 \
    }
TWISTARM_COMPARISON(<)
TWISTARM_COMPARISON(<=)
TWISTARM_COMPARISON(>)
TWISTARM_COMPARISON(>=)
#undef TWISTARM_COMPARISON

template <class T, int L> TWISTARM_INLINE pack<T, L> operator-(const pack<T, L>& a) {
    pack<T, L> c;
    for (int i = 0; i < pack<T, L>::layout::parts; ++i) c.part[i] = -a.part[i];
    return c;
}

template <class T, int L> TWISTARM_INLINE mask<T, L> operator&(const mask<T, L>& a, const mask<T, L>& b) {
    mask<T, L> c;
    for (int i = 0; i < mask<T, L>::layout::parts; ++i) c.part[i] = a.part[i] & b.part[i];
    return c;
}

template <class T, int L> TWISTARM_INLINE mask<T, L> operator|(const mask<T, L>& a, const mask<T, L>& b) {
    mask<T, L> c;
    for (int i = 0; i < mask<T, L>::layout::parts; ++i) c.part[i] = a.part[i] | b.part[i];
    return c;
}

template <class T, int L> TWISTARM_INLINE mask<T, L> operator!(const mask<T, L>& a) {
    mask<T, L> c;
    for (int i = 0; i < mask<T, L>::layout::parts; ++i) c.part[i] = ~a.part[i];
    return c;
}

/// What a comparison of such numbers gives: a mask, or of scalars a bool.
template <class V> using mask_of = decltype(V{} < V{});

/// The type in which numbers of both types are computed.
template <class A, class B> using wider = decltype(A{} * B{});

/// a where the mask holds, else b.
template <class T, int L>
TWISTARM_INLINE mask<T, L> select(const mask<T, L>& m, const mask<T, L>& a, const mask<T, L>& b) {
    return (m & a) | ((!m) & b);
}
template <class T, int L>
TWISTARM_INLINE pack<T, L> select(const mask<T, L>& m, const pack<T, L>& a, const pack<T, L>& b) {
    using floats = typename pack<T, L>::layout::floats;
    using integers = typename pack<T, L>::layout::integers;
    pack<T, L> c;
    for (int i = 0; i < pack<T, L>::layout::parts; ++i) {
        // Small registers have no comparison of 64-bit integers, which m ? a : b would ask for.
        if constexpr (pack<T, L>::layout::bytes <= 16)
            c.part[i] = reinterpret_cast<floats>((reinterpret_cast<integers>(a.part[i]) & m.part[i]) |
                                                 (reinterpret_cast<integers>(b.part[i]) & ~m.part[i]));
        else c.part[i] = m.part[i] ? a.part[i] : b.part[i];
    }
    return c;
}
template <class T> TWISTARM_INLINE T select(bool m, T a, T b) { return m ? a : b; }

/// The square root of each lane.
template <class T, int L> TWISTARM_INLINE pack<T, L> sqrt(const pack<T, L>& a) {
    pack<T, L> c;
    for (int i = 0; i < pack<T, L>::layout::parts; ++i)
        for (int j = 0; j < pack<T, L>::layout::width; ++j)
            c.part[i][j] = static_cast<T>(sizeof(T) == 8 ? __builtin_sqrt(a.part[i][j])
                                                         : __builtin_sqrtf(static_cast<float>(a.part[i][j])));
    return c;
}
TWISTARM_INLINE double sqrt(double a) { return __builtin_sqrt(a); }
TWISTARM_INLINE float sqrt(float a) { return __builtin_sqrtf(a); }

/// The lanes in which the mask holds as bits, lane 0 lowest.
template <class T, int L> TWISTARM_INLINE unsigned bits(const mask<T, L>& m) {
    unsigned all = 0;
    for (int i = 0; i < mask<T, L>::layout::parts; ++i)
        all |= detail::part_bits<T, L>(m.part[i]) << (i * mask<T, L>::layout::width);
    return all;
}
TWISTARM_INLINE unsigned bits(bool m) { return m ? 1U : 0U; }

/// What a kernel needs to know of its number type: its scalar and its lanes.
template <class V> struct number {
    using scalar = V;
    static constexpr int lanes = 1;
};
template <class T, int L> struct number<pack<T, L>> {
    using scalar = T;
    static constexpr int lanes = L;
};
template <class V> using scalar_of = typename number<V>::scalar;

/// The same truth value in every lane.
template <class V> TWISTARM_INLINE mask_of<V> in_every_lane(bool holds) { return V(scalar_of<V>(holds ? 1 : 0)) > V(scalar_of<V>(0)); }

/// Whether the mask holds in any lane, in every lane.
template <class M> TWISTARM_INLINE bool any(const M& m) { return bits(m) != 0U; }
template <class T, int L> TWISTARM_INLINE bool all(const mask<T, L>& m) { return bits(m) == (1U << L) - 1U; }
TWISTARM_INLINE bool all(bool m) { return m; }

template <class V> TWISTARM_INLINE V absolute(const V& a) { return select(a < V(0), -a, a); }
template <class V> TWISTARM_INLINE V least(const V& a, const V& b) { return select(a < b, a, b); }
template <class V> TWISTARM_INLINE V greatest(const V& a, const V& b) { return select(a > b, a, b); }
template <class V> TWISTARM_INLINE V clamped(const V& a, const V& lower, const V& upper) {
    return least(greatest(a, lower), upper);
}

/// One lane of a pack; a scalar is its own only lane.
template <class T, int L> TWISTARM_INLINE T lane(const pack<T, L>& a, int i) { return a[i]; }
template <class T> TWISTARM_INLINE T lane(T a, int) { return a; }
template <class T, int L> TWISTARM_INLINE void set_lane(pack<T, L>& a, int i, T value) { a.set(i, value); }
template <class T> TWISTARM_INLINE void set_lane(T& a, int, T value) { a = value; }

/// A truth value in each lane, from `bits`.
template <class V> TWISTARM_INLINE mask_of<V> lanes_of(unsigned bits) {
    if (bits == 0) return in_every_lane<V>(false);
    V holds;
    for (int l = 0; l < number<V>::lanes; ++l) set_lane(holds, l, scalar_of<V>(bits >> l & 1U));
    return holds > V(scalar_of<V>(0));
}

/// Lane l from first[l · stride]; a scalar from first[0].
template <class V> TWISTARM_INLINE V gathered(const scalar_of<V>* first, int stride) {
    alignas(64) scalar_of<V> values[number<V>::lanes];
    for (int l = 0; l < number<V>::lanes; ++l) values[l] = first[l * stride];
    V all;
    __builtin_memcpy(&all, values, sizeof all);
    return all;
}

/// The bit pattern of a number as an integer as wide, and back.
template <class T, int L> TWISTARM_INLINE bit_pack<T, L> to_bits(const pack<T, L>& a) {
    bit_pack<T, L> c;
    for (int i = 0; i < pack<T, L>::layout::parts; ++i)
        c.part[i] = reinterpret_cast<typename pack<T, L>::layout::integers>(a.part[i]);
    return c;
}
TWISTARM_INLINE std::int64_t to_bits(double a) {
    std::int64_t c;
    __builtin_memcpy(&c, &a, sizeof c);
    return c;
}
TWISTARM_INLINE std::int32_t to_bits(float a) {
    std::int32_t c;
    __builtin_memcpy(&c, &a, sizeof c);
    return c;
}

/// a with its sign flipped where bit `bit` of `pattern` + `shift` is set.
template <class T, int L>
TWISTARM_INLINE pack<T, L> flip_sign(const pack<T, L>& a, const bit_pack<T, L>& pattern, int shift, int bit) {
    using integers = typename pack<T, L>::layout::integers;
    using unsigned_integer = std::make_unsigned_t<typename pack<T, L>::layout::integer>;
    typedef unsigned_integer unsigned_integers __attribute__((vector_size(pack<T, L>::layout::bytes)));
    constexpr int top = static_cast<int>(sizeof(T)) * 8 - 1;
    constexpr auto sign = static_cast<unsigned_integer>(unsigned_integer{1} << top);
    pack<T, L> c;
    for (int i = 0; i < pack<T, L>::layout::parts; ++i) {
        auto word = reinterpret_cast<unsigned_integers>(pattern.part[i]) + static_cast<unsigned_integer>(shift);
        auto flip = (word << (top - bit)) & sign;
        c.part[i] = reinterpret_cast<typename pack<T, L>::layout::floats>(
            reinterpret_cast<integers>(a.part[i]) ^ reinterpret_cast<integers>(flip));
    }
    return c;
}
template <class T, class I> TWISTARM_INLINE T flip_sign(T a, I pattern, int shift, int bit) {
    return (((pattern + shift) >> bit) & 1) != 0 ? -a : a;
}

/// Where the lowest bit is set.
template <class T, int L> TWISTARM_INLINE mask<T, L> is_odd(const bit_pack<T, L>& pattern) {
    mask<T, L> c;
    for (int i = 0; i < mask<T, L>::layout::parts; ++i) c.part[i] = -(pattern.part[i] & 1);
    return c;
}
template <class I> TWISTARM_INLINE bool is_odd(I pattern) { return (pattern & 1) != 0; }

TWISTARM_END
