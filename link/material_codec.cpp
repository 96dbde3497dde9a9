#include <cmath>

#include "hapton.pb.h"
#include "link/protobuf_codec.h"
#include "link/wire_fields.h"

// Converts the messages that change materials to and from their form in proto/hapton.proto.
namespace hapton {
namespace {

constexpr int kNumbersOfChange = 4;

// False: a number is invalid. Numbers that are not given must be zero, so that equal changes have equal bytes.
bool read_change(std::uint32_t fields, const std::array<double, kNumbersOfChange>& numbers, MaterialChange& to) {
  if (fields > MaterialChange::kAll) return false;
  for (int i = 0; i < kNumbersOfChange; ++i) {
    const bool is_given = (fields >> i & 1U) != 0;
    if (is_given ? !is_amount(numbers[i]) : numbers[i] != 0.0) return false;
  }
  to = {fields, numbers[0], numbers[1], numbers[2], numbers[3]};
  return true;
}

}  // namespace

void write(const MaterialRequest& from, wire::MaterialRequest& to) {
  to.set_request(from.request);
  write_text(from.object, *to.mutable_object());
  const MaterialChange& change = from.change;
  if ((change.fields & MaterialChange::kStiffness) != 0) to.set_stiffness_n_per_m(change.stiffness_n_per_m);
  if ((change.fields & MaterialChange::kDamping) != 0) to.set_damping_ns_per_m(change.damping_ns_per_m);
  if ((change.fields & MaterialChange::kFrictionStatic) != 0) to.set_friction_static(change.friction_static);
  if ((change.fields & MaterialChange::kFrictionDynamic) != 0) to.set_friction_dynamic(change.friction_dynamic);
}

void write(const MaterialState& from, wire::MaterialState& to) {
  to.set_serial(from.serial);
  to.set_request(from.request);
  write_text(from.rejection, *to.mutable_rejection());
  to.mutable_object()->Clear();
  to.mutable_given()->Clear();
  to.mutable_numbers()->Clear();
  for (std::size_t i = 0; i < std::min<std::size_t>(from.object_count, from.objects.size()); ++i) {
    const MaterialChange& change = from.objects[i].change;
    to.mutable_object()->AddAlreadyReserved(from.objects[i].object);
    to.mutable_given()->AddAlreadyReserved(change.fields);
    add_numbers(std::array{change.stiffness_n_per_m, change.damping_ns_per_m, change.friction_static, change.friction_dynamic},
                *to.mutable_numbers());
  }
}

bool read(const wire::MaterialRequest& from, MaterialRequest& to) {
  to.request = from.request();
  const std::uint32_t fields = (from.has_stiffness_n_per_m() ? MaterialChange::kStiffness : 0U) |
                               (from.has_damping_ns_per_m() ? MaterialChange::kDamping : 0U) |
                               (from.has_friction_static() ? MaterialChange::kFrictionStatic : 0U) |
                               (from.has_friction_dynamic() ? MaterialChange::kFrictionDynamic : 0U);
  return to.request != 0 && fields != 0 && read_text(from.object(), to.object) &&
         read_change(fields, {from.stiffness_n_per_m(), from.damping_ns_per_m(), from.friction_static(), from.friction_dynamic()},
                     to.change);
}

bool read(const wire::MaterialState& from, MaterialState& to) {
  to.serial = from.serial();
  to.request = from.request();
  const int count = from.object_size();
  if (count > static_cast<int>(to.objects.size()) || from.given_size() != count || from.numbers_size() != kNumbersOfChange * count) {
    return false;
  }
  to.object_count = static_cast<std::uint32_t>(count);
  for (int i = 0; i < count; ++i) {
    MaterialState::Object& object = to.objects[static_cast<std::size_t>(i)];
    object.object = from.object(i);
    // The entry for all objects (-1) comes first, then ascending numbers, each once.
    if (object.object < -1 || (i > 0 && object.object <= to.objects[static_cast<std::size_t>(i) - 1].object)) return false;
    const int first = kNumbersOfChange * i;
    if (!read_change(from.given(i), {from.numbers(first), from.numbers(first + 1), from.numbers(first + 2), from.numbers(first + 3)},
                     object.change)) {
      return false;
    }
  }
  return read_text(from.rejection(), to.rejection);
}

}  // namespace hapton
