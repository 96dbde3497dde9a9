#pragma once

#include <string>

namespace hapton {

// The text with this name in `object`; empty: there is none. Json: nlohmann's json or ordered_json. RT: no.
template <class Json>
std::string json_text_of(const Json& object, const char* name) {
  if (!object.is_object()) return {};
  const auto value = object.find(name);
  return value != object.end() && value->is_string() ? value->template get<std::string>() : std::string();
}

}  // namespace hapton
