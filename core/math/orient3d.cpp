#include "core/math/orient3d.h"

#include <array>

namespace hapton {
namespace {

// An exact sum of doubles that do not overlap, smallest first, without zeros.
template <int N>
struct Expansion {
  std::array<double, N> part;
  int count = 0;

  void add(double x) {
    if (x != 0.0) part[count++] = x;
  }
};

struct Exact {
  double value;
  double error;  // value + error is exact
};

Exact two_sum(double a, double b) {
  const double s = a + b;
  const double from_b = s - a;
  return {s, (a - (s - from_b)) + (b - from_b)};
}

// Pre: |a| >= |b| or a == 0.
Exact fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

Exact two_product(double a, double b) {
  const double p = a * b;
  return {p, std::fma(a, b, -p)};
}

Expansion<2> difference(double a, double b) {
  const Exact d = two_sum(a, -b);
  Expansion<2> e;
  e.add(d.error);
  e.add(d.value);
  return e;
}

// Returns e times b, exactly (Shewchuk 1997, SCALE-EXPANSION).
template <int N>
Expansion<2 * N> scale(const Expansion<N>& e, double b) {
  Expansion<2 * N> h;
  if (e.count == 0 || b == 0.0) return h;
  Exact q = two_product(e.part[0], b);
  h.add(q.error);
  for (int i = 1; i < e.count; ++i) {
    const Exact t = two_product(e.part[i], b);
    const Exact low = two_sum(q.value, t.error);
    h.add(low.error);
    q = fast_two_sum(t.value, low.value);
    h.add(q.error);
  }
  h.add(q.value);
  return h;
}

// Returns e + f, exactly (Shewchuk 1997, FAST-EXPANSION-SUM): merges the parts by magnitude, then adds them up from the smallest.
template <int N, int M>
Expansion<N + M> sum(const Expansion<N>& e, const Expansion<M>& f) {
  Expansion<N + M> h;
  std::array<double, N + M> merged;
  int i = 0;
  int j = 0;
  int n = 0;
  while (i < e.count || j < f.count) {
    const bool take_e = j == f.count || (i < e.count && std::fabs(e.part[i]) < std::fabs(f.part[j]));
    merged[n++] = take_e ? e.part[i++] : f.part[j++];
  }
  if (n == 0) return h;
  double q = merged[0];
  for (int k = 1; k < n; ++k) {
    const Exact s = k == 1 ? fast_two_sum(merged[k], q) : two_sum(q, merged[k]);
    h.add(s.error);
    q = s.value;
  }
  h.add(q);
  return h;
}

template <int N>
Expansion<4 * N> product(const Expansion<N>& e, const Expansion<2>& f) {
  Expansion<4 * N> total;
  if (f.count == 0) return total;
  if (f.count == 1) {
    const Expansion<2 * N> one = scale(e, f.part[0]);
    for (int i = 0; i < one.count; ++i) total.add(one.part[i]);
    return total;
  }
  return sum(scale(e, f.part[0]), scale(e, f.part[1]));
}

template <int N>
Expansion<N> negated(Expansion<N> e) {
  for (int i = 0; i < e.count; ++i) e.part[i] = -e.part[i];
  return e;
}

// The sum, correct up to the last few bits, because the parts do not overlap.
template <int N>
double value_of(const Expansion<N>& e) {
  double value = 0.0;
  for (int i = 0; i < e.count; ++i) value += e.part[i];
  return value;
}

}  // namespace

double orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept {
  std::array<Expansion<2>, 3> u;
  std::array<Expansion<2>, 3> v;
  std::array<Expansion<2>, 3> w;
  for (int k = 0; k < 3; ++k) {
    u[k] = difference(b[k], a[k]);
    v[k] = difference(c[k], a[k]);
    w[k] = difference(d[k], a[k]);
  }
  const auto term = [&](int x, int y, int z) {  // (u_x v_y - u_y v_x) w_z
    return product(sum(product(u[x], v[y]), negated(product(u[y], v[x]))), w[z]);
  };
  return value_of(sum(sum(term(0, 1, 2), term(1, 2, 0)), term(2, 0, 1)));
}

}  // namespace hapton
