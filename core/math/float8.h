#pragma once

// Vector lanes for the hot path: eight floats (Float8), eight words (Uint32x8), and the four-lane types from which those are filled
// (Float4, Int4, Double4). Two implementations with one interface and the same results to the last bit: AVX2 with FMA, and a scalar twin
// for any other processor or with -DHAPTON_SCALAR. No other file uses the vector instructions of a processor.
//
//   Float8(x), Uint32x8(x) ...   x in every lane; a float converts to a Float8
//   a[i], set_lane(i, x)         one lane
//   load, store                  aligned to the size of the type, except load_unaligned; load_three sets the last lane to 0
//   + - * /, sqrt, fma, fms      rounded once; fma(a, b, c) = a b + c, fms(a, b, c) = a b - c
//   < <= > >= ==                 a mask: all bits of a lane set where true; false for NaN
//   & | ^, and_not(a, b)         bitwise; and_not = ~a & b
//   min, max                     b where the lanes are equal or one is NaN
//   select(mask, set, clear)     by the sign bit of the mask
//   sign_bits, sum               bit i: the sign of lane i; the sum of the lanes, modulo 2^32
//   last_word, with_last_word    the bits of lane 3; a copy with other bits there
//   truncated, rounded           to integers towards zero, -2^31 where that is impossible; to the nearest floats
//   as_floats, as_words          the same bits as the other type; transpose exchanges rows and columns of four
// RT: yes.

#include "core/math/float8_avx2.h"
#include "core/math/float8_scalar.h"

namespace hapton {

#if defined(__AVX2__) && defined(__FMA__) && !defined(HAPTON_SCALAR)
namespace simd = avx2;
#else
namespace simd = scalar;
#endif

using simd::Double4;
using simd::Float4;
using simd::Float8;
using simd::Int4;
using simd::Uint32x8;

}  // namespace hapton
