#include "scene/gltf/json.h"

namespace hapton::gltf {
namespace {

constexpr double kMaxExactInteger = 9007199254740992.0;  // 2^53

}  // namespace

const Json& member(const Json& object, const char* key) {
  static const auto& none = *new Json;  // never destroyed: a thread of StoppableCalls may use it while the program ends
  if (!object.is_object()) return none;
  const auto found = object.find(key);
  return found == object.end() ? none : *found;
}

const Json& extension_of(const Json& object, const char* name) { return member(member(object, "extensions"), name); }

std::size_t size_of_array(const Json& array) { return array.is_array() ? array.size() : 0; }

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); }

Result<std::size_t> count_of(const Json& value, const std::string& where) {
  if (!value.is_number()) return fail("{} is missing or not a number: {}", where, kExportAgain);
  const double number = value.get<double>();
  if (!(number >= 0 && number < kMaxExactInteger) || number != std::floor(number)) {
    return fail("{} is {}, not a count: {}", where, number, kExportAgain);
  }
  return static_cast<std::size_t>(number);
}

Result<std::size_t> count_or(const Json& value, std::size_t absent, const std::string& where) {
  if (value.is_null()) return absent;
  return count_of(value, where);
}

Result<std::size_t> index_of(const Json& value, const Json& array, const std::string& where) {
  Result<std::size_t> index = count_of(value, where);
  if (index && *index >= size_of_array(array)) {
    return fail("{} is {}, out of range: there are {}; {}", where, *index, size_of_array(array), kExportAgain);
  }
  return index;
}

}  // namespace hapton::gltf
