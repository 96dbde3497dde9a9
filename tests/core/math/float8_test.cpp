#include "core/math/float8.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hapton {
namespace {

#if defined(__AVX2__) && defined(__FMA__)

// Bit patterns that matter: zeros, subnormals, infinities, NaN, ordinary numbers, masks.
class Patterns {
 public:
  float next() {
    switch (random_() % 8) {
      case 0:
        return kSpecial[random_() % kSpecial.size()];
      case 1:
        return std::bit_cast<float>(static_cast<std::uint32_t>(random_()));
      default:
        return static_cast<float>(static_cast<std::int32_t>(random_())) * 0x1p-20F;
    }
  }
  double next_double() { return static_cast<double>(next()) * (1.0 + 0x1p-30 * static_cast<double>(random_() % 64)); }
  std::uint32_t word() { return random_() % 3 == 0 ? static_cast<std::uint32_t>(random_() % 3) : static_cast<std::uint32_t>(random_()); }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  static constexpr std::array<float, 9> kSpecial = {0.0F, -0.0F, 1.0F, -1.0F, 0x1p-140F, kInfinity, -kInfinity, 0x1p31F, -0x1p31F};
  std::mt19937_64 random_{20261121};
};

// The payload of a NaN is not compared.
std::uint32_t bits_of(float x) {
  return std::isnan(x) && std::bit_cast<std::uint32_t>(x) != 0xFFFFFFFFU ? 0x7FC00000U : std::bit_cast<std::uint32_t>(x);
}

struct alignas(32) Input {
  float a[8], b[8], c[8];
  std::uint32_t u[8], w[8];
  double d[4], e[4];
};

Input draw(Patterns& patterns) {
  Input in;
  for (int i = 0; i < 8; ++i) {
    in.a[i] = patterns.next();
    in.b[i] = i % 3 == 0 ? in.a[i] : patterns.next();
    in.c[i] = patterns.next();
    in.u[i] = patterns.word();
    in.w[i] = i % 2 == 0 ? in.u[i] : patterns.word();
  }
  for (int i = 0; i < 4; ++i) {
    in.d[i] = patterns.next_double();
    in.e[i] = patterns.next_double();
  }
  return in;
}

using Bits = std::vector<std::uint32_t>;

template <class F>
void append(Bits& bits, F a, int lanes) {
  alignas(32) float out[8];
  store(out, a);
  for (int i = 0; i < lanes; ++i) bits.push_back(bits_of(out[i]));
}

// Calls every function of one implementation, always in the same order.
template <class Float8, class Uint32x8, class Float4, class Int4, class Double4>
Bits run(const Input& in) {
  Bits bits;
  const auto a = Float8::load(in.a), b = Float8::load(in.b), c = Float8::load(in.c);
  for (const auto& r : {a + b, a - b, a * b, a / b, a<b, a <= b, a> b, a >= b, min(a, b), max(a, b), sqrt(a), fma(a, b, c), fms(a, b, c),
                        select(a, b, c), Float8(in.a[0])})
    append(bits, r, 8);
  for (const auto& r : {a & b, a | b, a ^ b, and_not(a, b)}) bits.push_back(sum(as_words(r)));
  bits.push_back(sign_bits(a));
  const auto u = Uint32x8::load(in.u), w = Uint32x8::load_unaligned(in.w);
  for (const auto& r : {u + w, u & w, u | w, u ^ w, u == w, Uint32x8(in.u[0])}) {
    bits.push_back(sum(r));
    bits.push_back(sign_bits(r));
  }
  Float4 p(in.a[0], in.a[1], in.a[2], in.a[3]);
  Float4 q = Float4::load_unaligned(in.b + 1);
  for (const auto& r : {p + q, p - q, p * q, min(p, q), max(p, q), Float4(in.c[0])}) append(bits, r, 4);
  bits.push_back(last_word(p));
  bits.push_back(last_word(with_last_word(p, in.u[0])));
  alignas(16) std::int32_t whole[4];
  const auto i = Int4::truncated(p), k = Int4::truncated(q);
  for (const auto& r : {i, min(i, k), max(i, k), i > k, Int4(static_cast<int>(in.u[1]))}) {
    store(whole, r);
    for (const std::int32_t x : whole) bits.push_back(static_cast<std::uint32_t>(x));
    bits.push_back(sign_bits(r));
  }
  Float4 r(in.c[0], in.c[1], in.c[2], in.c[3]), s(in.c[4], in.c[5], in.c[6], in.c[7]);
  transpose(p, q, r, s);
  for (const auto& row : {p, q, r, s}) append(bits, row, 4);
  const auto d = Double4::load(in.d), e = Double4::load_three(in.e);
  for (const auto& x : {d + e, d - e, d * e, d / e, sqrt(d), min(d, e), max(d, e), select(d, e, d + e), Double4(in.d[0])})
    append(bits, rounded(x), 4);
  bits.push_back(sign_bits(d < e));
  bits.push_back(sign_bits(d <= e));
  bits.push_back(sign_bits(d));
  Double4 rows[4] = {d, e, d + e, d - e};
  transpose(rows[0], rows[1], rows[2], rows[3]);
  for (const auto& row : rows) append(bits, rounded(row), 4);
  alignas(32) double stored[4];
  store(stored, d);
  for (const double x : stored) append(bits, rounded(Double4(x)), 4);
  return bits;
}

TEST(Float8, TheScalarTwinHasTheSameBits) {
  Patterns patterns;
  for (int n = 0; n < 20'000; ++n) {
    const Input in = draw(patterns);
    ASSERT_EQ((run<avx2::Float8, avx2::Uint32x8, avx2::Float4, avx2::Int4, avx2::Double4>(in)),
              (run<scalar::Float8, scalar::Uint32x8, scalar::Float4, scalar::Int4, scalar::Double4>(in)))
        << "input " << n;
  }
}

#endif

TEST(Float8, SelectsByTheSignOfTheMask) {
  alignas(32) float out[8];
  store(out, select(Float8(-0.0F), Float8(1.0F), Float8(2.0F)));
  EXPECT_EQ(out[7], 1.0F);
  store(out, select(Float8(3.0F), Float8(1.0F), Float8(2.0F)));
  EXPECT_EQ(out[0], 2.0F);
}

TEST(Float8, ComparesFalseWithNaN) {
  const Float8 nan(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(sign_bits((nan < Float8(1.0F)) | (nan >= Float8(1.0F))), 0U);
  EXPECT_EQ(sign_bits(Float8(1.0F) < Float8(2.0F)), 0xFFU);
}

}  // namespace
}  // namespace hapton
