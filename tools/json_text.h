#pragma once

#include <string>

namespace hapton {

// The text with this name in the object `of`; empty: there is none. Json: nlohmann's json or ordered_json. RT: no.
template <class Json>
std::string json_text_of(const Json& of, const char* name) {
  if (!of.is_object()) return {};
  const auto value = of.find(name);
  return value != of.end() && value->is_string() ? value->template get<std::string>() : std::string();
}

}  // namespace hapton
