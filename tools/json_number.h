#pragma once

namespace hapton {

// The number with this name in `object`; 0: there is none. Json: nlohmann's json or ordered_json. RT: no.
template <class Json, class Name>
double json_number_of(const Json& object, const Name& name) {
  if (!object.is_object()) return 0.0;
  const auto value = object.find(name);
  return value != object.end() && value->is_number() ? value->template get<double>() : 0.0;
}

// The number with this name in this section of a report; 0: there is none.
template <class Json>
double json_number_of(const Json& report, const char* section, const char* name) {
  const auto found = report.find(section);
  return found == report.end() ? 0.0 : json_number_of(*found, name);
}

}  // namespace hapton
