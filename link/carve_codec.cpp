#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "hapton.pb.h"
#include "link/protobuf_codec.h"
#include "link/wire_fields.h"

// Converts messages about carves to and from their form in proto/hapton.proto.
namespace hapton {
namespace {

constexpr int kNumbersOfOne = 7;  // of one carve: x, y, z of both its ends, its radius
static_assert(Carves::kMax == 32, "a bit for each entry");

constexpr std::uint32_t bit_of(std::size_t entry) { return std::uint32_t{1} << entry; }

template <class Numbers>
void read_point(const Numbers& from, int first, Carves::Point& to) {
  for (int axis = 0; axis < 3; ++axis) to[static_cast<std::size_t>(axis)] = from.Get(first + axis);
}

// False for NaN as well.
bool is_point(const Carves::Point& p) {
  for (const float x : p) {
    if (!(std::abs(x) <= static_cast<float>(kMaxWireMagnitude))) return false;
  }
  return true;
}

bool is_carve(const Carves::One& one) {
  if (!is_point(one.from_m) || !is_point(one.to_m)) return false;
  const Vec3 along(static_cast<double>(one.to_m[0]) - one.from_m[0], static_cast<double>(one.to_m[1]) - one.from_m[1],
                   static_cast<double>(one.to_m[2]) - one.from_m[2]);
  return along.norm() <= Carves::kMaxLengthM && one.radius_m > 0.0F && one.radius_m <= Carves::kMaxRadiusM;
}

}  // namespace

void write(const Carves& from, wire::Carves& to) {
  to.set_source(from.source);
  to.set_newest(from.newest);
  to.set_first(from.first);
  to.mutable_object()->Clear();
  to.mutable_numbers()->Clear();
  to.mutable_undone()->Clear();
  std::uint32_t begins = 0;
  std::uint32_t undoes = 0;
  for (std::size_t n = 0; n < std::min<std::size_t>(from.count, Carves::kMax); ++n) {
    const Carves::One& one = from.carves[n];
    to.mutable_object()->AddAlreadyReserved(one.is_undo() ? 0 : static_cast<std::uint32_t>(one.object));
    if (one.is_undo()) {
      undoes |= bit_of(n);
      to.mutable_undone()->AddAlreadyReserved(one.undone_first);
      to.mutable_undone()->AddAlreadyReserved(one.undone_last);
      continue;
    }
    begins |= one.begins ? bit_of(n) : 0;
    add_numbers(one.from_m, *to.mutable_numbers());
    add_numbers(one.to_m, *to.mutable_numbers());
    to.mutable_numbers()->AddAlreadyReserved(one.radius_m);
  }
  to.set_begins(begins);
  to.set_undoes(undoes);
}

void write(const CarveUndo& from, wire::CarveUndo& to) {
  to.set_source(from.source);
  to.set_serial(from.serial);
}

void write(const CarveStatus& from, wire::CarveStatus& to) {
  to.set_source(from.source);
  to.set_complete(from.complete);
}

bool read(const wire::Carves& from, Carves& to) {
  to.source = from.source();
  to.newest = from.newest();
  to.first = from.first();
  const int count = from.object().size();
  if (to.source == 0 || count > static_cast<int>(Carves::kMax)) return false;
  const std::uint64_t all = (std::uint64_t{1} << static_cast<unsigned>(count)) - 1;
  if ((from.undoes() & ~all) != 0 || (from.begins() & ~all) != 0 || (from.begins() & from.undoes()) != 0) return false;
  const int undoes = std::popcount(from.undoes());
  if (from.numbers().size() != kNumbersOfOne * (count - undoes) || from.undone().size() != 2 * undoes) return false;
  to.count = static_cast<std::uint32_t>(count);
  if ((to.count > 0) != (to.first > 0)) return false;
  // The last entry must not be newer than `newest`.
  if (to.count > 0 && (to.first > to.newest || to.newest - to.first < to.count - 1)) return false;
  int carve = 0;
  int undo = 0;
  for (int n = 0; n < count; ++n) {
    Carves::One& one = to.carves[static_cast<std::size_t>(n)];
    one = {};
    if ((from.undoes() & bit_of(static_cast<std::size_t>(n))) != 0) {
      one.object = -1;
      one.undone_first = from.undone().Get(2 * undo);
      one.undone_last = from.undone().Get(2 * undo + 1);
      ++undo;
      const std::uint32_t serial = to.first + static_cast<std::uint32_t>(n);
      if (one.undone_first == 0 || one.undone_last < one.undone_first || one.undone_last >= serial) return false;
      continue;
    }
    one.begins = (from.begins() & bit_of(static_cast<std::size_t>(n))) != 0;
    if (from.object().Get(n) > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max())) return false;
    one.object = static_cast<std::int32_t>(from.object().Get(n));
    const int first = kNumbersOfOne * carve++;
    read_point(from.numbers(), first, one.from_m);
    read_point(from.numbers(), first + 3, one.to_m);
    one.radius_m = from.numbers().Get(first + 6);
    if (!is_carve(one)) return false;
  }
  return true;
}

bool read(const wire::CarveUndo& from, CarveUndo& to) {
  to.source = from.source();
  to.serial = from.serial();
  return to.source != 0 && to.serial != 0;
}

bool read(const wire::CarveStatus& from, CarveStatus& to) {
  to.source = from.source();
  to.complete = from.complete();
  return to.source != 0;
}

}  // namespace hapton
