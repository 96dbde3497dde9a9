#include "link/object_choice.h"

#include <charconv>
#include <string>

#include "link/wire_fields.h"

namespace hapton {

Result<void> choose_object(std::string_view object, std::array<char, 256>& name, std::int32_t& number) {
  if (object.starts_with('#')) {
    const char* const end = object.data() + object.size();
    const auto [stop, error] = std::from_chars(object.data() + 1, end, number);
    if (error == std::errc() && stop == end && number >= 0) return {};
    return fail("'{}' is not the number of an object; give #N with N from 0, or its name", object);
  }
  if (object.empty()) return fail("no object is named; give its name, or #N with its number from 0");
  if (!read_text(std::string(object), name)) return fail("the name of an object must be one line of at most 255 bytes");
  return {};
}

}  // namespace hapton
